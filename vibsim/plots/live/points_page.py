"""What the page of a table of points holds: its columns, words, and the command that runs each point."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.labelled.arrays import Arrays
from vibsim.labelled.tidy import Tidy
from vibsim.plots.errors import PlotError
from vibsim.plots.live.html_file import packed
from vibsim.plots.registry import fitting
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import draws_by_ratio

KEYS = (
    "Point at a point to read its numbers and the command that runs it. Wheel: zoom; drag: move; "
    "double click: everything. Keys: arrows, + and -, 0 everything, n and p the next point and the one "
    "before, d light or dark."
)
MOST_POINTS = 100_000
MOST_CARRIED = 400  # points whose start is looked up in the points before them
FIRST = {"sommerfeld": "mean_speed", "amplitude": "amplitude_relative"}  # what is shown first, by kind
HIDDEN = ("sha256",)


def points_data(subject: Subject) -> dict[str, Any]:
    """The data of `points.js`. Raises PlotError for a table that is too large, or has no numbers."""
    arrays = subject.result.arrays()
    table = Tidy(arrays)
    if table.count > MOST_POINTS:
        raise PlotError(f"{subject.path}: {table.count} points are too many for a page, {MOST_POINTS} go")
    columns = [*_columns(table, _by_ratio(subject)), *_further(arrays, table)]
    for column in columns:
        column |= _titled(subject, column["name"])
    numbers = [column["name"] for column in columns if column["name"] not in table.dims]
    if not numbers:
        raise PlotError(f"{subject.path}: no numbers to draw")
    texts = {
        name: [str(text) for text in table.values(name)]
        for name, column in table.columns.items()
        if column.dtype == "text" and name not in HIDDEN
    }
    return {
        "count": table.count,
        "columns": columns,
        "texts": texts,
        "commands": commands(subject),
        **_first(subject, table, numbers),
        **_lines(subject),
    }


def _lines(subject: Subject) -> dict[str, Any]:
    """The curve that the points of a branch or a locus lie on."""
    if subject.reads not in ("branch", "locus"):
        return {}
    from vibsim.plots.live.lines import lines_data, locus_data

    return (lines_data if subject.reads == "branch" else locus_data)(subject.result)


def _titled(subject: Subject, name: str) -> dict[str, str]:
    """The key of the case that a column of a branch or a locus is about, as it is called on the page."""
    if subject.reads == "branch":
        keys = {"parameter": subject.result.key}
    elif subject.reads == "locus":
        plan = subject.result.plan
        keys = {"parameter": plan.branch.keys[0], "second": plan.keys[0]}
    else:
        return {}
    return {"title": keys[name]} if name in keys else {}


def _by_ratio(subject: Subject) -> set[str]:
    """Names of the axes of a sweep that are drawn on a logarithmic scale."""
    axes = subject.result.axes if subject.reads == "sweep" else ()
    return {axis.name for axis in axes if draws_by_ratio(axis)}


def _columns(table: Tidy, by_ratio: Collection[str]) -> list[dict[str, Any]]:
    return [
        _column(name, column, table.values(name), 1) | ({"log": True} if name in by_ratio else {})
        for name, column in table.columns.items()
        if column.dtype != "text"
    ]


def _further(arrays: Arrays, table: Tidy) -> list[dict[str, Any]]:
    """Columns of several values per point."""
    columns = []
    for name, dataset in arrays.datasets.items():
        if len(dataset.dims) == len(table.dims) + 1 and dataset.dims[:-1] == table.dims:
            values = np.asarray(arrays.read(name))
            columns.append(_column(name, dataset.column, values.reshape(table.count, -1), values.shape[-1]))
    return columns


def _column(name: str, column: Any, values: np.ndarray, width: int) -> dict[str, Any]:
    words = {"words": {code: word for word, code in column.flags.items()}} if column.flags else {}
    unit = "" if column.units in (None, "1") else column.units
    return {"name": name, "unit": unit, "width": width, "data": packed(values, "f8"), **words}


def _first(subject: Subject, table: Tidy, numbers: Sequence[str]) -> dict[str, Any]:
    """What is drawn at first: along the first axis, what the kinds that fit show, coloured by the second."""
    known = [FIRST[kind.name] for kind in fitting([subject]) if FIRST.get(kind.name) in numbers]
    shown = [*known, *(name for name in numbers if name not in known)][:2]
    lengths, hinted = table.arrays.lengths, table.arrays.shown
    if hinted:
        return {"x": hinted[0], "y": list(hinted[1:3]), "colour": ""}
    several = [name for name in table.dims if lengths[name] > 1 and name in table.columns]
    x = several[0] if several else next(iter(table.columns))
    return {"x": x, "y": [shown[0], shown[-1]], "colour": several[1] if len(several) > 1 else ""}


def commands(subject: Subject) -> list[str] | None:
    """The command line that runs each point, in the order of the table; None where a point is no run."""
    if subject.reads in ("branch", "locus"):
        return [_written(subject, _differences(subject, point)) for point in range(len(subject.result))]
    if subject.reads != "sweep":
        return None
    plan = subject.result.plan
    return [_command(subject, index) for index in product(*map(range, plan.shape))]


def _command(subject: Subject, index: tuple[int, ...]) -> str:
    result = subject.result
    changes = dict(result.plan.changes(index))
    remark = ""
    if result.plan.carry and result.plan.count <= MOST_CARRIED:
        own, case = result.case.values, result.case_at(index).values
        changes |= {key: str(value) for key, value in case.items() if str(own.get(key)) != str(value)}
    elif result.plan.carry:
        remark = "  # begins from the end of the point before"
    return _written(subject, changes) + remark


def _differences(subject: Subject, point: int) -> dict[str, str]:
    """What the case of an orbit has other than that of its branch or locus."""
    own, case = subject.result.case.values, subject.result.case_at(point).values
    return {key: str(value) for key, value in case.items() if str(own.get(key)) != str(value)}


def _written(subject: Subject, changes: Mapping[str, str]) -> str:
    words = [f"-s {shlex.quote(f'{key}={text}')}" for key, text in changes.items()]
    return f"vibsim run {shlex.quote(_source(subject))} {' '.join(words)} -o point.h5"


def _source(subject: Subject) -> str:
    """What names the case in a command: the sweep's file; of a sweep in memory the case's own source."""
    return Path(subject.path).name if Path(subject.path).is_file() else subject.case.source

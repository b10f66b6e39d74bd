"""Pages that answer: one HTML file that needs no network, with zoom, hover and linked panels.

The scripts are plain JavaScript on a canvas: `axes.js` for every page, `run.js` for runs, `points.js` for
tables of points, with `lines.js` where these lie on a curve, `animate.js` for moving machines.
"""

from __future__ import annotations

import base64
import json
import re
import shlex
from collections.abc import Collection, Iterator, Mapping, Sequence
from html import escape
from itertools import groupby, product
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from vibsim.cases.problems import counted, one_line
from vibsim.orbits.branches.tracing import curve_of, drawn, stretches
from vibsim.physics.connections import event_parts
from vibsim.physics.parts import EVENT_KINDS, IMPACTS, ROTOR, STATE, SWITCH
from vibsim.plots.branch_curves import MARKS, ParameterAxis, ranges
from vibsim.plots.branches_over_sweeps import NAMES
from vibsim.plots.registry import fitting
from vibsim.plots.samples import shortest_period
from vibsim.plots.sheet import scale_for
from vibsim.plots.subject import PlotError, Subject
from vibsim.plots.sweep_axes import draws_by_ratio, is_speed, label_of, words_of
from vibsim.plots.traces import pair_of
from vibsim.results.columns import has_switches
from vibsim.results.hdf5_reading import plain
from vibsim.results.labelled import Arrays, Labelled, Tidy
from vibsim.results.output_files import output_file

# A page as one file: style, data and script in it, nothing from elsewhere.


ROOM = Path(__file__).with_name("live")


def write_page(subjects: Sequence[Subject], out: str, force: bool = False) -> list[str]:
    """Write the page of a run, or of any other result of points, to `out`; the names of the files written.

    Raises PlotError for several results and for what has no page, ResultFileError where it cannot be written.
    """
    if len(subjects) > 1:
        raise PlotError(f"{out}: a page shows one result; give one FILE")
    (subject,) = subjects
    if subject.reads == "trajectory":
        text = page(subject, ("run.js",), RUN_KEYS, run_data(subject))
    elif isinstance(subject.result, Labelled):
        text = page(subject, ("lines.js", "points.js"), POINTS_KEYS, points_data(subject))
    else:
        shown = f"{subject.path} is a {subject.reads}"
        raise PlotError(f"{out}: a page shows a run or a table of points, and {shown}")
    with output_file(out, force, "utf-8") as file:
        file.write(text)
    return [out]


def page(subject: Subject, scripts: tuple[str, ...], keys: str, data: dict[str, Any]) -> str:
    """The HTML text; scripts: behind the one that every page has."""
    case = subject.case
    title = one_line(f"{case.name}: {case.title}" if case.title else case.name)
    about = "; ".join(f"{label} {text}" for label, text in subject.result.lines() if label in ABOUT)
    scripts = ("axes.js", *scripts)
    return Template((ROOM / "page.html").read_text(encoding="utf-8")).substitute(
        title=escape(title),
        about=escape(one_line(f"{subject.result.heading()}; {about}" if about else subject.result.heading())),
        style=(ROOM / "page.css").read_text(encoding="utf-8"),
        script="\n".join((ROOM / name).read_text(encoding="utf-8") for name in scripts),
        keys=escape(keys),
        data=script_text(data),
    )


ABOUT = ("motion", "right", "certificate", "start")  # lines of a result that stand below the title


def script_text(data: dict[str, Any]) -> str:
    """JSON that may stand in a script element: no text in it ends the element."""
    text = json.dumps(plain(data), allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def packed(values: Any, dtype: str) -> str:
    """Numbers as base64, little endian."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=f"<{dtype}").tobytes()).decode("ascii")


# The lines of a page of a branch or a locus: its curve between the points, and the special points on it.
#
# Parameters, period and state are taken on the curve through points and tangents, as pictures have it; what
# only the map tells (multipliers, test values) goes straight from one computed orbit to the next.


STABILITY = ("unstable", "stable")  # what the pieces of a curve are, by number
WORDS = ("label", "kind", "before", "after")  # texts of a special point beside its numbers


def lines_data(branch: Any) -> dict[str, Any]:
    """The curve of a branch in pieces whose orbits are all stable, or all not, and its special points."""
    places = [_place(point.orbit) for point in branch.points]
    sizes = np.array([np.inf, *ranges(places)])  # the share of the way, which comes first, is not drawn
    pieces, rows = [], list[np.ndarray]()
    multipliers = np.array(branch.points[0].orbit.multipliers)
    for stable, members in groupby(stretches(branch), key=lambda stretch: stretch.stable):
        parts = []
        for stretch in members:
            before, multipliers = multipliers, in_order_of(multipliers, stretch.other.multipliers)
            parts.append(_rows(stretch, sizes, before, multipliers))
        begin = sum(map(len, rows))
        rows += [parts[0], *(part[1:] for part in parts[1:])]
        pieces.append([begin, sum(map(len, rows)), int(stable)])
    table = np.concatenate(rows) if rows else np.empty((0, len(_values(branch.points[0].orbit))))
    return {
        "lines": {"pieces": pieces, "words": STABILITY, "columns": _line_columns(branch, table)},
        "marks": _marks(branch),
    }


def locus_data(locus: Any) -> dict[str, Any]:
    """The curve of a locus in the plane of its two parameters."""
    table = curve_of(locus)
    columns = {
        name: {"width": 1, "data": packed(values, "f8")}
        for name, values in zip(("parameter", "second"), table.T, strict=True)
    }
    words = ("", NAMES[locus.kind])
    return {"lines": {"pieces": [[0, len(table), 1]], "words": words, "columns": columns}}


def _place(orbit: Any) -> tuple[float, ...]:
    """Parameter, period and state of an orbit."""
    return orbit.parameter, orbit.period, *orbit.state


def _told(orbit: Any, multipliers: np.ndarray) -> list[float]:
    """Multipliers of an orbit, in the order given, and its test values."""
    tests = orbit.fold, orbit.doubling, orbit.margin, orbit.residual
    return [*multipliers.real, *multipliers.imag, *tests]


def _values(orbit: Any) -> list[float]:
    return [*_place(orbit), *_told(orbit, np.array(orbit.multipliers))]


def in_order_of(before: np.ndarray, multipliers: Sequence[complex]) -> np.ndarray:
    """Multipliers in the order of those of the orbit before, each the nearest on the whole."""
    there = np.array(multipliers)
    return np.asarray(there[linear_sum_assignment(abs(before[:, None] - there))[1]])


def _rows(stretch: Any, sizes: np.ndarray, before: np.ndarray, behind: np.ndarray) -> np.ndarray:
    """Values along a stretch of a branch, its ends included; multipliers at these, one for one."""

    def at(share: float) -> tuple[float, Any]:
        return share, stretch.at(share)

    def value(there: tuple[float, Any]) -> tuple[float, ...]:
        return there[0], *_place(there[1])

    along = drawn(at, ((0.0, stretch.one), (1.0, stretch.other)), value, sizes)
    ends = (stretch.one, before), (stretch.other, behind)
    one, other = (np.array(_told(orbit, multipliers)) for orbit, multipliers in ends)
    share = along[:, :1]
    with np.errstate(invalid="ignore"):  # no gap turns: its margin is infinite
        told = np.where(one == other, one, (1 - share) * one + share * other)
    return np.hstack([along[:, 1:], told])


def _line_columns(branch: Any, table: np.ndarray) -> dict[str, dict[str, Any]]:
    """The values of a table by name of the column of the page, as wide as that."""
    first = branch.points[0].orbit
    state, multipliers = len(first.state), len(first.multipliers)
    widths = {
        "parameter": 1,
        "period": 1,
        "state": state,
        "multiplier_re": multipliers,
        "multiplier_im": multipliers,
        "fold": 1,
        "doubling": 1,
        "margin": 1,
        "residual": 1,
    }
    columns, begin = {}, 0
    for name, width in widths.items():
        columns[name] = {"width": width, "data": packed(table[:, begin : begin + width], "f8")}
        begin += width
    return columns


def _marks(branch: Any) -> dict[str, Any]:
    """The special points, with what their marks are called."""
    specials: Sequence[Any] = branch.specials
    table = np.array([_values(one.orbit) for one in specials])
    table = table.reshape(len(specials), len(_values(branch.points[0].orbit)))
    words = [(one.label, one.kind, branch.spelled(one.before), branch.spelled(one.after)) for one in specials]
    return {
        "texts": {name: [row[i] for row in words] for i, name in enumerate(WORDS)},
        "names": {kind: name for kind, (*_, name) in MARKS.items()},
        "columns": _line_columns(branch, table),
    }


# What the page of a table of points holds: its columns, words, and the command that runs each point.


POINTS_KEYS = (
    "Point at a point to read its numbers and the command that runs it. Wheel: zoom; drag: move; "
    "double click: everything. Keys: arrows, + and -, 0 everything, n and p the next point and the one "
    "before, d light or dark."
)
MOST_POINTS = 100_000
MOST_CARRIED = 400  # points whose start is looked up in the points before them
FIRST = {"sommerfeld": "mean_speed", "amplitude": "amplitude_relative"}  # what is shown first, by kind
HIDDEN = ("sha256",)
DIRECTION = "direction"
MULTIPLIERS = {"multiplier_re": "multipliers, real part", "multiplier_im": "multipliers, imaginary part"}
TITLES = (  # what columns are called on a page, by what their names are like; the first that fits
    (r"amplitude_(.+)_max", "greatest amplitude of {}"),
    (r"amplitude_(.+)", "amplitude of {}"),
    (r"(mean|min|max)_speed", "{} motor speed"),
    (r"(mean|min|max)_speed_(.+)", "{} speed of {}"),
    (r"(impacts|sticks)_per_period_(.+)", "{} per period, {}"),
    (r"section_(.+)", "{} once per period"),
    (r"end_(.+)", "{} at the end"),
    (r"drift_rate_(.+)", "drift rate of {}"),
    (r"power_(.+)", "mean power, {}"),
    (r"multiplier_(real|imaginary)", "multipliers, {} part"),
    (r"(.+)_half_width", "half width of the interval of {}"),
    (r"(.+)_min", "least {}"),
    (r"(.+)_max", "greatest {}"),
)


def points_data(subject: Subject) -> dict[str, Any]:
    """The data of `points.js`. Raises PlotError for a table that is too large, or has no numbers."""
    arrays = subject.result.arrays()
    table = Tidy(arrays)
    if table.count > MOST_POINTS:
        raise PlotError(f"{subject.path}: {table.count} points are too many for a page, {MOST_POINTS} go")
    columns = [*_point_columns(table, _by_ratio(subject)), *_further(arrays, table)]
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

    return (lines_data if subject.reads == "branch" else locus_data)(subject.result)


def _titled(subject: Subject, name: str) -> dict[str, str]:
    """Title of a column on the page, in words; by the key of the case where a key has none."""
    if subject.reads == "sweep":
        return {"title": title_of(subject, name)}
    if subject.reads == "branch":
        keys = {"parameter": _of_key(subject.result.key), **MULTIPLIERS}
    elif subject.reads == "locus":
        plan = subject.result.plan
        keys = {"parameter": _of_key(plan.branch.keys[0]), "second": _of_key(plan.keys[0])}
    else:
        return {}
    return {"title": keys[name]} if name in keys else {}


def title_of(subject: Subject, name: str) -> str:
    """A column of a sweep in words; an axis as it is labelled in pictures, less symbol and unit."""
    for axis in subject.result.axes:
        if axis.name == name and axis is not subject.result.members:
            return _plain(label_of(axis))
    for pattern, words in TITLES:
        found = re.fullmatch(pattern, name)
        if found:
            return words.format(*(part.replace("_", " ") for part in found.groups()))
    return name.replace("_", " ")


def _of_key(key: str) -> str:
    """A key of the case as pictures call it, less symbols; the key itself where it has no words."""
    return _plain(label_of(ParameterAxis(key, ""))) if is_speed(key) or words_of(key) else key


def _plain(label: str) -> str:
    """A label of an axis less its symbols and unit."""
    words = re.sub(r"\$[^$]*\$", "", label)
    return " ".join((words.rpartition(" (")[0] or words or label).split()) or label


def _by_ratio(subject: Subject) -> set[str]:
    """Names of the axes of a sweep that are drawn on a logarithmic scale."""
    axes = subject.result.axes if subject.reads == "sweep" else ()
    return {axis.name for axis in axes if draws_by_ratio(axis)}


def _point_columns(table: Tidy, by_ratio: Collection[str]) -> list[dict[str, Any]]:
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
    """The first picture: columns of the kinds that fit along the first axis, coloured by the second."""
    known = [FIRST[kind.name] for kind in fitting([subject]) if FIRST.get(kind.name) in numbers]
    shown = [*known, *(name for name in numbers if name not in known)][:2]
    lengths, hinted = table.arrays.lengths, table.arrays.shown
    if hinted:
        return {"x": hinted[0], "y": list(hinted[1:3]), "colour": ""}
    several = [name for name in table.dims if lengths[name] > 1 and name in table.columns]
    x = several[0] if several else next(iter(table.columns))
    further = several[1:]
    colour = (
        DIRECTION if DIRECTION in further else next(iter(further), "")
    )  # up and down differ at first sight
    return {"x": x, "y": [shown[0], shown[-1]], "colour": colour}


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
    """Values by which the case of an orbit differs from that of its branch or locus."""
    own, case = subject.result.case.values, subject.result.case_at(point).values
    return {key: str(value) for key, value in case.items() if str(own.get(key)) != str(value)}


def _written(subject: Subject, changes: Mapping[str, str]) -> str:
    words = [f"-s {shlex.quote(f'{key}={text}')}" for key, text in changes.items()]
    return f"vibsim run {shlex.quote(_source(subject))} {' '.join(words)} -o point.h5"


def _source(subject: Subject) -> str:
    """Name of the case in a command: the sweep's file; of a sweep in memory the case's own source."""
    return Path(subject.path).name if Path(subject.path).is_file() else subject.case.source


# What the page of a run holds: samples and events in one table, panels, and the relative motion.


RUN_KEYS = (
    "Wheel: zoom; drag: move; double click: everything. Keys: arrows, + and -, 0 everything, n and p the "
    "next impact and the one before, d light or dark."
)
MOST_ROWS = 600_000  # of samples and events: 20 MB; of longer runs the extremes are kept
PERIODS_ABOUT_IMPACT = 1.5  # of the fastest vibration, shown about an impact
PER_EXTREME = 2  # rows kept of each column and stretch, besides its first
Table = dict[str, np.ndarray]


def run_data(subject: Subject) -> dict[str, Any]:
    """The data of `run.js`. Raises PlotError for a run without samples."""
    result, scene = subject.result, subject.scene
    if len(result) < 2:
        raise PlotError(f"{subject.path}: the run holds {counted(len(result), 'sample')}: nothing to draw")
    rows = table_of(subject)
    pair = pair_of(subject)
    x, v = pair.plane({**rows, "time": rows["time"]})
    rows |= {"<x>": x, "<v>": v}
    scales = scale_for(pair.units[0], x), scale_for(pair.units[1], v)
    return {
        "t": packed(rows["time"], "f8"),
        "columns": {
            name: {"data": packed(values, _type(name)), "type": _type(name)}
            for name, values in rows.items()
            if name != "time"
        },
        "panels": panels(subject, rows),
        "portrait": {
            "x": "<x>",
            "y": "<v>",
            "factors": [scales[0].factor, scales[1].factor],
            "xLabel": scales[0].label(pair.words[0].lower()),
            "yLabel": scales[1].label(pair.words[1].lower()),
            "stops": [position for position, _ in pair.stops],
        },
        "events": _events(result),
        "kinds": {code: name for name, code in EVENT_KINDS.items() if name != SWITCH or has_switches(scene)},
        "parts": event_parts(scene),
        "impactKinds": [EVENT_KINDS[name] for name in IMPACTS],
        "impactSpan": PERIODS_ABOUT_IMPACT * (shortest_period(scene) or 1.0),
        "horizon": result.trust_horizon,
    }


def table_of(subject: Subject) -> Table:
    """Samples and events in ascending time; where velocities jump at an event, the state before it too."""
    result, states = subject.result, subject.tables.states
    samples = {name: np.asarray(result[name]) for name in ("time", *states)}
    events, after = result.events, {name: np.asarray(result.events[name]) for name in states}
    after["time"] = np.asarray(events["t"])
    parts = [samples, after]
    if any(f"before_{name}" in events for name in states):
        before = {name: events[f"before_{name}" if f"before_{name}" in events else name] for name in states}
        parts.insert(0, {**before, "time": after["time"]})
    joined = {name: np.concatenate([part[name] for part in parts]) for name in samples}
    order = np.argsort(joined["time"], kind="stable")
    rows = {name: values[order] for name, values in joined.items()}
    return rows if len(order) <= MOST_ROWS else thinned(rows, MOST_ROWS)


def thinned(rows: Table, most: int) -> Table:
    """About `most` rows: of every stretch the first, and those in which a column is least or greatest."""
    count, names = len(rows["time"]), [name for name in rows if name != "time"]
    stretch = -(-count * (1 + PER_EXTREME * len(names)) // most)
    whole = count // stretch * stretch
    begins = np.arange(0, whole, stretch)
    indices = [begins, np.arange(whole, count)]
    for name in names:
        blocks = rows[name][:whole].reshape(-1, stretch)
        indices += [begins + blocks.argmin(axis=1), begins + blocks.argmax(axis=1)]
    places = np.unique(np.concatenate(indices))
    return {name: values[places] for name, values in rows.items()}


def panels(subject: Subject, rows: Table) -> list[dict[str, Any]]:
    """Displacements, velocities, the speeds of a motor and of rotors, states."""
    listed = []
    alike = [(quantity, names) for quantity in ("m", "m/s") for names in subject.columns_alike(quantity)]
    for quantity, names in alike:
        scale = scale_for(subject.unit(quantity, names[0]), *(rows[name] for name in names))
        curves = [
            {"name": name, "column": name, "colour": i, **_interpolated(name)} for i, name in enumerate(names)
        ]
        listed.append(
            {
                "label": scale.label(subject.word(quantity, names[0])),
                "unit": scale.unit,
                "factor": scale.factor,
                "curves": curves,
            }
        )
    if subject.scene.has_motor:
        curve = {"name": "motor speed", "column": "phidot", "colour": 2, "rate": None, "of": "phi"}
        listed.append({"label": "motor speed (Hz)", "unit": "Hz", "factor": 0.5 / np.pi, "curves": [curve]})
    return [*listed, *_panels_of_rotors_and_states(subject)]


def _panels_of_rotors_and_states(subject: Subject) -> Iterator[dict[str, Any]]:
    """Speeds of rotors in one panel, each state in one of its own."""
    bodies = subject.scene.bodies
    speeds = [(body.name, *body.columns) for body in bodies if body.kind == ROTOR]
    curves = [
        {"name": name, "column": column, "colour": i, "rate": None, **({"of": angle} if angle else {})}
        for i, (name, angle, column) in enumerate(speeds)
    ]
    if curves:
        yield {"label": "rotor speed (Hz)", "unit": "Hz", "factor": 0.5 / np.pi, "curves": curves}
    for name in (body.name for body in bodies if body.kind == STATE):
        unit = dict(subject.scene.state_units).get(name, "")
        curve = {"name": name, "column": name, "colour": 0, "rate": None}
        label = f"{name} ({unit})" if unit else name
        yield {"label": label, "unit": unit, "factor": 1.0, "curves": [curve]}


def _interpolated(name: str) -> dict[str, Any]:
    """Interpolation of a column between rows: a displacement by its velocity, this by the rate of that."""
    if name.startswith("x"):
        return {"rate": f"v{name[1:]}"}
    return {"rate": None, "of": f"x{name[1:]}"}


def _type(name: str) -> str:
    """Displacements and angles in full: their cubics lose the digits that neighbouring rows share."""
    return "f8" if name == "<x>" or (name != "phidot" and name.startswith(("x", "phi"))) else "f4"


def _events(result: Any) -> dict[str, str]:
    types = {"t": "f8", "kind": "i1", "part": "i2"}
    return {name: packed(result.events[name], dtype) for name, dtype in types.items()}

"""The lines of a page of a branch or a locus: its curve between the points, and the special points on it.

Parameters, period and state are taken on the curve through points and tangents, as pictures have it; what
only the map tells (multipliers, test values) goes straight from one computed orbit to the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from vibsim.branches.course import curve_of, drawn, stretches
from vibsim.plots.branches.curves import MARKS, ranges
from vibsim.plots.branches.locus import NAMES
from vibsim.plots.live.html_file import packed

STABILITY = ("unstable", "stable")  # what the pieces of a curve are, by number
WORDS = ("label", "kind", "before", "after")  # what is told of a special point beside its numbers


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
        "lines": {"pieces": pieces, "words": STABILITY, "columns": _columns(branch, table)},
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
    """What the curve tells of an orbit."""
    return orbit.parameter, orbit.period, *orbit.state


def _told(orbit: Any, multipliers: np.ndarray) -> list[float]:
    """What the map tells of it, with its multipliers in an order."""
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


def _columns(branch: Any, table: np.ndarray) -> dict[str, dict[str, Any]]:
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
        "columns": _columns(branch, table),
    }

"""Branches as curves: solid where their orbits are stable, dashed where not, with marks at bifurcations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from vibsim.branches.course import drawn, stretches
from vibsim.branches.curve.energy import ENERGY
from vibsim.plots.branches.values import Value
from vibsim.plots.style import BLACK

WIDTH, DASHES = 1.0, (0, (3, 1.5))
LINE = 0.9  # width of the strokes of marks without an area, and at others 0.2 less [pt]
MARKS = {  # kind: marker, size [pt], filled, name: each tells itself by its shape, in black and white too
    "fold": ("x", 3.4, False, "fold"),
    "doubling": ("s", 3.2, False, "period doubling"),
    "neimark-sacker": ("D", 4.0, False, "Neimark–Sacker"),
    "branch point": ("P", 4.2, True, "branch point"),
    "corner": ("v", 3.8, True, "corner"),
    "hopf": ("*", 6.0, True, "Hopf point"),
    "grazing": ("^", 3.6, False, "grazing"),
    "sticking": ("1", 5.5, False, "stick begins or ends"),
}
STROKES = ("x", "1")  # markers without an area


@dataclass(frozen=True)
class Piece:
    """A piece of a branch whose orbits are all stable, or all not: x and y (n)."""

    x: np.ndarray
    y: np.ndarray
    stable: bool


def pieces(branch: Any, x: Value, y: Value) -> list[Piece]:
    """The pieces of a branch between changes of stability, which lie on its special points; smooth."""

    def value(orbit: Any) -> tuple[float, float]:
        return x(orbit), y(orbit)

    sizes = ranges([value(point.orbit) for point in branch.points])
    lines = []
    for stable, members in groupby(stretches(branch), key=lambda stretch: stretch.stable):
        parts = [drawn(each.at, (each.one, each.other), value, sizes) for each in members]
        line = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
        lines.append(Piece(line[:, 0], line[:, 1], stable))
    return lines


def ranges(places: Sequence[tuple[float, ...]]) -> np.ndarray:
    """Extent of what is drawn in each direction, 1 where it has none."""
    spans = np.ptp(np.array(places), axis=0)
    return np.where(spans > 0, spans, 1.0)


def draw_branch(
    axes: Axes,
    branch: Any,
    x: Value,
    y: Value,
    colour: Any = BLACK,
    label: str = "",
    kinds: Sequence[str] = tuple(MARKS),
    size: float = 1.0,
) -> np.ndarray:
    """One branch with its bifurcations; `kinds` are marked, all of it larger or smaller by `size`. The places
    along it (n, 2).
    """
    parts = pieces(branch, x, y)
    for piece in parts:
        style = "-" if piece.stable else DASHES
        gid = "stable" if piece.stable else "unstable"
        axes.plot(piece.x, piece.y, color=colour, linestyle=style, linewidth=size * WIDTH, zorder=4, gid=gid)
    if label:
        axes.plot([], [], color=colour, linewidth=WIDTH, label=label)
    for kind in kinds:
        marker, pt, filled, _ = MARKS[kind]
        orbits = [special.orbit for special in branch.specials if special.kind == kind]
        if orbits:
            axes.plot(
                [x(o) for o in orbits], [y(o) for o in orbits], marker, color=colour, markersize=size * pt,
                markerfacecolor=colour if filled else "white", markeredgewidth=_stroke(marker) * size,
                gid=kind, zorder=6 if filled or marker in STROKES else 5,
            )  # fmt: skip
    return np.concatenate([np.column_stack([piece.x, piece.y]) for piece in parts])


def keys_to_marks(branches: Sequence[Any], kinds: Sequence[str] = tuple(MARKS)) -> list[Line2D]:
    """What lines and marks mean, for a legend: those that are there."""
    there = {special.kind for branch in branches for special in branch.specials}
    stable = any(branch["stable"].any() for branch in branches if branch.key != ENERGY)
    unstable = any(not branch["stable"].all() for branch in branches)
    keys = [Line2D([], [], color=BLACK, linewidth=WIDTH, label="stable")] * stable
    keys += [Line2D([], [], color=BLACK, linewidth=WIDTH, linestyle=DASHES, label="unstable")] * unstable
    return [*keys, *(_mark(kind) for kind in kinds if kind in there)]


def _mark(kind: str) -> Line2D:
    marker, size, filled, name = MARKS[kind]
    key = Line2D([], [], color=BLACK, marker=marker, markersize=size, linestyle="none", label=name)
    key.set_markerfacecolor(BLACK if filled else "white")
    key.set_markeredgewidth(_stroke(marker))
    return key


def _stroke(marker: str) -> float:
    return LINE if marker in STROKES else LINE - 0.2

"""Branches as curves: solid where their orbits are stable, dashed where not, with marks at bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from vibsim.branches.energy import ENERGY
from vibsim.plots.style import BLACK

WIDTH, DASHES = 1.0, (0, (3, 1.5))
MARKS = {  # kind: marker, size [pt], filled, name
    "fold": ("o", 2.2, True, "fold"),
    "doubling": ("s", 3.2, False, "period doubling"),
    "neimark-sacker": ("D", 4.0, False, "Neimark–Sacker"),
    "branch point": ("X", 3.6, True, "branch point"),
    "corner": ("v", 3.4, True, "corner"),
    "grazing": ("^", 3.4, False, "grazing"),
}

Value = Callable[[Any], float]  # of an orbit record


@dataclass(frozen=True)
class Piece:
    """A piece of a branch whose orbits are all stable, or all not: x and y (n)."""

    x: np.ndarray
    y: np.ndarray
    stable: bool


def pieces(branch: Any, x: Value, y: Value) -> list[Piece]:
    """The pieces of a branch between changes of stability, which lie on its special points."""
    stretches = [stretch for i in range(len(branch) - 1) for stretch in _stretches(branch, i)]
    found = []
    for stable, group in groupby(stretches, key=lambda stretch: stretch[2]):
        members = list(group)
        orbits = [members[0][0], *(end for _, end, _ in members)]
        found.append(Piece(np.array([x(o) for o in orbits]), np.array([y(o) for o in orbits]), stable))
    return found


def orbits_along(branch: Any) -> list[Any]:
    """Every orbit of a branch, those at its special points between the others."""
    orbits = [branch.points[0].orbit]
    for i in range(len(branch) - 1):
        orbits += [special.orbit for special in branch.specials if special.between == (i, i + 1)]
        orbits.append(branch.points[i + 1].orbit)
    return orbits


def _stretches(branch: Any, i: int) -> list[tuple[Any, Any, bool]]:
    """From point i to the next by way of the special points between: (orbit, orbit, stable).

    Orbits of a family have a multiplier on the unit circle and are not stable, though none is outside; those
    of a backbone curve are drawn solid where none is outside.
    """
    ends = [point.orbit for point in branch.points[i : i + 2]]
    family = all(end.index == 0 for end in ends) and not branch["stable"][i : i + 2].any()
    orbit, index = ends[0], ends[0].index
    found = []
    for special in branch.specials:
        if special.between == (i, i + 1) and special.jump:
            found.append((orbit, special.orbit, index == 0 and not family))
            orbit, index = special.orbit, index + special.jump
    return [*found, (orbit, ends[1], index == 0 and not family)]


def draw_branch(
    axes: Axes,
    branch: Any,
    x: Value,
    y: Value,
    colour: Any = BLACK,
    label: str = "",
    kinds: Sequence[str] = tuple(MARKS),
    size: float = 1.0,
) -> None:
    """One branch with its bifurcations; `kinds` are marked, all of it larger or smaller by `size`."""
    for piece in pieces(branch, x, y):
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
                markerfacecolor=colour if filled else "white", markeredgewidth=0.7 * size, gid=kind,
                zorder=6 if filled else 5,
            )  # fmt: skip


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
    key.set_markeredgewidth(0.7)
    return key

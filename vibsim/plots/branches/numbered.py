"""Several branches in one picture: each has a number, in the legend and at its curve, so that they are told
apart in grey print too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.branches.curves import MARKS, draw_branch
from vibsim.plots.branches.values import Value
from vibsim.plots.page.curve_labels import Named, write_names
from vibsim.plots.style import overlay
from vibsim.plots.subject import Subject

PLACES, PARTS = 40, 4  # along a branch where its number may stand; of each piece between its corners
APART = 12.0  # pt between a branch and others: enough for its number


@dataclass(frozen=True)
class Drawn:
    """A branch as it is drawn: places along it (n, 2), and its colour."""

    line: np.ndarray
    colour: Any


def draw_branches(
    axes: Axes,
    subjects: Sequence[Subject],
    values: Sequence[tuple[Value, Value]],
    kinds: Sequence[str] = tuple(MARKS),
) -> list[Drawn]:
    """Draw branches in a colour each; of several the legend has numbers and names. `write_numbers` writes the
    numbers, when all else is drawn.

    values : what is drawn of each branch across and up
    kinds : of special points that are marked
    """
    drawn = []
    for i, (subject, (x, y)) in enumerate(zip(subjects, values, strict=True)):
        label = f"{i + 1}: {subject.name}" if len(subjects) > 1 else ""
        colour = overlay(i)["color"]
        drawn.append(Drawn(draw_branch(axes, subject.result, x, y, colour, label, kinds), colour))
    return drawn


def write_numbers(axes: Axes, drawn: Sequence[Drawn]) -> None:
    """Write the number of each of several branches where it ends, or else where it is apart from the others.

    Call it last: limits of the axes must be final.
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    if len(drawn) == 1:
        return
    figure.draw_without_rendering()
    lines = [axes.transData.transform(each.line) for each in drawn]
    named = []
    for i, line in enumerate(lines):
        inside = line[[axes.bbox.contains(*place) for place in line.tolist()]]
        if len(inside):
            places = inside[np.linspace(len(inside) - 1, 0, PLACES).round().astype(int)]
            others = np.concatenate([_dense(other) for j, other in enumerate(lines) if j != i])
            away = np.linalg.norm(places[:, None] - others, axis=2).min(axis=1) * 72 / figure.dpi
            order = np.argsort(-np.minimum(away, APART), kind="stable")
            x, y = axes.transData.inverted().transform(places[order]).T
            named.append(Named(str(i + 1), x, y, {"color": drawn[i].colour, "gid": "number of a branch"}))
    write_names(axes, named)


def _dense(line: np.ndarray) -> np.ndarray:
    """Places along a polygon, some between its corners."""
    count = np.arange(len(line))
    shares = np.linspace(0, len(line) - 1, PARTS * (len(line) - 1) + 1)
    return np.column_stack([np.interp(shares, count, column) for column in line.T])

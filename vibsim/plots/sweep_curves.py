"""The curves of a sweep: one per direction and value of the other axes, along the axis that is drawn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, product
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.natural_frequencies import Frequency, fractions, natural_frequencies
from vibsim.plots.sheet import legend_below
from vibsim.plots.style import BLUE, VERMILLION, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import along, ascending, numbers, shown
from vibsim.plots.view import View

TUNING = {
    "blocks.m1",
    "blocks.m2",
    "coupling.k1",
    "stop.k2",
    "excitation.m3",
}  # what natural frequencies depend on
NAMED_AT_MOST = 12  # curves in a legend
COLOURS = 7  # curves told apart by the colours of the style; more take those of a colour map
UP, DOWN = 1, -1
DIRECTION_NAMES = {UP: "up", DOWN: "down"}


@dataclass(frozen=True)
class Curve:
    """One curve.

    Attributes
    ----------
    subject : the sweep that it belongs to
    family : number of its family, the curves that differ in direction alone
    title : what sets its family apart
    label : what sets the curve apart, for the legend
    x : values of the axis drawn along (n), Hz for a speed
    colour : its colour
    down : whether it was swept downwards
    """

    subject: Subject
    family: int
    title: str
    label: str
    x: np.ndarray
    colour: Any
    down: bool
    _at: tuple[Any, ...]

    def values(self, name: str) -> np.ndarray:
        """What the sweep has of that name along the curve: (n), or (n, section)."""
        return self.subject.result[name][self._at]

    @property
    def look(self) -> dict[str, Any]:
        """Line and markers: closed upwards, open and dashed downwards."""
        face = "white" if self.down else self.colour
        return {
            "color": self.colour, "linestyle": (0, (4, 1.5)) if self.down else "-", "marker": "o",
            "markersize": 2.0, "markeredgewidth": 0.5, "markerfacecolor": face,
        }  # fmt: skip


def curves(subjects: Sequence[Subject]) -> list[Curve]:
    """All curves of the subjects."""
    every = [(subject, others) for subject in subjects for others in _others(subject.result)]
    found = []
    for i, (subject, others) in enumerate(every):
        result = subject.result
        directions = result.directions if result.plan.carry else result.directions[:1]
        for d, direction in enumerate(directions):
            title = _title(subject, others, len(subjects) > 1)
            label = ", ".join(filter(None, [title, DIRECTION_NAMES[direction] if result.plan.carry else ""]))
            colour = _colour(i, len(every), direction)
            at: list[Any] = list(others)
            axis = result.axes[along(result)]
            at.insert(along(result), ascending(axis))
            x = numbers(axis)[ascending(axis)]
            found.append(Curve(subject, i, title, label, x, colour, direction == DOWN, (*at, d)))
    return found


def _others(result: Any) -> Iterator[tuple[int, ...]]:
    lengths = [len(axis) for axis in result.axes]
    del lengths[along(result)]
    return product(*map(range, lengths))


def families(drawn: Sequence[Curve]) -> list[list[Curve]]:
    """The curves, those of a family together."""
    return [list(members) for _, members in groupby(drawn, key=lambda curve: curve.family)]


def _title(subject: Subject, others: tuple[int, ...], named: bool) -> str:
    axes = list(subject.result.axes)
    del axes[along(subject.result)]
    parts = [subject.name] if named else []
    return ", ".join(
        [*parts, *(f"{axis.name} = {axis.text(i)}" for axis, i in zip(axes, others, strict=True))]
    )


def alone(curve: Curve) -> Curve:
    """The curve as it looks in a panel of its family."""
    direction = DOWN if curve.down else UP
    return replace(curve, colour=_colour(0, 1, direction), label=DIRECTION_NAMES[direction])


def _colour(index: int, count: int, direction: int) -> Any:
    if count == 1:
        return VERMILLION if direction == DOWN else BLUE
    if count <= COLOURS:
        return overlay(index)["color"]
    return matplotlib.colormaps["viridis"](0.9 * index / (count - 1))


def frequencies(subjects: Sequence[Subject], parts: bool = False) -> list[Frequency]:
    """Natural frequencies that hold for every point of every subject, equal ones once.

    parts : whether to add fractions of them
    """
    found: dict[tuple[str, float], Frequency] = {}
    for subject in subjects:
        if not TUNING & {axis.key for axis in subject.result.axes}:
            own = [*natural_frequencies(subject.scene), *(fractions(subject.scene) if parts else [])]
            found |= {(f.label, round(f.hz, 6)): f for f in own}
    return list(found.values())


def name_curves(figure: Figure, axes: Axes, **options: Any) -> None:
    """The legend under the picture, as far as there is something to tell apart; `options` of a legend."""
    handles, labels = axes.get_legend_handles_labels()
    named = [(handle, label) for handle, label in zip(handles, labels, strict=True) if label]
    if len(named) < 2:
        return
    if len(named) > NAMED_AT_MOST:
        named = [named[0], named[len(named) // 2], named[-1]]  # of a colour map
    legend_below(figure, *zip(*named, strict=True), **options)


def limit(axes: Axes, drawn: Sequence[Curve], view: View) -> None:
    """The span of the parameter: the view's window in its unit, or everything."""
    low, high = min(curve.x.min() for curve in drawn), max(curve.x.max() for curve in drawn)
    margin = 0.02 * (high - low) or 0.05 * abs(high) or 1.0
    axes.set_xlim(*shown(low - margin, high + margin, view))

"""The curves of a sweep: one per direction and value of the other axes, along the axis that is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.cases.units import UNITS
from vibsim.plots.errors import PlotError
from vibsim.plots.natural_frequencies import Frequency, natural_frequencies
from vibsim.plots.style import BLUE, VERMILLION, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

SPEEDS = {
    "excitation.Omega0": r"No-load speed $\Omega_0/2\pi$ (Hz)",
    "excitation.omega": r"Excitation frequency $\omega/2\pi$ (Hz)",
}
TUNING = {
    "blocks.m1",
    "blocks.m2",
    "coupling.k1",
    "stop.k2",
    "excitation.m3",
}  # what natural frequencies depend on
NAMED_AT_MOST = 12  # curves in a legend
COLOURS = 7  # curves told apart by the colours of the style; more take those of a colour map
DOWN = -1


@dataclass(frozen=True)
class Curve:
    """One curve.

    Attributes
    ----------
    subject : the sweep that it belongs to
    label : what sets it apart, for the legend
    x : values of the axis drawn along (n), Hz for a speed
    colour : its colour
    down : whether it was swept downwards
    """

    subject: Subject
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


def along(result: Any) -> int:
    """Position of the axis that a sweep is drawn along: that of the source's speed, or the first."""
    return next((i for i, axis in enumerate(result.axes) if axis.key in SPEEDS), 0)


def axis_label(subjects: Sequence[Subject]) -> str:
    """Label of the axis drawn along; PlotError where the sweeps are along different ones."""
    axes = [subject.result.axes[along(subject.result)] for subject in subjects]
    if len({axis.key for axis in axes}) > 1:
        listed = ", ".join(f"{s.path} over {axis.key}" for s, axis in zip(subjects, axes, strict=True))
        raise PlotError(f"sweeps over different things do not go into one picture: {listed}")
    axis = axes[0]
    return SPEEDS.get(axis.key) or (f"{axis.name} ({axis.unit})" if axis.unit else axis.name)


def curves(subjects: Sequence[Subject]) -> list[Curve]:
    """All curves of the subjects."""
    families = [(subject, others) for subject in subjects for others in _others(subject.result)]
    found = []
    for i, (subject, others) in enumerate(families):
        result = subject.result
        directions = result.directions if result.plan.carry else result.directions[:1]
        for d, direction in enumerate(directions):
            label = _label(subject, others, direction, len(subjects) > 1)
            colour = _colour(i, len(families), direction)
            at: list[Any] = list(others)
            at.insert(along(result), slice(None))
            found.append(Curve(subject, label, _numbers(result), colour, direction == DOWN, (*at, d)))
    return found


def _others(result: Any) -> Iterator[tuple[int, ...]]:
    lengths = [len(axis) for axis in result.axes]
    del lengths[along(result)]
    return product(*map(range, lengths))


def _label(subject: Subject, others: tuple[int, ...], direction: int, named: bool) -> str:
    axes = list(subject.result.axes)
    del axes[along(subject.result)]
    parts = [subject.name] if named else []
    parts += [f"{axis.name} = {axis.text(i)}" for axis, i in zip(axes, others, strict=True)]
    parts += [("down" if direction == DOWN else "up")] if subject.result.plan.carry else []
    return ", ".join(parts)


def _colour(index: int, count: int, direction: int) -> Any:
    if count == 1:
        return VERMILLION if direction == DOWN else BLUE
    if count <= COLOURS:
        return overlay(index)["color"]
    return matplotlib.colormaps["viridis"](0.9 * index / (count - 1))


def _numbers(result: Any) -> np.ndarray:
    """Values of the axis drawn along; a speed in Hz."""
    axis = result.axes[along(result)]
    numbers = axis.numbers()
    if axis.key not in SPEEDS:
        return numbers
    unit = UNITS[axis.unit]
    return numbers * float(unit.factor) / (1.0 if unit.per_turn else 2 * math.pi)


def frequencies(subjects: Sequence[Subject]) -> list[Frequency]:
    """Natural frequencies that hold for every point of every subject, equal ones once."""
    found: dict[tuple[str, float], Frequency] = {}
    for subject in subjects:
        if not TUNING & {axis.key for axis in subject.result.axes}:
            found |= {(f.label, round(f.hz, 6)): f for f in natural_frequencies(subject.scene)}
    return list(found.values())


def legend_below(figure: Figure, axes: Axes) -> None:
    """The legend under the picture, as far as there is something to tell apart."""
    handles, labels = axes.get_legend_handles_labels()
    named = [(handle, label) for handle, label in zip(handles, labels, strict=True) if label]
    if len(named) < 2:
        return
    if len(named) > NAMED_AT_MOST:
        named = [named[0], named[len(named) // 2], named[-1]]  # of a colour map
    columns = max(1, int(figure.get_figwidth() * 14 / (max(len(label) for _, label in named) + 7)))
    figure.legend(*zip(*named, strict=True), loc="outside lower center", ncols=min(columns, len(named)))


def limit(axes: Axes, drawn: Sequence[Curve], view: View) -> None:
    """The span of the parameter: the view's window in its unit, or everything."""
    low, high = min(curve.x.min() for curve in drawn), max(curve.x.max() for curve in drawn)
    margin = 0.02 * (high - low) or 0.05 * abs(high) or 1.0
    low, high = low - margin, high + margin
    if view.window is not None:
        low, high = max(low, view.window[0]), min(high, view.window[1])
    axes.set_xlim(low, high)

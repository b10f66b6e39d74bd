"""The axes of a sweep as axes of a picture: their numbers and what is written beside them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibsim.cases.units import UNITS
from vibsim.plots.errors import PlotError
from vibsim.plots.quantities import rounded
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View

SPEEDS = {
    "excitation.Omega0": r"No-load speed $\Omega_0/2\pi$ (Hz)",
    "excitation.omega": r"Excitation frequency $\omega/2\pi$ (Hz)",
}
WORDS = {
    "blocks.m1": "Mass $m_1$",
    "blocks.m2": "Mass $m_2$",
    "coupling.k1": "Stiffness $k_1$",
    "coupling.c": "Damping $c$",
    "stop.k2": "Stiffness $k_2$ of the stop",
    "stop.G": "Gap $G$",
    "friction.mu": r"Coefficient of friction $\mu$",
    "excitation.M0": "Starting torque $M_0$",
    "initial.phi": r"Rotor angle at the start $\varphi(0)$",
    "initial.phidot": r"Motor speed at the start $\dot\varphi(0)$",
}


def along(result: Any) -> int:
    """Position of the axis that a sweep is drawn along.

    That of the source's speed, or the first; one with several values before one with a single value, an
    ensemble only where there is no other.
    """

    def rank(i: int) -> tuple[bool, bool, bool]:
        axis = result.axes[i]
        return axis is result.members, len(axis) == 1, axis.key not in SPEEDS

    return min(range(len(result.axes)), key=rank)


def label_of(axis: Any) -> str:
    """Label of one axis, or of the spread of an ensemble, with its unit."""
    words = WORDS.get(axis.key, axis.name)
    return SPEEDS.get(axis.key) or (f"{words} ({axis.unit})" if axis.unit else words)


def axis_label(subjects: Sequence[Subject]) -> str:
    """Label of the axis drawn along; PlotError where the sweeps are along different ones."""
    axes = [_drawn_along(subject.result) for subject in subjects]
    if len({axis.key for axis in axes}) > 1:
        listed = ", ".join(f"{s.path} over {axis.key}" for s, axis in zip(subjects, axes, strict=True))
        raise PlotError(f"sweeps over different things do not go into one picture: {listed}")
    return label_of(axes[0])


def _drawn_along(result: Any) -> Any:
    """The axis drawn along; of an ensemble alone, what is spread first."""
    axis = result.axes[along(result)]
    return axis.spreads[0] if axis is result.members else axis


def positions(result: Any) -> np.ndarray:
    """Values of the axis drawn along (n), see `numbers`; of an ensemble alone, its first start values."""
    axis = result.axes[along(result)]
    return axis.drawn[axis.spreads[0].key] if axis is result.members else numbers(axis)


def value_texts(axis: Any) -> list[str]:
    """Every value of an axis with its symbol and unit, such as `$c$ = 0.0151 N s/m`, in rounded decimals."""
    unit = "Hz" if axis.key in SPEEDS else axis.unit
    symbol = re.search(r"\$.*?\$", label_of(axis))
    name = symbol.group() if symbol else axis.name
    return [f"{name} = {text} {unit}".strip() for text in rounded(numbers(axis).tolist())]


def numbers(axis: Any) -> np.ndarray:
    """Values of one axis (n), a speed of the source in Hz, everything else in its unit."""
    values = axis.numbers()
    if axis.key not in SPEEDS:
        return values
    unit = UNITS[axis.unit]
    return values * float(unit.factor) / (1.0 if unit.per_turn else 2 * math.pi)


def ascending(axis: Any) -> np.ndarray:
    """Positions of the values of an axis from the least to the greatest, however they are written."""
    return np.argsort(axis.numbers(), kind="stable")


def shown(low: float, high: float, view: View) -> Span:
    """The part of a range that the view's window shows, in the unit of its axis; everything without one.

    Raises PlotError for a window that lies outside.
    """
    if view.window is None:
        return low, high
    first, last = max(low, view.window[0]), min(high, view.window[1])
    if not first < last:
        asked = ":".join(f"{end:g}" for end in view.window)
        raise PlotError(f"the window {asked} lies outside the sweep, {low:.6g} to {high:.6g}")
    return first, last

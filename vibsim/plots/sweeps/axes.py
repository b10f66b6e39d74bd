"""The axes of a sweep as axes of a picture: their numbers and what is written beside them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.cases.schema.forms import LONG
from vibsim.cases.values.units import UNITS
from vibsim.plots.errors import PlotError
from vibsim.plots.page.log_axis import draw_by_ratio
from vibsim.plots.page.quantities import rounded
from vibsim.plots.page.user_text import as_text
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View
from vibsim.sweeps.plan.axis import Axis

MOTOR_SPEEDS = ("excitation.Omega0", "motor.Omega0")
NO_LOAD = r"No-load speed $\Omega_0/2\pi$ (Hz)"
FREQUENCY = r"Excitation frequency $\omega/2\pi$"
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
    "motor.M0": "Starting torque $M_0$",
    "initial.motor.phi": r"Rotor angle at the start $\varphi(0)$",
    "initial.motor.phidot": r"Motor speed at the start $\dot\varphi(0)$",
    "base.a": "Amplitude $a$ of the base",
}
OF_PART = {  # by the last part of a key of the long form, before the name of what it belongs to
    "k": "Stiffness $k$",
    "c": "Damping $c$",
    "gap": "Gap",
    "mu": r"Coefficient of friction $\mu$",
    "N": "Load $N$",
    "belt": "Belt speed",
    "A": "Amplitude $A$",
    "F0": "Constant force $F_0$",
    "phase": "Phase",
    "distance": "Distance",
    "x": "Displacement at the start $x(0)$",
    "v": "Velocity at the start $v(0)$",
}


def is_motor_speed(key: str) -> bool:
    """Whether a key is the motor constant."""
    return key in MOTOR_SPEEDS


def is_speed(key: str) -> bool:
    """Whether a key is a speed of the source: the motor constant, or a frequency of forces or the base."""
    return is_motor_speed(key) or key.rpartition(".")[2] == "omega"


def along(result: Any) -> int:
    """Position of the axis that a sweep is drawn along.

    That of the source's speed, or the first; one with several values before one with a single value, an
    ensemble only where there is no other.
    """

    def rank(i: int) -> tuple[bool, bool, bool]:
        axis = result.axes[i]
        return axis is result.members, len(axis) == 1, not is_speed(axis.key)

    return min(range(len(result.axes)), key=rank)


def label_of(axis: Any) -> str:
    """Label of one axis, or of the spread of an ensemble, with its unit."""
    if is_motor_speed(axis.key):
        return NO_LOAD
    if is_speed(axis.key):
        return f"{FREQUENCY}{_of_part(axis.key)} (Hz)"
    words = _words(axis.key) or axis.name
    return f"{words} ({axis.unit})" if axis.unit else words


def _words(key: str) -> str:
    """What a key is, in words; empty for one that has none."""
    section, *names = key.split(".")
    if key in WORDS or section not in LONG.named or not names:
        return WORDS.get(key, "")
    if section == "bodies":
        return f"Mass $m${_owner(key)}"
    quantity = OF_PART.get(names[-1], "")
    return quantity and f"{quantity}{_of_part(key)}"


def _owner(key: str) -> str:
    """The body or part that a key of the long form belongs to, behind other words."""
    section, *names = key.split(".")
    return f" of {as_text(names[0])}" if section == "bodies" else _of_part(key)


def _of_part(key: str) -> str:
    """Which part a key of the long form belongs to, behind other words; empty for one without a name."""
    section, *names = key.split(".")
    if section == "base":
        return " of the base"
    term = f", term {names[2]}" if names[1:2] == ["terms"] else ""
    return f" of {as_text(names[0])}{term}" if section in LONG.named and len(names) > 1 else ""


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
    unit = "Hz" if is_speed(axis.key) else axis.unit
    symbol = re.search(r"\$.*?\$", label_of(axis))
    name = symbol.group() + _owner(axis.key) if symbol else axis.name
    return [f"{name} = {text} {unit}".strip() for text in rounded(numbers(axis).tolist())]


def numbers(axis: Any) -> np.ndarray:
    """Values of one axis (n), a speed of the source in Hz, everything else in its unit."""
    values = axis.numbers()
    if not is_speed(axis.key):
        return np.asarray(values)
    unit = UNITS[axis.unit]
    return np.asarray(values * float(unit.factor) / (1.0 if unit.per_turn else 2 * math.pi))


def draws_by_ratio(axis: Any) -> bool:
    """Whether an axis is drawn on a logarithmic scale: its values are spaced by ratio."""
    return isinstance(axis, Axis) and axis.by_ratio


def ascending(axis: Any) -> np.ndarray:
    """Positions of the values of an axis from the least to the greatest, however they are written."""
    return np.argsort(axis.numbers(), kind="stable")


def show_span(axes: Axes, span: Span, room: float, by_ratio: bool, view: View) -> None:
    """Show a span of the axis along, and this share of it on either side, or what the view's window shows."""
    low, high = span
    if by_ratio:
        draw_by_ratio(axes, "x")
        beyond = (high / low) ** room
        axes.set_xlim(*shown(low / beyond, high * beyond, view))
        return
    margin = room * (high - low) if high > low else 0.05 * abs(high) or 1.0
    axes.set_xlim(*shown(low - margin, high + margin, view))


def shown(low: float, high: float, view: View) -> Span:
    """The part of a range that the view's window shows, in the unit of its axis; everything without one.

    Raises PlotError for a window that lies outside.
    """
    if view.window is None:
        return low, high
    first, last = max(low, view.window[0]), min(high, view.window[1])
    if not first < last:
        window_text = ":".join(f"{end:g}" for end in view.window)
        raise PlotError(f"the window {window_text} lies outside the sweep, {low:.6g} to {high:.6g}")
    return first, last

"""What is drawn of the orbits of a branch: parameter, mean speed of a motor, amplitude."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from vibsim.branches.curve.energy import ENERGY
from vibsim.cases.values.units import UNITS
from vibsim.plots.errors import PlotError
from vibsim.plots.page.quantities import Scale, symbol
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import is_speed, label_of

Value = Callable[[Any], float]  # of an orbit record


class ParameterAxis:
    """A parameter as the axis of a picture, with what `sweep_axes.label_of` asks of one."""

    def __init__(self, key: str, unit: str):
        self.key, self.unit, self.name = key, unit, key.rpartition(".")[2]


def parameter_of(branch: Any) -> Value:
    """The parameter of an orbit: in Hz for the speed of a source, else in its unit; of a backbone curve the
    frequency in place of the energy.
    """
    if branch.key == ENERGY:
        return mean_speed_of(branch)
    factor = parameter_factor(branch.key, branch.unit)
    return lambda orbit: float(orbit.parameter) * factor


def parameter_factor(key: str, unit: str) -> float:
    """What makes of a value in a unit the number that is drawn: Hz for the speed of a source."""
    if not is_speed(key):
        return 1.0
    return float(UNITS[unit].factor) / (1.0 if UNITS[unit].per_turn else 2 * math.pi)


def parameter_label(subjects: Sequence[Subject]) -> str:
    """Label of the axis of the parameter; PlotError where branches are over different ones."""
    axes = [ParameterAxis(subject.result.key, subject.result.unit) for subject in subjects]
    if len({axis.key for axis in axes}) > 1:
        listed = ", ".join(f"{s.path} over {axis.key}" for s, axis in zip(subjects, axes, strict=True))
        raise PlotError(f"branches over different things do not go into one picture: {listed}")
    return "Frequency (Hz)" if axes[0].key == ENERGY else label_of(axes[0])


def scaled(value: Value, scale: Scale) -> Value:
    """The same in the unit of a scale."""
    return lambda orbit: float(scale(value(orbit)))


def mean_speed_of(branch: Any) -> Value:
    """Mean speed of the motor over an orbit [Hz]: its turns over their time."""
    turns = branch.plan.n
    return lambda orbit: turns / float(orbit.period)


def amplitude_of(branch: Any) -> Value:
    """Half the range of the first displacement of an orbit [m], from its extremes over a period."""
    from vibsim.branches.extremes import half_range

    family = branch.plan.family()
    return cache(lambda orbit: half_range(family.map(orbit.parameter), orbit))


def amplitude_words(branch: Any) -> str:
    """What `amplitude_of` is the half range of."""
    first, *rest = branch.names[0].split("-")
    return f"Amplitude of {symbol(first)}" + "".join(f" − {symbol(name)}" for name in rest)

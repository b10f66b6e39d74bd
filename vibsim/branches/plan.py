"""What branch is to be continued: an orbit, the parameter, its range."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from vibsim.branches.curve.energy import ENERGY
from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node, node_at
from vibsim.branches.curve.step_size import Pace
from vibsim.cases import Case
from vibsim.cases.number import number

PACE = Pace()
FIRST_STEP = 0.1  # scaled, that the first correction of the start may have
ASIDE = ("run", "initial", "clearances", "rest_distance")  # sections of a case that move no orbit


class BranchError(ValueError):
    """A branch that cannot be continued as asked; the message says why.

    >>> import vibsim
    >>> try:
    ...     vibsim.continue_branch("I-C", "omega", "7:9")
    ... except vibsim.BranchError as error:
    ...     print(error)
    the orbit is at excitation.omega = 6.5 Hz, outside the range 7:9; begin from an orbit within it
    """


@dataclass(frozen=True)
class BranchPlan:
    """A branch to be continued from an orbit.

    keys : of the case, which all have the value of the parameter; unit : of the parameter
    span : range of the parameter, in that unit; n : periods of the source, or turns of the motor
    state, period, parameter : of the orbit that it starts from: unknowns on the section, time of return [s]
    travel : largest of its unknowns at its events, as weighed [m/s], which the state is measured by
    heading : scaled direction in which it is followed one way only, as away from a doubling; empty: both ways
    """

    case: Case
    keys: tuple[str, ...]
    unit: str
    span: tuple[float, float]
    n: int
    state: tuple[float, ...]
    period: float
    parameter: float
    travel: float
    pace: Pace = PACE
    heading: tuple[float, ...] = ()

    @cached_property
    def settings(self) -> dict[str, Any]:
        """What the branch follows from, besides the case, as plain data."""
        return {
            "keys": list(self.keys),
            "unit": self.unit,
            "span": list(self.span),
            "periods": self.n,
            "state": list(self.state),
            "period": self.period,
            "parameter": self.parameter,
            "travel": self.travel,
            "pace": [self.pace.first, self.pace.least, self.pace.most],
            "heading": list(self.heading),
        }

    @cached_property
    def fingerprint(self) -> str:
        """Of the case and the settings."""
        text = json.dumps([self.case.sha256, self.settings])
        return hashlib.sha256(text.encode()).hexdigest()

    def family(self, engine: str = "auto") -> Family:
        """The orbits over the parameter, scaled by the first."""
        family = self._family(engine)
        span = abs(self.span[1] - self.span[0])
        family.scaled_by(np.array(self.state), self.period, self.parameter, span, self.travel)
        return family

    def _family(self, engine: str) -> Family:
        if self.keys != (ENERGY,):
            return Family(self.case, self.keys, self.unit, self.n, engine)
        from vibsim.branches.backbone import EnergyFamily

        return EnergyFamily(self.case, self.n, np.array(self.state), engine)

    def start(self, family: Family) -> Node:
        """The first node, its tangent along the heading, else towards larger parameters.

        Raises ContinuationError.
        """
        z = family.unknowns(np.array(self.state), self.period, self.parameter)
        if not self.heading:
            return node_at(family, z, None, None, FIRST_STEP)
        along = np.array(self.heading)
        node = node_at(family, z, along, None, FIRST_STEP)
        return Node(node.point, along, node.iterations)

    @property
    def ways(self) -> tuple[int, ...]:
        """Ways in which it is followed from its start."""
        return (1,) if self.heading else (1, -1)

    @staticmethod
    def from_settings(case: Case, settings: dict[str, Any]) -> "BranchPlan":
        """The plan that `settings` wrote down."""
        return BranchPlan(
            case,
            tuple(settings["keys"]),
            settings["unit"],
            (float(settings["span"][0]), float(settings["span"][1])),
            int(settings["periods"]),
            tuple(float(value) for value in settings["state"]),
            float(settings["period"]),
            float(settings["parameter"]),
            float(settings["travel"]),
            Pace(*settings["pace"]),
            tuple(float(value) for value in settings["heading"]),
        )


def plan_from(orbit: Any, keys: Sequence[str], unit: str, span: tuple[float, float]) -> BranchPlan:
    """The plan of a branch through an orbit (a `vibsim.orbits.Orbit` with its case).

    Raises BranchError where no orbit depends on the key, the range is empty or the orbit is not within it.
    """
    case = orbit.case
    parameter = parameter_within(case, keys, unit, span)
    end = orbit.end
    travel = end.coordinates.travel(end.carried) or end.coordinates.size(end.X) or 1.0
    start = tuple(float(value) for value in orbit.X), orbit.period, parameter, travel
    return BranchPlan(case, tuple(keys), unit, (min(span), max(span)), orbit.n, *start)


def parameter_within(case: Case, keys: Sequence[str], unit: str, span: tuple[float, float]) -> float:
    """The parameter of the orbits of a case [unit], from which they can be followed over a range: what can be
    said before an orbit is looked for. Raises BranchError as `plan_from`.
    """
    must_matter(case, keys)
    parameter = value_in(case.quantity(keys[0]), unit)
    low, high = sorted(span)
    if not low < high:
        raise BranchError(f"the range {number(span[0], 6)}:{number(span[1], 6)} is empty")
    if not low <= parameter <= high:
        raise BranchError(
            f"the orbit is at {keys[0]} = {number(parameter, 6)} {unit}".rstrip()
            + f", outside the range {number(low, 6)}:{number(high, 6)}; begin from an orbit within it"
        )
    return parameter


def must_matter(case: Case, keys: Sequence[str]) -> None:
    """Raise BranchError for a number of the case that no orbit depends on."""
    for key in map(case.full_key, keys):
        if key.partition(".")[0] in ASIDE:
            raise BranchError(
                f"no orbit depends on {key}; follow a number of the bodies, the parts or the source"
            )


def value_in(quantity: Any, unit: str) -> float:
    """A quantity of the case as a number in a unit."""
    from vibsim.cases.values.pi import times_two_pi
    from vibsim.cases.values.units import UNITS

    one = UNITS[unit]
    turns = int(quantity.per_turn) - int(one.per_turn)
    value = quantity.value / one.factor
    return float(value) if turns == 0 else times_two_pi(value, turns)

"""Which bifurcation is to be followed, and over what."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from vibsim.branches.branch import Branch, SpecialPoint
from vibsim.branches.curve.arclength import tangent
from vibsim.branches.curve.correction import correct
from vibsim.branches.loci.locus import KINDS, WATCHED, Plane, PlanePoint, follow_pair
from vibsim.branches.plan import BranchError, BranchPlan, must_matter, value_in
from vibsim.branches.special.holding import held
from vibsim.branches.special.special import BRANCHING, GRAZING, NAMES, STICKING, TORUS
from vibsim.branches.special.touching import CONTACTS
from vibsim.cases.number import number
from vibsim.orbits.multipliers import nearest_to_circle
from vibsim.orbits.returns.word import changes

FIRST_STEP = 0.1  # scaled, that the first correction may have
WHY_NOT = {  # why no locus of a kind is followed, and what to do
    BRANCHING: ". Two branches cross there, which only a symmetry of the scene keeps up when a second "
    "parameter varies, and along such points the equations of a locus are singular; continue the branch at "
    "several values of the second parameter",
}


@dataclass(frozen=True)
class LocusPlan:
    """A bifurcation of a branch to be followed in its parameter and a second one.

    branch : plan of the branch; label, kind : of the special point
    keys, unit, span, value : of the second parameter, its range and its value on the branch
    state, period, parameter, pair : of the special point; pair: its multiplier, for a Neimark-Sacker point
    part : number of the stop that is grazed, or of the friction that begins to hold
    """

    branch: BranchPlan
    label: str
    kind: str
    keys: tuple[str, ...]
    unit: str
    span: tuple[float, float]
    value: float
    state: tuple[float, ...]
    period: float
    parameter: float
    pair: complex
    part: int = -1

    @cached_property
    def settings(self) -> dict[str, Any]:
        """All of it but the case, as plain data."""
        return {
            "branch": self.branch.settings,
            "label": self.label,
            "kind": self.kind,
            "keys": list(self.keys),
            "unit": self.unit,
            "span": list(self.span),
            "value": self.value,
            "state": list(self.state),
            "period": self.period,
            "parameter": self.parameter,
            "pair": [self.pair.real, self.pair.imag],
            "stop": self.part,
        }

    @staticmethod
    def from_settings(case: Any, settings: dict[str, Any]) -> "LocusPlan":
        """The plan that `settings` wrote down."""
        known = {**settings, "branch": BranchPlan.from_settings(case, settings["branch"])}
        for name in ("keys", "span", "state"):
            known[name] = tuple(settings[name])
        known["part"] = known.pop("stop")  # as files have called it since they knew of stops alone
        return LocusPlan(**{**known, "pair": complex(*settings["pair"])})

    @cached_property
    def fingerprint(self) -> str:
        """Of the case and the settings."""
        text = json.dumps([self.branch.case.sha256, self.settings])
        return hashlib.sha256(text.encode()).hexdigest()

    def plane(self, engine: str = "auto") -> Plane:
        """The orbits over both parameters."""
        scale = max(abs(self.value), abs(self.span[1] - self.span[0]) / 4)
        family = self.branch.family(engine)
        return Plane(family, self.keys, self.unit, scale, self.kind, self.pair, self.part)

    def start(self, plane: Plane) -> tuple[PlanePoint, np.ndarray]:
        """The first point, and the tangent there towards larger values of the second parameter.

        Raises ContinuationError.
        """
        family = plane.family_at(self.value)
        z = np.append(
            family.unknowns(np.array(self.state), self.period, self.parameter), self.value / plane.scale[-1]
        )
        along = np.eye(len(z))[-1]
        if self.kind in WATCHED:
            plane.watch(z)
        point = correct(plane, z, along, FIRST_STEP).point
        if self.kind == TORUS:
            follow_pair(plane, point)
        return point, tangent(point.jacobian(), along)

    @property
    def spans(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ranges of both parameters: of the first all that has a sense."""
        return self.first_span, self.span

    @property
    def first_span(self) -> tuple[float, float]:
        """Of the first parameter: that of the branch, widened to where the locus may lead."""
        low, high = self.branch.span
        return min(low, 0.25 * low), max(high, 4 * high)


def locus_plan(
    branch: Branch, label: str, keys: Sequence[str], unit: str, span: tuple[float, float]
) -> LocusPlan:
    """The plan of following the special point `label` of a branch over a second parameter.

    Raises BranchError for a label that is none or cannot be followed, a key that is the branch's own or
    that no orbit depends on, and a range without the value of the case.
    """
    try:
        special = branch.special(label)
    except KeyError as error:
        raise BranchError(str(error.args[0])) from None
    if special.kind not in KINDS:
        why = WHY_NOT.get(special.kind, "")
        raise BranchError(
            f"{label} is {NAMES[special.kind]}; loci are followed of {', '.join(KINDS)} points{why}"
        )
    if set(keys) & set(branch.plan.keys):
        raise BranchError(f"{keys[0]} is the parameter of the branch; a locus needs another")
    value = value_in(branch.case.quantity(keys[0]), unit)
    must_matter(branch.case, keys)
    low, high = sorted(span)
    if not low <= value <= high or low == high:
        raise BranchError(
            f"the branch is at {keys[0]} = {number(value, 6)} {unit}, outside the range "
            f"{number(low, 6)}:{number(high, 6)}"
        )
    pair = nearest_to_circle(special.orbit.multipliers)
    orbit = special.orbit
    where = orbit.state, orbit.period, orbit.parameter
    part = {GRAZING: touched, STICKING: holding}.get(special.kind, lambda _: -1)(special)
    of = branch.plan, label, special.kind, tuple(keys), unit, (low, high), value
    return LocusPlan(*of, *where, pair, part)


def touched(special: SpecialPoint) -> int:
    """Number of the stop that is grazed at a special point. Raises BranchError where there are several."""
    gone, come = changes(special.before, special.after)
    stops = {part for kind, part in gone + come if kind in CONTACTS}
    if len(stops) != 1:
        raise BranchError(f"{special.label}: {len(stops)} stops are grazed at once; a locus follows one")
    return stops.pop()


def holding(special: SpecialPoint) -> int:
    """Number of the friction that begins to hold at a reversal at a special point. Raises BranchError where
    sticks come or go in another way.
    """
    friction = held(special.before, special.after)
    if friction is None:
        raise BranchError(
            f"{special.label}: loci are followed where a reversal of one friction becomes a stick; here a "
            "sliding velocity touches zero, a stop comes to rest, or several things happen at once"
        )
    return friction

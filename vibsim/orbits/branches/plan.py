"""Plan of a branch: an orbit, the parameter, its range."""

import hashlib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from typing import Any

import numpy as np

from vibsim.cases import Case, UnknownKeyError
from vibsim.cases.problems import shown
from vibsim.cases.quantities import UNITS, number, parse_range, si_unit, without_log
from vibsim.engine.errors import EngineError
from vibsim.lazy import once
from vibsim.orbits import OrbitError, ReturnMap
from vibsim.orbits.branches.correction import ContinuationError, Pace
from vibsim.orbits.branches.family import Family, FamilyPoint, Reciprocal, ScenePath, restricted
from vibsim.orbits.branches.node import (
    ENERGY,
    Conserved,
    Node,
    node_at,
    what_is_not_conservative,
    without_still_sources,
)
from vibsim.orbits.newton import course_of
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.search import opened, start_of, unknowns
from vibsim.orbits.stability import largest_first
from vibsim.physics.elementary import times_two_pi, total
from vibsim.results.store import BESIDE, plain_data, stored

PACE = Pace()
FIRST_STEP = 0.1  # scaled, that the first correction of the start may have
ASIDE = ("run", "initial", "clearances", "rest_distance")  # sections of a case that move no orbit


class BranchError(ValueError):
    """A branch that cannot be continued as asked; the message says why.

    >>> import vibsim
    >>> try:
    ...     vibsim.continue_branch("I-C", {"omega": "7:9 Hz"})
    ... except vibsim.BranchError as error:
    ...     print(error)
    the orbit is at excitation.omega = 6.5 Hz, outside the range 7:9; begin from an orbit within it
    """


class CurvePlan:
    """Common base of the plans of branches and loci: dataclasses that are stored field by field."""

    noun: str  # what it is a plan of
    case: Any

    @property
    def title(self) -> str:
        """Of its file."""
        raise NotImplementedError

    @cached_property
    def settings(self) -> dict[str, Any]:
        """All of it but the case, as plain data."""
        return plain_data(self)

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of the case and the settings."""
        return hashlib.sha256(json.dumps([self.case.sha256, self.settings]).encode()).hexdigest()


@dataclass(frozen=True)
class BranchPlan(CurvePlan):
    """A branch to be continued from an orbit.

    keys : of the case, which all have the value of the parameter; unit : of the parameter
    span : range of the parameter, in that unit; n : periods of the source, or turns of the motor
    state, period, parameter : of the orbit that it starts from: unknowns on the section, time of return [s]
    travel : largest of its unknowns at its events, as weighed [m/s], which the state is measured by
    heading : scaled direction in which it is followed one way only, as away from a doubling; empty: both ways
    """

    case: Case = field(metadata=BESIDE)
    keys: tuple[str, ...]
    unit: str
    span: tuple[float, float]
    n: int = field(metadata=stored("periods"))
    state: tuple[float, ...]
    period: float
    parameter: float
    travel: float
    pace: Pace = PACE
    heading: tuple[float, ...] = ()

    noun = "branch"

    @property
    def title(self) -> str:
        return f"Periodic orbits of {self.case.name} over {self.keys[0]}"

    def family(self) -> Family:
        """The orbits over the parameter, scaled by the first."""
        family = self._family()
        span = abs(self.span[1] - self.span[0])
        family.scaled_by(np.array(self.state), self.period, self.parameter, span, self.travel)
        return family

    def _family(self) -> Family:
        if self.keys != (ENERGY,):
            return Family(self.case, self.keys, self.unit, self.n)

        return EnergyFamily(self.case, self.n, np.array(self.state))

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

    one = UNITS[unit]
    turns = int(quantity.per_turn) - int(one.per_turn)
    value = quantity.value / one.factor
    return float(value) if turns == 0 else times_two_pi(value, turns)


# Ranges of a parameter: FROM:TO with a unit.


FACTORS = {"": 1.0, "J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "kJ": 1e3}
ENERGIES = re.compile(r"\s*(?P<ends>[^:\sa-df-zA-DF-Z]+:[^:\sa-df-zA-DF-Z]+)\s*(?P<unit>[mku]?J|)\s*")


def read_span(
    case: Case, key: str, text: str, bare_rate: str = ""
) -> tuple[tuple[str, ...], str, tuple[float, float]]:
    """Dotted keys, unit and ends of a range such as "3:9 Hz" of a key, or of several, KEY=KEY.

    `bare_rate` is the unit of frequencies that have none; with "" they need one.

    Raises BranchError where it is no range or its ends are not allowed, UnknownKeyError for a key that is
    none of the case's numbers.
    """
    if not key or not isinstance(key, str):
        raise BranchError("name what is to vary: a key of the case, such as excitation.Omega0")
    keys = tuple(number_key(case, each.strip()) for each in key.split("="))
    measured = case.measured(keys[0])
    dimension = measured.dimension if measured else "number"
    rate = dimension == "angular rate"  # Hz or rad/s: nobody can guess which
    try:
        if text.count(":") != 1 or without_log(text) is not None:
            raise ValueError(text)
        low, high = parse_range(f"{text}/2", bare_rate if rate else si_unit(dimension).name)
    except ValueError as error:
        raise BranchError(f"{shown(text)} is not FROM:TO with an optional unit, such as 3:9 Hz") from error
    if rate and not low.unit:
        raise BranchError(f"{keys[0]}: frequencies need a unit, such as 3:9 Hz, got {shown(text)}")
    if UNITS[low.unit].dimension != dimension:
        raise BranchError(f"{keys[0]} is no {UNITS[low.unit].dimension}: {shown(text)}")
    ends = float(low.value), float(high.value)
    path = ScenePath(case, keys, low.unit)
    for end in ends:
        try:
            path.scene(end)
        except ValueError as error:
            raise BranchError(str(error)) from error
    return keys, low.unit, ends


def read_energy_span(text: str) -> tuple[float, float]:
    """Ends [J] of a range of energies such as "1e-5:0.1 J"; bare numbers are J. Raises BranchError."""
    match = ENERGIES.fullmatch(text)
    try:
        low, high = (float(each) for each in match["ends"].split(":")) if match else (nan, nan)
    except ValueError:
        match = None
    if match is None:
        raise BranchError(f"{shown(text)} is not FROM:TO with an optional unit, such as 0.01:1 J or 5:50 mJ")
    low, high = low * FACTORS[match["unit"]], high * FACTORS[match["unit"]]
    if not 0 < low < high:
        raise BranchError(f"{shown(text)}: energies must be above 0 and the first the lesser")
    return low, high


def number_key(case: Case, key: str) -> str:
    """The dotted key of a number of the case. Raises UnknownKeyError that names the key."""
    try:
        case.quantity(key)
        return case.full_key(key)
    except UnknownKeyError as error:
        words = str(error)
        raise UnknownKeyError(words if words.startswith(f"{key} ") else f"{shown(key)}: {words}") from None


# Backbone curves: the orbits of a scene that neither gains nor loses energy, continued in their energy.
#
# At one energy such orbits stand alone, though the map has the multiplier 1 of the energy, and one more for
# each momentum that is kept: P(X) = X says nothing in these directions. The energy E(X) = E and the momenta
# of the start are added. These are more equations than unknowns, of which some follow from the others:
# Newton's method takes the solution of least squares, which is exact at an orbit.


class EnergyFamily(Family):
    """The orbits of a conservative case over their energy [J]; momenta: those of the start [N s]."""

    conservative = True

    def __init__(self, case: Case, n: int, start: np.ndarray):
        super().__init__(case, (ENERGY,), "J", n)
        self._map = ReturnMap(conservative_scene(case), n)
        self.conserved = Conserved(self._map.scene, self._map.coordinates)
        self.momenta = self.conserved.momenta(start)

    def scaled_by(self, X: np.ndarray, T: float, parameter: float, span: float, travel: float) -> None:
        """Measure unknowns by an orbit, the energy by the greatest: amplitudes then set the steps."""
        super().scaled_by(X, T, parameter, span, travel)
        self.scale[-1] = parameter + span

    def map(self, parameter: float) -> ReturnMap:
        """One map: the energy is none of its numbers."""
        return self._map

    def _values(self, parameter: float) -> dict[str, str]:
        """None: the energy is none of its numbers."""
        return {}

    def __call__(self, z: np.ndarray) -> "EnergyPoint":
        """The motion over one return from scaled unknowns. Raises ContinuationError where it fails."""
        values = z * self.scale
        count = self._map.coordinates.count
        if not (values[count] > 0 and values[-1] > 0):
            raise ContinuationError("Newton's method asks for a time of return or an energy below zero")
        try:
            return EnergyPoint(self, z, self._map(values[:count], float(values[count])))
        except (EngineError, OrbitError, ValueError) as error:
            raise ContinuationError(str(error)) from error


class EnergyPoint(FamilyPoint):
    """A motion over one return, as a point of a backbone curve."""

    family: EnergyFamily
    first_slope = None  # each point has its own

    @once
    def residual(self) -> np.ndarray:
        """Residuals of closing, of the energy and of the momenta, scaled."""
        of, X = self.family.conserved, self.end.X
        energy = (of.energy(X) - self.parameter) / self.family.scale[-1]
        momenta = (of.momenta(X) - self.family.momenta) / self._momentum
        return np.concatenate([self._scaled(self.end), [energy], momenta])

    @property
    def _momentum(self) -> float:
        """A momentum to measure by [N s]."""
        return self.lap * float(total(self.family.conserved.m))

    @once
    def reciprocal(self) -> Reciprocal:
        """The multipliers that come in pairs."""
        of, weights = self.family.conserved, self.end.coordinates.weights
        rows = np.vstack([of.gradient(self.end.X), of.kept_rows]) / weights
        return Reciprocal(restricted(self.matrix * self.end.coordinates.ratios, rows))

    @once
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers, the largest first; those of what is kept are 1."""
        kept = len(self.matrix) - len(self.reciprocal.inner)
        every = [*self.reciprocal.multipliers, *[1.0 + 0j] * kept]
        return np.array(sorted(every, key=largest_first), dtype=complex)

    @once
    def fold(self) -> float:
        """det(P' - I) of the multipliers in pairs."""
        return self.reciprocal.fold

    @once
    def doubling(self) -> float:
        """det(P' + I) of the multipliers in pairs, but for its sign."""
        return self.reciprocal.doubling

    @once
    def slope(self) -> np.ndarray:
        """Derivative by the scaled energy: of what it is asked to be alone."""
        slope = np.zeros(len(self.residual))
        slope[len(self.z) - 1] = -1.0
        return slope

    @once
    def linear(self) -> np.ndarray:
        """Derivative by z without the energy."""
        of, X, scale = self.family.conserved, self.end.X, self.family.scale
        count = len(X)
        rows = np.zeros((1 + len(self.family.momenta), count + 1))
        rows[0, :count] = of.gradient(X) * scale[:count] / scale[-1]
        rows[1:, :count] = of.momentum_rows * scale[:count] / self._momentum
        return np.vstack([self._closing_matrix(), rows])

    def jacobian(self, slope: np.ndarray | None = None) -> np.ndarray:
        """Derivative of the residual by z."""
        return np.column_stack([self.linear, self.slope])

    def moved(self, step: np.ndarray, slope: np.ndarray | None = None) -> np.ndarray:
        """z after a Newton step."""
        return np.asarray(self.z + step)

    @property
    def narrow_slope(self) -> np.ndarray:
        """The same: it is exact."""
        return self.slope

    @property
    def settled(self) -> bool:
        """A motion without friction forgets nothing."""
        return True


def conservative_scene(case: Case) -> Any:
    """The scene of a case, its silent sources left out. Raises BranchError where it gains or loses energy."""
    scene = without_still_sources(case.scene())
    parts = what_is_not_conservative(scene)
    if parts:
        raise BranchError(
            f"{case.name} does not keep its energy: {', '.join(parts)}; a backbone curve is one of free "
            "vibrations without loss (c = 0, e = 1, no friction, no source)"
        )
    return scene


def energy_plan(source: Any, span: str) -> BranchPlan:
    """The plan of a backbone curve through an orbit (an `Orbit`, a stored one) or the start of a case or run.

    span : range of the energy, such as "1e-5:0.1 J". Raises BranchError, OrbitError.
    """
    low, high = read_energy_span(span)
    case, return_map, X, T = _start(source)
    conserved = Conserved(return_map.scene, return_map.coordinates)
    energy = conserved.energy(X)
    if not low <= energy <= high:
        raise BranchError(
            f"the start has an energy of {number(energy, 6)} J, outside the range "
            f"{number(low, 6)}:{number(high, 6)}; begin from an orbit, or an initial state, within it"
        )
    end = return_map(X, T)
    travel = end.coordinates.travel(end.carried) or end.coordinates.size(X)
    start = tuple(float(x) for x in X), T, energy, travel
    return BranchPlan(case, (ENERGY,), "J", (low, high), return_map.n, *start)


def _start(source: Any) -> tuple[Case, ReturnMap, np.ndarray, float]:
    """Case, return map, unknowns and time of return of what to begin with."""
    case: Case | None
    orbit: Any
    if isinstance(source, Orbit):
        case, orbit = source.case, source
    else:
        case, result = opened(source, None)
        orbit = result if result is not None and result.orbit is not None else None
    if case is None:
        raise BranchError("an orbit of a scene alone has no case that a backbone curve could be of")
    if orbit is not None:
        state, n, T = start_of(orbit)
        return_map = ReturnMap(conservative_scene(case), n)
        return case, return_map, unknowns(return_map.coordinates, state), float(T or 0)
    return_map = ReturnMap(conservative_scene(case), 1)
    course = course_of(return_map.scene, return_map.coordinates)
    if len(course.times) < 2:
        raise OrbitError("the run of the case does not swing; give it an initial displacement")
    return case, return_map, course.points[0], float(course.times[1] - course.times[0])

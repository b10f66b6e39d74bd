"""Backbone curves: the orbits of a scene that neither gains nor loses energy, continued in their energy.

At one energy such orbits stand alone, though the map has the multiplier 1 of the energy, and one more for
each momentum that is kept: P(X) = X says nothing in these directions. The energy E(X) = E and the momenta of
the start are added. These are more equations than unknowns, of which some follow from the others:
Newton's method takes the solution of least squares, which is exact at an orbit.
"""

from typing import Any

import numpy as np

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.energy import ENERGY, Conserved, what_is_not_conservative, without_still_sources
from vibsim.branches.curve.family import Family, FamilyPoint
from vibsim.branches.curve.reciprocal import Reciprocal, restricted
from vibsim.branches.plan import BranchError, BranchPlan
from vibsim.branches.span import read_energy_span
from vibsim.cases import Case
from vibsim.cases.number import number
from vibsim.engine.errors import EngineError
from vibsim.once import once
from vibsim.orbits import OrbitError, ReturnMap
from vibsim.orbits.multipliers import largest_first
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.search.finding import unknowns
from vibsim.orbits.search.seeking import opened, start_of
from vibsim.orbits.search.settling import course_of
from vibsim.physics.arithmetic.sums import total


class EnergyFamily(Family):
    """The orbits of a conservative case over their energy [J]; momenta: those of the start [N s]."""

    conservative = True

    def __init__(self, case: Case, n: int, start: np.ndarray, engine: str = "auto"):
        super().__init__(case, (ENERGY,), "J", n, engine)
        self._map = ReturnMap(conservative_scene(case), n, engine)
        self.conserved = Conserved(self._map.scene, self._map.coordinates)
        self.momenta = self.conserved.momenta(start)

    def scaled_by(self, X: np.ndarray, T: float, parameter: float, span: float, travel: float) -> None:
        """Measure unknowns by an orbit, the energy by the greatest: amplitudes then set the steps."""
        super().scaled_by(X, T, parameter, span, travel)
        self.scale[-1] = parameter + span

    def map(self, parameter: float) -> ReturnMap:
        """One map: the energy is none of its numbers."""
        return self._map

    def at(self, parameter: float) -> Case:
        """The case."""
        return self.case

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
        """What is left of closing, of the energy and of the momenta, scaled."""
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


def energy_plan(source: Any, span: str, engine: str = "auto") -> BranchPlan:
    """The plan of a backbone curve through an orbit (an `Orbit`, a stored one) or the start of a case or run.

    span : range of the energy, such as "1e-5:0.1 J". Raises BranchError, OrbitError.
    """
    low, high = read_energy_span(span)
    case, return_map, X, T = _start(source, engine)
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


def _start(source: Any, engine: str) -> tuple[Case, ReturnMap, np.ndarray, float]:
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
        return_map = ReturnMap(conservative_scene(case), n, engine)
        return case, return_map, unknowns(return_map.coordinates, state), float(T or 0)
    return_map = ReturnMap(conservative_scene(case), 1, engine)
    course = course_of(return_map.scene, return_map.coordinates, engine)
    if len(course.times) < 2:
        raise OrbitError("the run of the case does not swing; give it an initial displacement")
    return case, return_map, course.points[0], float(course.times[1] - course.times[0])

"""From a state near an orbit to the orbit, with its least period."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from vibsim.orbits.errors import OrbitError
from vibsim.orbits.matrices import singular_values
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.returns.coordinates import Coordinates, components_of
from vibsim.orbits.returns.return_map import Return, ReturnMap
from vibsim.orbits.search.newton import EPS, solve, tolerance
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.cases.case import Case

State = Mapping[str, float] | ArrayLike  # by name of the column, or all in a row
STILL = 1e-9  # of the size of the unknowns: a swing that is none
SAME = 64  # times what rounding makes of an unknown: two fixed points nearer than that are one


def find_orbit(
    scene: Scene,
    state: State,
    n: int = 1,
    T: float | None = None,
    engine: str = "auto",
    case: Case | None = None,
) -> Orbit:
    """The orbit of `scene` near `state`, which lies near the section.

    Parameters
    ----------
    state : by name of the column, e.g. {"x1": ..., "v1": ...} [m, m/s, rad, rad/s], or all in a row
    n : periods of the source, or turns of the motor; where the orbit that is found takes fewer, it has these
    T : time of return with a motor [s], estimated where it is left out
    case : what the orbit shall remember as its case

    Returns an `Orbit`. Raises NoSection, NotConverged, OrbitError.
    """
    return_map = ReturnMap(scene, n, engine)
    X = unknowns(return_map.coordinates, state)
    return least(Orbit(return_map, solve(return_map, X, T), case))


def unknowns(coordinates: Coordinates, state: State) -> np.ndarray:
    """The unknowns of a state by name or in a row. Raises OrbitError for what is none."""
    return coordinates.of(components_of(state, coordinates.columns))


def least(orbit: Orbit) -> Orbit:
    """The same orbit over its least period: divisors of n are tried, the smallest first.

    Raises OrbitError for a state of rest, which has any period.
    """
    if _rests(orbit.end):
        raise OrbitError(
            "nothing swings: Newton's method came to a state of rest, or of steady sliding; start from a "
            "motion further from it"
        )
    for n in (d for d in range(1, orbit.n) if orbit.n % d == 0):
        shorter = _shorter(orbit, n)
        if shorter is not None:
            return shorter
    return orbit


def _rests(end: Return) -> bool:
    """Whether the body whose turns are looked at has nowhere to turn."""
    section = end.coordinates.section
    if not section.turning:
        return False
    rate = 2 * pi / end.T
    return bool(abs(end.carried.rate[section.pinned]) <= STILL * rate * end.coordinates.size(end.X))


def _shorter(orbit: Orbit, n: int) -> Orbit | None:
    """The orbit over n periods, where it closes after these."""
    return_map = orbit.return_map.of(n)
    T = None if return_map.section.timed else orbit.period * n / orbit.n
    once = return_map(orbit.X, T)
    uncertainty = SAME * (tolerance(once) + _displaced(orbit))
    if once.residual > uncertainty:
        return None
    solution = solve(return_map, orbit.X, T)
    near = return_map.coordinates.size(solution.X - orbit.X) <= uncertainty
    return Orbit(return_map, solution, orbit.case) if near else None


def _displaced(orbit: Orbit) -> float:
    """How far rounding may have moved the fixed point [m/s, as weighed]: the tolerance by (I - P')^-1, and
    the motion in the rounding of the time at which it meets the section.
    """
    end = orbit.end
    weights = end.coordinates.weights
    matrix = (np.eye(len(weights)) - end.derivative) * (weights[:, None] / weights)
    smallest = singular_values(matrix).min(initial=1.0)
    return float(orbit.solution.tolerance / max(smallest, 1e-6) + EPS * end.T * end.pace)

"""The neighbourhood of a stable orbit from which motions come to it, and which points lie on the same orbit.

Let A be the derivative of the return map over the n periods of an orbit, in weighed unknowns. All its
multipliers lie inside the unit circle, so the sum

    P = 1 + A' A + (A^2)' A^2 + ...    solves    A' P A - P = -1

(Stein's equation), and V(y)^2 = y' P y falls by |y|^2 or more from one return to the next, as far as the map
is linear. How far that holds of the map itself is tested: motions from points on ellipsoids V = r, along all
axes and some other directions, must lower V. The radius is that of the largest of the ellipsoids, each twice
the one before, up to which all do. It is tested, and not proved, that the inside contracts; half of the
radius is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from vibsim.engine.errors import EngineError
from vibsim.orbits.coordinates import OrbitError, placed
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.return_map import Return, returns
from vibsim.orbits.search import SAME_ORBIT
from vibsim.orbits.stability import product

DOUBLINGS = 40  # of the number of terms in the sum P: multipliers up to 1 - 1e-11
SETTLED = 1e-13  # of P: what the next terms add to it
GROWS = 1e12  # of P: an orbit that contracts so slowly has no neighbourhood worth testing
SHELLS = 24  # ellipsoids, the largest of the size of the orbit
OTHER_DIRECTIONS = 8  # besides the axes
SEED = 1  # of these
SHARE = 0.25  # of the fall of V^2 by linear theory that a motion must show
TURNS_WITHIN = 1.5  # periods of the orbit that a disturbed motion has for as many turns
WITHIN = 0.5  # of the tested radius that is used


@dataclass(frozen=True)
class Neighbourhood:
    """An ellipsoid about a point of an orbit on the section.

    X : the point, by the unknowns (m)
    weights : by which unknowns are weighed [m/s]
    form : P (m, m)
    radius : V of the largest tested ellipsoid [m/s]; 0 where none contracts
    """

    X: np.ndarray
    weights: np.ndarray
    form: np.ndarray
    radius: float

    def sizes(self, points: np.ndarray) -> np.ndarray:
        """V of points (k, m) [m/s] (k)."""
        y = (points - self.X) * self.weights
        square = np.zeros(len(y))
        for i in range(y.shape[1]):
            for j in range(y.shape[1]):
                square = square + self.form[i, j] * y[:, i] * y[:, j]
        return np.sqrt(np.maximum(square, 0.0))

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Which of the points (k, m) lie inside, by half of the radius (k)."""
        return np.asarray(self.sizes(points) < WITHIN * self.radius)


def neighbourhood_of(orbit: Orbit) -> Neighbourhood:
    """The tested neighbourhood of a stable orbit; of radius 0 for every other one.

    Raises EngineError where the orbit itself cannot be run.
    """
    weights = orbit.end.coordinates.weights
    form = _form(orbit.end.derivative * orbit.end.coordinates.ratios) if orbit.stable else None
    if form is None:
        return Neighbourhood(orbit.X, weights, np.eye(len(weights)), 0.0)
    around = Neighbourhood(orbit.X, weights, form, inf)
    least_fall = SHARE / sum(np.diag(form).tolist())
    size = max(orbit.end.coordinates.size(orbit.X), orbit.end.coordinates.travel(orbit.end.carried))
    radius = 0.0
    for k in reversed(range(SHELLS)):
        tested = size * 0.5**k
        if not all(_falls(orbit, around, y * tested, least_fall) for y in _directions(form)):
            break
        radius = tested
    return Neighbourhood(orbit.X, weights, form, radius)


def _form(A: np.ndarray) -> np.ndarray | None:
    """P of the weighed derivative A, by doubling the number of terms; None where it does not settle."""
    P, power = np.eye(len(A)), np.asarray(A)
    for _ in range(DOUBLINGS):
        added = product(np.ascontiguousarray(power.T), product(P, power))
        P = P + added
        if not np.all(np.isfinite(P)) or np.abs(P).max() > GROWS:
            return None
        if np.abs(added).max() <= SETTLED * np.abs(P).max():
            return np.asarray(P)
        power = product(power, power)
    return None


def _directions(form: np.ndarray) -> Iterator[np.ndarray]:
    """Weighed disturbances with V = 1: both ways along every axis, and along some other directions."""
    m = len(form)
    drawn = np.random.default_rng(SEED).random((OTHER_DIRECTIONS, m)) - 0.5
    for direction in np.concatenate([np.eye(m), -np.eye(m), drawn]):
        terms = (direction[:, None] * form * direction).ravel().tolist()
        square = 0.0
        for term in terms:
            square += term
        yield direction / sqrt(square)


def _falls(orbit: Orbit, around: Neighbourhood, y: np.ndarray, least_fall: float) -> bool:
    """Whether V falls over one period of the orbit from X + y, y weighed."""
    X = orbit.X + y / around.weights
    try:
        image = _motion(orbit, X).image
    except (EngineError, OrbitError):
        return False
    before, after = around.sizes(np.stack([X, image])).tolist()
    return bool(after**2 <= (1 - least_fall) * before**2)


def _motion(orbit: Orbit, X: np.ndarray) -> Return:
    """The motion from X over the n periods of an orbit."""
    return_map = orbit.return_map
    if return_map.section.timed:
        return return_map.plain(X)
    if return_map.section.turning:
        at = return_map.coordinates
        scene = placed(return_map.scene, at.state(X), TURNS_WITHIN * orbit.period)
        times, _ = returns(scene, at, return_map.carrier.engine, first=return_map.n)
        if len(times) < return_map.n:
            raise OrbitError("the motion does not turn round as often as the orbit does")
        return return_map.plain(X, float(times[return_map.n - 1]))
    return return_map.plain(X, return_map.time_of_return(X, orbit.period))


# Which points lie on an orbit: one of its own at another phase of the source, or its mirror image.
#
# Where forces and base only change sign after half of their period, and all parts act alike on both sides,
# x(t) and -x(t + T/2) are motions of one scene. The image is not assumed: it has to be an orbit itself.


def lies_on(orbit: Orbit, X: np.ndarray, share: float = SAME_ORBIT) -> bool:
    """Whether the unknowns X are those of one of the orbit's points, to a share of its size."""
    return _near_one(orbit, X, orbit.points, share)


def is_mirrored(orbit: Orbit, X: np.ndarray, share: float = SAME_ORBIT) -> bool:
    """Whether X lies on the mirror image of an orbit: where its points are after half of the source's period,
    with the opposite sign. False for a motor, and where nothing drives the scene.
    """
    section = orbit.return_map.section
    if not section.timed:
        return False
    at, carrier = orbit.end.coordinates, orbit.return_map.carrier
    half = section.time(1) / 2
    states = [carrier.carry(at.lifted(point), half, []).state for point in orbit.points]
    return _near_one(orbit, X, -at.of(np.stack(states)), share)


def _near_one(orbit: Orbit, X: np.ndarray, points: np.ndarray, share: float) -> bool:
    weights = orbit.end.coordinates.weights
    at = orbit.end.coordinates
    size = max(at.size(orbit.X), at.travel(orbit.end.carried))
    points = at.in_turn_of(points.copy(), X)
    return bool((np.abs((points - X) * weights).max(axis=1) <= share * size).any())

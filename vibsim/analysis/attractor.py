"""The attractor that a run ends on: rest, a stable orbit, a quasi-periodic or chaotic set; or why none is.

A run whose points on the section come into the tested neighbourhood of a stable orbit ends on that orbit, and
need not be followed further. At the end of a run one Newton solve from its last point finds the orbit, where
there is one; what is left is judged by its points, as a regime is, with the largest Lyapunov exponent where
these leave a doubt.

The neighbourhood of a stable orbit from which motions come to it: let A be the derivative of the return map
over the n periods of an orbit, in weighed unknowns. All its multipliers lie inside the unit circle, so the
sum

    P = 1 + A' A + (A^2)' A^2 + ...    solves    A' P A - P = -1

(Stein's equation), and V(y)^2 = y' P y falls by |y|^2 or more from one return to the next, as far as the
map is linear. How far that holds of the map itself is tested: motions from points on ellipsoids V = r, along
all axes and some other directions, must lower V. The radius is that of the largest of the ellipsoids, each
twice the one before, up to which all do. It is tested, and not proved, that the inside contracts; half of the
radius is used.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import inf, nan, sqrt
from typing import Any

import numpy as np

from vibsim.analysis.regime import STILL
from vibsim.analysis.sections import JudgedPoints
from vibsim.engine.errors import EngineError
from vibsim.orbits.coordinates import Coordinates, OrbitError, placed
from vibsim.orbits.newton import growing, likely_periods, solve
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.return_map import Return, ReturnMap, returns, slowest_period
from vibsim.orbits.search import SAME_ORBIT, least
from vibsim.orbits.stability import moduli, product
from vibsim.physics.elementary import mean
from vibsim.physics.parts import EVENT_NAMES, Scene

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
        """Points (k, m) that lie inside, by half of the radius (k)."""
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
        times, _ = returns(scene, at, first=return_map.n)
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


# Which attractor a run ends on: rest, a stable orbit, a quasi-periodic or chaotic set; or why none is known.


TRIES = 3  # numbers of periods that Newton's method is tried with
STEPS = 8  # of Newton's method: an orbit that is near is met in four
NEAR = 0.2  # of the spread of the points: a run that comes no nearer to itself is on no orbit yet
FEWEST = 4  # points from which periods can be told
ON_ORBIT = 1e-6  # of the size of an orbit: a point nearer than that is on it
BLOCKS = 10  # of a section, whose means tell how well the mean of all is known
SWINGS = 64  # slowest periods that a free vibration is followed to see it repeat itself


@dataclass(frozen=True, eq=False)
class Label:
    """The attractor, or other end, of a run.

    kind : rest, periodic, quasi-periodic, chaotic, turning, running away or undecided
    reason : why it is undecided
    period : periods of the source, turns of the motor or swings of an orbit; NaN of anything else
    multiplier : greatest modulus of its multipliers; NaN of anything else
    state : unknowns on the section (m): of an orbit one of its points, of rest where it is
    means, errors : of sets that are not periodic, means over the section of the observables, see
        `observables`, and standard errors (k)
    time : when it was sure [s]; NaN: at the end of the run
    """

    kind: str
    reason: str = "decided"
    period: float = nan
    multiplier: float = nan
    state: np.ndarray = field(default_factory=lambda: np.empty(0))
    means: np.ndarray = field(default_factory=lambda: np.empty(0))
    errors: np.ndarray = field(default_factory=lambda: np.empty(0))
    time: float = nan


@dataclass(frozen=True, eq=False)
class KnownOrbit:
    """A stable orbit, and what tells that a run comes to it.

    label : of a run that ends on it
    around : its neighbourhood on the section; None where nothing drives the scene and the orbit has events:
        then states at events are compared
    orbit : itself
    """

    label: Label
    around: Neighbourhood | None
    orbit: Orbit

    @staticmethod
    def of(orbit: Orbit) -> KnownOrbit:
        """A stable orbit with its neighbourhood. Raises EngineError."""
        by_events = orbit.return_map.section.turning and len(orbit.events) > 0
        around = None if by_events else neighbourhood_of(orbit)
        return KnownOrbit(label_of(orbit), around, orbit)


def label_of(orbit: Orbit) -> Label:
    """Label of a run that ends on an orbit."""
    largest = float(moduli(orbit.multipliers).max(initial=0.0))
    return Label("periodic", period=float(orbit.n), multiplier=largest, state=orbit.X)


@dataclass(eq=False)
class KnownOrbits:
    """Stable orbits of one scene, whatever its start; runs are compared with them as they go."""

    orbits: list[KnownOrbit] = field(default_factory=list)

    def __bool__(self) -> bool:
        return bool(self.orbits)

    def add(self, orbit: Orbit) -> None:
        """Take another stable orbit, unless it is known."""
        if not any(one.orbit.n == orbit.n and lies_on(one.orbit, orbit.X) for one in self.orbits):
            self.orbits.append(KnownOrbit.of(orbit))

    def reached(self, times: np.ndarray, points: np.ndarray) -> Label | None:
        """Label of a run with these points on the section (k, m) at times [s] (k), where one of them lies in
        the neighbourhood of an orbit; of several the first.
        """
        for one in self.orbits:
            at = one.orbit.end.coordinates
            near = at.in_turn_of(points.copy(), one.orbit.X)
            inside = np.flatnonzero(one.around.holds(near) if one.around else [])
            if len(inside):
                return _at(one.label, float(times[inside[0]]))
        return None

    def met(self, kind: int, part: int, X: np.ndarray, time: float) -> Label | None:
        """The same of a run without a section in time, from one of its events: its kind and part, unknowns X
        and time. It has come to the orbit where this has the same event at the same state.
        """
        event = EVENT_NAMES[kind], part
        for one in self.orbits:
            at, carried = one.orbit.end.coordinates, one.orbit.end.carried
            states = [
                state for this, state in zip(carried.events, carried.states, strict=True) if this == event
            ]
            size = max(at.size(one.orbit.X), at.travel(carried))
            if any(at.size(at.in_turn_of(at.of(state), X) - X) <= ON_ORBIT * size for state in states):
                return _at(one.label, time)
        return None


def _at(label: Label, time: float) -> Label:
    return Label(label.kind, period=label.period, multiplier=label.multiplier, state=label.state, time=time)


# The end of a run under a periodic source: its last points on the section.


def orbit_at_end(return_map: ReturnMap, times: np.ndarray, points: np.ndarray) -> Orbit | None:
    """The stable orbit that a run has come to, from its points on the section (k, m) at `times` [s]; None
    where Newton's method finds none from the last point, or the run is not in its neighbourhood.
    """
    for orbit in _orbits_near(return_map, times, points):
        if orbit.stable and (lies_on(orbit, points[-1], ON_ORBIT) or _is_around(orbit, points)):
            return orbit
    return None


def _orbits_near(return_map: ReturnMap, times: np.ndarray, points: np.ndarray) -> Iterator[Orbit]:
    """Orbits that Newton's method finds from the last point, by the likeliest numbers of periods after which
    the run comes near itself; where one is unstable, the doubled one beside it too.
    """
    numbers, distances = likely_periods(points)
    at = return_map.coordinates
    size = float(np.abs(points * at.weights).max())
    for n in numbers[:TRIES]:
        settled = at.size(points[-1] - points[-1 - n]) <= ON_ORBIT * size
        if distances[n - 1] > NEAR and not settled:
            continue
        orbit = _solved(return_map.of(n), times, points)
        if orbit is not None:
            yield orbit
        if orbit is not None and not orbit.stable and 2 * n < len(points):
            doubled = _solved(return_map.of(2 * n), times, points)
            if doubled is not None:
                yield doubled


def _solved(over: ReturnMap, times: np.ndarray, points: np.ndarray) -> Orbit | None:
    """The orbit near the last point; None where Newton's method does not come to one."""
    T = None if over.section.timed else float(times[-1] - times[-1 - over.n])
    try:
        return least(Orbit(over, solve(over, points[-1], T, STEPS)))
    except (OrbitError, EngineError):
        return None


def _is_around(orbit: Orbit, points: np.ndarray) -> bool:
    """Whether one of the last points, as many as the orbit has, lies in its neighbourhood."""
    last = orbit.end.coordinates.in_turn_of(points[-orbit.n :].copy(), orbit.X)
    return bool(neighbourhood_of(orbit).holds(last).any())


def _is_still(orbit: Orbit) -> bool:
    """Whether nothing moves on an orbit, as where the force of a source is 0: it is a state of rest."""
    at, carrier = orbit.end.coordinates, orbit.return_map.carrier
    states = (carrier.carry(at.lifted(orbit.X), orbit.period * part / 3, []).state for part in (1, 2))
    moved = [at.size(at.of(state) - orbit.X) for state in states]
    return max(moved) <= STILL and not any(orbit.drift.values())


def label_of_points(scene: Scene, times: np.ndarray, points: np.ndarray) -> Label | None:
    """Label of a run by its last points on the section: an orbit or running away; None for anything else."""
    try:
        return_map = ReturnMap(scene, 1)
    except OrbitError:
        return Label("undecided", "no section")
    if len(points) < FEWEST:
        return Label("undecided", "too few cycles")
    points = return_map.coordinates.in_turn_of(points.copy(), points[-1])
    orbit = orbit_at_end(return_map, times, points)
    if orbit is not None:
        if _is_still(orbit):
            return Label("rest", state=orbit.X, means=orbit.X, errors=np.zeros(len(orbit.X)))
        return label_of(orbit)
    if growing(points, return_map.coordinates) is not None:
        return Label("running away", state=points[-1])
    return None


def label_of_set(judged: JudgedPoints, points: np.ndarray) -> Label:
    """Label of a run that ends on no orbit, from the verdict on its points (k, m)."""
    if judged.verdict in ("quasi-periodic", "chaotic"):
        means, errors = observables(points)
        return Label(str(judged.verdict), state=points[-1], means=means, errors=errors)
    reasons = {"periodic": "no stable orbit", "transient": "still on its way"}
    few = judged.chaos_number is None and judged.verdict == "undecided"
    return Label("undecided", reasons.get(str(judged.verdict), "too few cycles" if few else "tests disagree"))


def observables(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means over the points (k, m) of each unknown, of its square and of the size of its change from one
    point to the next (3 m), and their standard errors from the means of BLOCKS blocks, one behind the other.

    Neighbouring blocks are taken for independent: a block of a chaotic set is to be longer than its memory.
    """
    steps = np.abs(np.diff(points, axis=0))
    columns = [*points[1:].T, *(points[1:] * points[1:]).T, *steps.T]
    means, errors = [], []
    for column in columns:
        blocks = np.array([mean(block) for block in np.array_split(column, BLOCKS)])
        apart = blocks - mean(blocks)
        means.append(float(mean(column)))
        errors.append(float(np.sqrt(mean(apart * apart) / (BLOCKS - 1))))
    return np.array(means), np.array(errors)


# The end of a run that nothing drives: what it comes to from its last event on.


def orbit_of_free(scene: Scene, state: Mapping[str, float]) -> Orbit | None:
    """The stable orbit of a scene without a source that a run has come to, which goes on from a state (by
    name of the column); None where it finds none.
    """
    try:
        return_map = ReturnMap(scene, 1)
        if not return_map.section.turning:
            return None
        follow = placed(scene, state, SWINGS * slowest_period(scene))
        times, states = returns(follow, return_map.coordinates)
    except (OrbitError, EngineError):
        return None
    if len(times) < FEWEST:
        return None
    return orbit_at_end(return_map, times, return_map.coordinates.of(states))


def unknowns_at(at: Coordinates, columns: Mapping[str, Any]) -> np.ndarray:
    """Unknowns (k, m) of states by name of the column, each (k)."""
    return at.of(at.gathered({name: np.asarray(columns[name], dtype="f8") for name in at.columns}))


def rest_label(
    at: Coordinates | None, held: bool, low: Mapping[str, float], high: Mapping[str, float]
) -> Label:
    """Label of a run that comes to rest between the least and the greatest states, by column, at its end.

    held : whether friction holds it there, and would beside it too. Its `errors` are half of the ranges of
    the unknowns, infinite where it is held.
    """
    if at is None:
        return Label("rest")
    state = unknowns_at(at, {name: [(low[name] + high[name]) / 2] for name in at.columns})[0]
    half = unknowns_at(at, {name: [(high[name] - low[name]) / 2] for name in at.columns})[0]
    width = np.full(len(state), np.inf) if held else np.abs(half)
    return Label("rest", state=state, means=state, errors=width)

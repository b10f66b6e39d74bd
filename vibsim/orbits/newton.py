"""Newton's method for orbits, guarded: damped where a step makes it worse, and T never far from what it was.

The step solves (I - dP/dX) s = P(X) - X. The next start is taken as P(X) + dP/dX s, which is X + s: so what
the motion has forgotten, as behind a stick, comes from the image, and a body that sticks across the section
sticks there to the bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite, isnan
from typing import TYPE_CHECKING

import numpy as np

from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.engine.errors import EngineError, start_of
from vibsim.engine.resume import Row, rows_to_resume
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.coordinates import Coordinates, NotConverged, OrbitError, PoincareSection
from vibsim.orbits.return_map import Return, ReturnMap, returns, slowest_period
from vibsim.orbits.stability import dot, least_squares, product, solved_by_pivots
from vibsim.physics.connections import body_sets
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import EVENT_KINDS, RigidStop, Scene, Stop
from vibsim.physics.rates import source_period

if TYPE_CHECKING:
    from vibsim.results.result import Result


STEPS, HALVINGS = 40, 12
EPS = 2.0**-53
# A motion of some hundred operations per event, each rounded to EPS of its size, and what the derivative
# makes of them: rounding of P(X) - X.
OPERATIONS = 128
SINGULAR = 1e-9  # of the largest singular value of I - dP/dX: below, the equation says nothing on a direction
NEARLY, GOOD = 1e-3, 0.1  # the same, but for what is left of it nearby; by so much a step must help
CLOSE = 1e-6  # of the size of the motion at its end: no rounding is as large
STAGNANT = 16  # times the tolerance: a residual that no step makes smaller is rounding still


@dataclass(frozen=True)
class Solution:
    """A fixed point of a return map.

    end : the motion from it over one period of the orbit
    steps : Newton steps that it took
    tolerance : rounding of the residual [m/s, as weighed]; `end.residual` is not far above it
    """

    end: Return
    steps: int
    tolerance: float

    @property
    def X(self) -> np.ndarray:
        return self.end.X

    @property
    def T(self) -> float:
        return self.end.T


def solve(return_map: ReturnMap, X: np.ndarray, T: float | None = None, steps: int = STEPS) -> Solution:
    """The fixed point of `return_map` near the unknowns X, and near the time of return T [s] where it
    is free.

    Returns a `Solution`. Raises NotConverged, OrbitError.
    """
    end = _first(return_map, X, T)
    for taken in range(steps + 1):
        bound = _bound(end)
        if end.residual <= bound:
            return Solution(end, taken, bound)
        nearer = _next(return_map, end)
        if nearer is None and end.residual <= STAGNANT * tolerance(end):
            return Solution(end, taken, tolerance(end))
        if nearer is None:
            break
        end = nearer
    raise _failure(return_map, end, taken)


def _first(return_map: ReturnMap, X: np.ndarray, T: float | None) -> Return:
    """The motion from the start."""
    try:
        end = return_map(X, T)
    except EngineError as error:
        raise NotConverged(f"the motion from the start of Newton's method fails: {error}", np.inf) from error
    if end.stands_still:
        raise NotConverged(
            "the start of Newton's method does not come back to the section: what should turn round there "
            f"stands still after {end.T:.6g} s; {_remedy(end)}",
            np.inf,
        )
    if not _has_derivative(end):
        raise NotConverged(
            "the motion from the start of Newton's method has no derivative: at "
            f"{end.carried.undefined_at:.6g} s it grazes a rigid stop or strikes several at one instant, "
            "or the derivative of a formula is infinite there and has no integral; start a little beside it",
            end.residual,
        )
    return end


def _remedy(end: Return) -> str:
    """Advice where a motion has come to rest."""
    if any(friction.runs for friction in end.coordinates.scene.frictions):
        return "start from a run that has settled more"
    return "nothing feeds this scene, which comes to rest in the end; drive it, or take its losses out"


def _has_derivative(end: Return) -> bool:
    """Whether small disturbances of the start make small ones of the end."""
    return not end.stands_still and isfinite(end.residual) and isnan(end.carried.undefined_at)


def _bound(end: Return) -> float:
    """The tolerance; 0 for a motion so far from closing that it does not matter."""
    return tolerance(end) if end.residual <= CLOSE * end.coordinates.size(end.image) else 0.0


def _failure(return_map: ReturnMap, end: Return, steps: int) -> NotConverged:
    return NotConverged(
        f"no orbit of {counted(return_map.n, 'period')} near the start: Newton's method came to a residual "
        f"of {number(end.residual, 2)} m/s after {counted(steps, 'step')}; start from a run that has settled "
        "more, or an orbit at a parameter nearby",
        end.residual,
    )


def tolerance(end: Return) -> float:
    """Rounding of the residual of a motion [m/s, as weighed]."""
    at = end.coordinates
    gain = max(1.0, float(np.abs(end.flow_matrix * at.ratios).max()))
    size = max(at.size(end.X), at.size(end.image), at.travel(end.carried))
    return OPERATIONS * EPS * gain * size


def newton_step(end: Return, cut: float | None = None) -> tuple[np.ndarray, float]:
    """(change of X, change of T) that make the linearised map a fixed point.

    cut : leave out directions whose singular value is below so much of the largest, where it is given
    """
    at, tilt = end.coordinates, end.tilt
    matrix, right = at.one - end.derivative, end.difference
    if tilt is not None:
        right = right - end.rate * (end.ahead / tilt[1])
    scaled = matrix * at.ratios
    if cut is None:
        change = _solved(scaled, right * at.weights) / at.weights
    else:
        change = least_squares(scaled, right * at.weights, cut) / at.weights
    if tilt is None:
        return change, 0.0
    slopes, rate = tilt
    return change, -(end.ahead + dot(slopes, change)) / rate


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solution of matrix x = right; the shortest one where the matrix is singular."""
    change, pivots = solved_by_pivots(matrix, right)
    return change if pivots else least_squares(matrix, right, SINGULAR)


def _next(return_map: ReturnMap, end: Return) -> Return | None:
    """The motion after one step, damped where it must be; None where no step makes it better.

    A step far along a direction that is nearly singular, as beside a family of orbits, is tried without that
    direction first.
    """
    change, longer = newton_step(end)
    if end.coordinates.size(change) * NEARLY > end.residual:
        short, later = newton_step(end, NEARLY)
        after = _motion(return_map, _moved(end, short, later), end.T + later) if later > -end.T else None
        if after is not None and after.residual < GOOD * end.residual:
            return after
        change, longer = newton_step(end, SINGULAR)
    share = 1.0 if longer == 0 else min(1.0, end.T / (2 * abs(longer)))
    for _ in range(HALVINGS):
        X = _moved(end, change, longer) if share == 1.0 else end.X + share * change
        after = _motion(return_map, X, end.T + share * longer)
        if after is not None and after.residual < (1 - share / 4) * end.residual:
            return after
        share /= 2
    return None


def _moved(end: Return, change: np.ndarray, longer: float) -> np.ndarray:
    """X + change, as the image of the linearised map."""
    moved = product(end.flow_matrix, change)
    return np.asarray(end.image + (moved if end.tilt is None else moved + end.rate * longer))


def _motion(return_map: ReturnMap, X: np.ndarray, T: float) -> Return | None:
    """The motion from X, None where it fails, is asked for no time or has no derivative."""
    try:
        end = return_map(X, T)
    except (EngineError, OrbitError):
        return None
    return end if _has_derivative(end) else None


# Where a run goes: its last points on the section, followed for as long as it takes to see them repeat.


LONGEST = 64  # periods of an orbit looked for
MORE = 2 * LONGEST  # periods that a run is followed beyond its end
KEPT = 4 * LONGEST  # last points that are looked at
NEARLY_SETTLED = 4  # times the nearest: as near, where all come nearer with time


@dataclass(frozen=True)
class Course:
    """Points of a run on the section: times [s] (n) and unknowns X (n, m), the last ones; low, high: their
    extremes over the whole run (m).
    """

    times: np.ndarray
    points: np.ndarray
    low: np.ndarray
    high: np.ndarray


def course_of(
    scene: Scene,
    coordinates: Coordinates,
    resume: Sequence[Row] | None = None,
    more: int = MORE,
) -> Course:
    """The course of a run of `scene` to its end, and `more` periods of its source beyond it.

    resume : event rows to go on from, as of `open_trajectory`. Raises EngineError where the run fails.
    """
    if coordinates.section.turning:
        return _course_of_turns(scene, coordinates, resume, more)
    beyond = replace(scene, t_end=scene.t_end + more * source_period(scene), stop_on_violation=False)
    trajectory = open_trajectory(beyond.without_samples(), resume, section=True)
    times, points = np.empty(0), np.empty((0, coordinates.count))
    low, high = np.full(coordinates.count, np.inf), np.full(coordinates.count, -np.inf)
    for block in trajectory.blocks():
        X = coordinates.of(coordinates.gathered(block.section))
        low = np.minimum(low, X.min(axis=0, initial=np.inf))
        high = np.maximum(high, X.max(axis=0, initial=-np.inf))
        times = np.concatenate([times, block.section["time"]])[-KEPT:]
        points = np.concatenate([points, coordinates.in_turn_of(X, np.zeros_like(X))])[-KEPT:]
    return Course(times, points, low, high)


def _course_of_turns(
    scene: Scene, coordinates: Coordinates, resume: Sequence[Row] | None, more: int
) -> Course:
    """The same of a run that nothing drives."""
    beyond = replace(scene, t_end=scene.t_end + more * slowest_period(scene), stop_on_violation=False)
    times, states = returns(beyond, coordinates, resume)
    if not len(times):
        raise OrbitError(
            f"an orbit without a source is found where {coordinates.section.body} turns round; on this run "
            "it comes to rest, or keeps moving one way"
        )
    X = coordinates.of(states)
    return Course(times[-KEPT:], X[-KEPT:], X.min(axis=0), X.max(axis=0))


def first_point(scene: Scene, coordinates: Coordinates) -> np.ndarray:
    """Unknowns where a run of `scene` first is on the section: at t = 0, but for a motor that starts at
    another angle and a body that nothing drives, which are followed until they come to it.

    Raises OrbitError where they never do on the run, EngineError where that fails.
    """
    section = coordinates.section
    if section.turning:
        _, states = returns(scene, coordinates, None)
        if len(states):
            return coordinates.of(states[0])
    elif section.timed or _starts_on(scene, section):
        start = start_of(scene, Doubles)
        spin = [start.phase, start.w] if scene.motor is not None else []
        return coordinates.of([*start.x, *start.v, *spin])
    else:
        for block in open_trajectory(scene.without_samples(), section=True).blocks():
            if len(block.section["time"]):
                return coordinates.of(coordinates.gathered(block.section)[0])
    raise OrbitError(f"the run of the case never comes to the section, {section.place}; give a longer one")


def _starts_on(scene: Scene, section: PoincareSection) -> bool:
    """Whether the rotor whose turns count starts at an angle of 0."""
    if scene.motor is not None:
        return bool(scene.motor.phi == 0)
    return bool(scene.bodies[section.component].x == 0)


def course_of_result(result: Result, coordinates: Coordinates, more: int = MORE) -> Course:
    """The same of a stored run, from its last event on."""
    events = result.events
    last = int(np.flatnonzero(events["kind"] != EVENT_KINDS["end"])[-1])
    scene = replace(result.case.scene(), t_end=result.t_reached)
    return course_of(scene, coordinates, rows_to_resume(scene, events, last), more)


def likely_periods(points: np.ndarray) -> tuple[list[int], list[float]]:
    """Numbers of periods after which points (n, m) come near themselves, the likeliest first: the shortest of
    those that come about as near as any, then the others by distance. With them the distances after 1, 2, ...
    periods, relative to the spread of the points.
    """
    longest = min(LONGEST, len(points) // 2)
    spread = np.ptp(points, axis=0)
    scaled = points / np.where(spread > 0, spread, 1.0)
    distances = [float(np.abs(scaled[-k:] - scaled[-2 * k : -k]).max()) for k in range(1, longest + 1)]
    nearest = min(distances, default=0.0)
    order = np.argsort(distances, kind="stable") + 1
    about = [int(n) for n in sorted(order) if distances[n - 1] <= NEARLY_SETTLED * nearest]
    return about + [int(n) for n in order if n not in about], distances


# What of a run grows without end, period by period: why it comes to no orbit, in words.


LEAST = 4  # periods in a third of what is looked at
EVEN = (
    0.05  # of the growth over a third: how much it may differ from the line, or parabola, through all three
)
LASTING = 0.9  # of the growth over the first third that is left over the last: what settles has less
ROUNDING = 1e-9  # of the greatest value: no growth


def growing(points: np.ndarray, coordinates: Coordinates, n: int = 1) -> str | None:
    """Words on the unknowns that grow without end along the last points (k, m) of a run on its section, every
    n periods a turn of it; None where none does.

    A displacement alone drifts; where velocities grow, they are told in place of those that they carry along.
    """
    third = n * ((len(points) - 1) // (3 * n))
    if third < LEAST * n:
        return None
    last = points[-1 - 3 * third :]
    first, middle, behind = (last[(i + 1) * third] - last[i * third] for i in range(3))
    steps = last[n:] - last[:-n]
    steady = ((steps > 0).all(axis=0) | (steps < 0).all(axis=0)) & (abs(behind) >= LASTING * abs(first))
    steady &= abs(behind - 2 * middle + first) <= EVEN * abs(behind)
    steady &= abs(behind) > ROUNDING * abs(last).max(axis=0)
    if not steady.any():
        return None
    rates, grown = behind * n / third, np.flatnonzero(steady)
    speeds = [i for i in grown if coordinates.units[i] != "m"]
    told = [
        f"{coordinates.names[i]} by {number(rates[i], 4)} {coordinates.units[i]}".removesuffix(" 1")
        for i in speeds or grown
    ]
    every = "period" if n == 1 else f"{n} periods"
    changes = f"the run does not repeat itself: in each {every} it changes {' and '.join(told)}"
    if speeds:
        return f"{changes}; it speeds up for ever"
    return f"{changes}; {_released(coordinates, int(grown[0]))}"


def _released(coordinates: Coordinates, i: int) -> str:
    """Cause of a displacement that drifts, and advice."""
    scene = coordinates.scene
    body = coordinates.components.index(coordinates.names[i].partition("-")[0])
    stops = [stop.name for stop in _stops_of(scene, body)]
    if not stops:
        return "nothing holds it there"
    one, them = ("stop", "it") if len(stops) == 1 else ("stops", "them")
    return (
        f"it drifts away from the {one} {', '.join(stops)}; leave {them} out, and the motion has an orbit "
        "with a drift per period"
    )


def _stops_of(scene: Scene, body: int) -> list[Stop | RigidStop]:
    """The stops that alone join the set of a body, as springs do, to others."""
    sets = body_sets(scene, [link for link in scene.links if link.k])
    own = next(set(one.bodies) for one in sets if body in one.bodies)
    return [stop for stop in scene.stops if (stop.P in own) != (stop.Q in own)]

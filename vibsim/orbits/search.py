"""Newton on the return map, and where it begins: ends of runs, random starts, growing motions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import pi
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vibsim.cases.case import by_key, load_case
from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.engine.errors import EngineError
from vibsim.orbits.coordinates import (
    Coordinates,
    NotConverged,
    OrbitError,
    check_count,
    components_of,
    placed,
)
from vibsim.orbits.newton import (
    EPS,
    MORE,
    Course,
    course_of,
    course_of_result,
    first_point,
    growing,
    likely_periods,
    solve,
    tolerance,
)
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.return_map import Return, ReturnMap
from vibsim.orbits.stability import singular_values
from vibsim.physics.parts import Scene
from vibsim.results.result import Result
from vibsim.results.simulation import names_a_result, open_trajectory_file

if TYPE_CHECKING:
    from vibsim.cases.case import Case
    from vibsim.results.result import Result


# An orbit from a case, a run or another orbit: what `vibsim orbit` and `vibsim.orbit` do.


INITIAL = "initial"  # the start that is the case's own
STARTS_TRIED = 6  # numbers of periods that are tried
NEAR = 0.3  # of the spread of the points: an orbit further away is not where the run goes
FURTHER = 16 * MORE  # periods that a run is followed beyond its end where it is near an unstable orbit
FAR = 0.05  # of it: a run that comes no nearer to itself is not about to repeat itself


def orbit(
    source: Any,
    overrides: Mapping[str, Any] | None = None,
    start: Any = None,
    period: int | None = None,
) -> Orbit:
    """The periodic orbit that a run goes to, or one near a start.

    Parameters
    ----------
    source : a case, as of `load_case`; or a `Result` of `vibsim.simulate` or its file, which may hold a
        stored orbit
    overrides : values by key that replace those of the case, e.g. {"c": "0.03 N s/m"}
    start : near which state the orbit is: an `Orbit`, a `Result` that holds one, a state by name of the
        column or in their order, or "initial", the case's own at t = 0, where Newton's method begins at once;
        None: where the run of `source` comes to
    period : periods of the source, or turns of the motor, that it takes; None: as often as the run repeats
        itself, or as the start has

    Returns an `Orbit`. Raises OrbitError, CaseError, EngineError.

    >>> import vibsim
    >>> orbit = vibsim.orbit("gallery/friction-oscillator", {"drive.A": "1.6 N"})
    >>> orbit.n, bool(orbit.stable)
    (1, True)
    """
    if period is not None:
        check_count("period", period)
    case, result = opened(source, overrides)
    begin = start if start is not None else (result if _is_orbit(result) else None)
    if isinstance(begin, str):
        return _from_initial(case, begin, period)
    if begin is not None:
        return _from_start(case, begin, period)
    return _from_run(case, None if overrides else result, period)


def opened(source: Any, changes: Mapping[str, Any] | None) -> tuple[Case, Result | None]:
    """The case of a source, and the result where it is one, or the file of one."""

    if isinstance(source, str | PathLike) and names_a_result(Path(source)):
        source = open_trajectory_file(Path(source))
    result = source if isinstance(source, Result) else None
    case = load_case(source) if result is None else result.case
    return (case.with_values(changes) if changes else case), result


def _is_orbit(result: Result | None) -> bool:
    return result is not None and "orbit_periods" in result.attrs


def _from_start(case: Case, start: Any, period: int | None) -> Orbit:
    """The orbit near a start."""
    state, n, T = start_of(start)
    return_map = ReturnMap(case.scene(), period or n)
    X = unknowns(return_map.coordinates, state)
    T = T * return_map.n / n if T else None
    return least(Orbit(return_map, solve(return_map, X, T), case))


def _from_initial(case: Case, start: str, period: int | None) -> Orbit:
    """The orbit near the initial state of a case."""
    if start != INITIAL:
        raise OrbitError(f"the start is an orbit, a state or {INITIAL!r}, got {start!r:.60}")
    return_map = ReturnMap(case.scene(), period or 1)
    X = first_point(case.scene(), return_map.coordinates)
    return least(Orbit(return_map, solve(return_map, X), case))


def start_of(start: Any) -> tuple[Any, int, float | None]:
    """(state, periods, time of return [s] or None) of an `Orbit`, a `Result` or a state."""
    if isinstance(start, Orbit):
        return start.state, start.n, start.period
    if not hasattr(start, "attrs"):
        return start, 1, None
    if not _is_orbit(start):
        raise OrbitError("the start is a run and no stored orbit; take the run itself as the source")
    state = {name: float(start.events[name][0]) for name in start.events if name not in ("t", "kind", "part")}
    return state, start.attrs["orbit_periods"], start.attrs["orbit_period_s"]


def _from_run(case: Case, result: Result | None, period: int | None) -> Orbit:
    """The orbit that a run goes to."""
    return_map = ReturnMap(case.scene(), period or 1)
    orbit_there = _after(MORE, case, result, return_map, period)
    if orbit_there.stable or period:
        return orbit_there
    later = _after(FURTHER, case, result, return_map, period)  # a run may pass unstable orbits on its way
    return later if later.stable else orbit_there


def _after(more: int, case: Case, result: Result | None, return_map: ReturnMap, period: int | None) -> Orbit:
    """The orbit near the point to which a run comes `more` periods of its source beyond its end."""
    at = return_map.coordinates
    course = course_of(case.scene(), at, more=more) if result is None else course_of_result(result, at, more)
    if len(course.points) < 4:
        raise OrbitError(
            f"the run meets the section {counted(len(course.points), 'time')} only; give a longer one, "
            "or a start"
        )
    numbers, distances = ([period], None) if period else likely_periods(course.points)
    near = NEAR * np.ptp(course.points, axis=0).max(initial=0.0)
    return _nearest(case, return_map, course, numbers[:STARTS_TRIED], near, distances)


def _nearest(
    case: Case,
    return_map: ReturnMap,
    course: Course,
    numbers: Sequence[int],
    near: float,
    distances: list[float] | None,
) -> Orbit:
    """The first orbit that Newton's method finds near the last point, or else any that it finds."""
    X, elsewhere, failures = course.points[-1], None, []
    for n in numbers:
        over = return_map.of(n)
        T = None if over.section.timed else time_of_returns(course.times, n)
        try:
            solution = solve(over, X, T)
        except (NotConverged, EngineError) as error:
            failures.append(error)
            continue
        orbit_there = least(Orbit(over, solution, case))
        if len(numbers) == 1 or np.abs(solution.X - X).max() <= near or not near:
            return orbit_there
        elsewhere = elsewhere or orbit_there
    if elsewhere is not None:
        return elsewhere
    words = growing(course.points, return_map.coordinates, numbers[0])
    raise _nowhere(failures[0], distances) if words is None else OrbitError(words)


def time_of_returns(times: np.ndarray, n: int) -> float:
    """About how long n returns take [s]: the last ones, or the mean of all where there are not so many."""
    if n < len(times):
        return float(times[-1] - times[-1 - n])
    return n * float(times[-1] - times[0]) / (len(times) - 1)


def _nowhere(failure: OrbitError | EngineError, distances: list[float] | None) -> OrbitError | EngineError:
    if distances is None or min(distances) < FAR:
        return failure
    n = int(np.argmin(distances)) + 1
    return OrbitError(
        f"the run does not come near itself: nearest after {counted(n, 'period')}, to "
        f"{number(min(distances), 2)} of its spread; look for orbits that it leaves (search_orbits), or give "
        "period=N"
    )


# Orbits from random starts: those that runs go to, and those that Newton's method meets on the way.


SETTLE = 192  # periods that a start is followed before it is looked at again
TRIES_PER_START = 2  # numbers of periods that are tried behind them
WIDER = 2.0  # the box of the starts, by the extremes of a run of the case
MOST_RETURNS = 5  # of the orbits that a run may pass by
ROUGH = 12  # Newton steps: a start that needs more goes anywhere
SAME_ORBIT = 1e-6  # of the size of the points: orbits nearer than that are one


@dataclass(frozen=True)
class NewtonAttempt:
    """Result of Newton's method from one start.

    orbits : those that were not there before
    met : numbers of all that the start led to, in the order in which they were first found, from 0
    """

    number: int
    orbits: list[Orbit]
    met: tuple[int, ...] = ()


@dataclass
class SearchTally:
    """Counts of how often each orbit of a search was found, and estimates of those not found.

    counts : starts that led to each orbit
    starts : all of them
    """

    counts: list[int] = field(default_factory=list)
    starts: int = 0

    def add(self, attempt: NewtonAttempt) -> None:
        """Count what came of another start."""
        self.starts += 1
        self.counts += [0] * (max(attempt.met, default=-1) + 1 - len(self.counts))
        for i in attempt.met:
            self.counts[i] += 1

    def found(self, times: int) -> int:
        """Number of orbits found from so many starts."""
        return self.counts.count(times)

    @property
    def unseen(self) -> float:
        """Estimate of the orbits that can be found so and were not: f1 (f1 - 1) / (2 (f2 + 1)) (n - 1) / n
        of f1 orbits found once and f2 found twice in n starts, a lower bound on the average.

        A. Chao, Nonparametric estimation of the number of classes in a population, Scandinavian Journal of
        Statistics 11 (1984) 265-270, in its form without bias.
        """
        if not self.starts:
            return 0.0
        once, twice = self.found(1), self.found(2)
        return once * (once - 1) / (2 * (twice + 1)) * (self.starts - 1) / self.starts

    @property
    def next_is_new(self) -> float:
        """Estimate of the orbits that the next start finds and no start before: f1 / n.

        I. J. Good, The population frequencies of species and the estimation of population parameters,
        Biometrika 40 (1953) 237-264.
        """
        return self.found(1) / self.starts if self.starts else 0.0


def search_attempts(
    case: Case, count: int, seed: int = 0, period: int | None = None
) -> Iterator[NewtonAttempt]:
    """Look for orbits of a case from `count` random starts; a generator of `NewtonAttempt`s.

    The starts fill a box twice as wide as the extremes of a run of the case on the section. From each of them
    Newton's method looks for orbits of `period` periods, 1 where it is left out; the run from it for the
    orbit that it goes to, and for those of up to MOST_RETURNS periods, or of `period`, that it passes by.
    Raises OrbitError, EngineError.
    """
    scene = case.scene()
    return_map = ReturnMap(scene, period or 1)
    low, high = _box(scene, return_map)
    random = np.random.default_rng(seed)
    known: list[Orbit] = []
    for i in range(count):
        X = low + (high - low) * random.random(len(low))
        before, met = len(known), list[int]()
        for one in _from(case, return_map, X, period):
            number = next((k for k, other in enumerate(known) if same(one, other)), len(known))
            if number == len(known):
                known.append(one)
            met.append(number)
        yield NewtonAttempt(i, known[before:], tuple(sorted(set(met))))


def _box(scene: Scene, return_map: ReturnMap) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest of the unknowns of the starts (m)."""
    course = course_of(scene, return_map.coordinates)
    if not len(course.points):
        raise OrbitError(
            "the run of the case never meets the section, and starts are drawn from where it does"
        )
    middle, half = (course.low + course.high) / 2, WIDER * (course.high - course.low) / 2
    low, high = middle - half, middle + half
    if not (return_map.section.timed or return_map.section.turning):  # the rotor turns forwards
        low[-1] = max(low[-1], 0.1 * course.high[-1])
    return low, high


def _from(case: Case, return_map: ReturnMap, X: np.ndarray, period: int | None) -> Iterator[Orbit]:
    """The orbits from one start: the one that Newton's method finds, the one that the run goes to, and those
    that it passes by, where it comes near itself on its way.
    """
    yield from _solved(case, return_map, X, None)
    at, state = return_map.coordinates, return_map.coordinates.state(X)
    try:
        course = course_of(placed(case.scene(), state, 0.0), at, more=SETTLE)
    except EngineError:
        return
    if len(course.points) < 4:
        return
    numbers = [period] if period else likely_periods(course.points)[0][:TRIES_PER_START]
    for n in numbers:
        over = return_map.of(n)
        T = None if over.section.timed else float(course.times[-1] - course.times[-1 - n])
        yield from _solved(case, over, course.points[-1], T)
    for n in [period] if period else range(1, MOST_RETURNS + 1):
        if n < len(course.points):
            yield from _passed(case, return_map.of(n), course)


def _passed(case: Case, return_map: ReturnMap, course: Course) -> Iterator[Orbit]:
    """The orbit of so many returns near which a run passes: from the point that comes nearest to itself, as
    weighed, where that is no end of it.
    """
    n, weights = return_map.n, return_map.coordinates.weights
    steps = np.abs((course.points[n:] - course.points[:-n]) * weights).max(axis=1)
    k = int(np.argmin(steps))
    if k == len(steps) - 1 or steps[k] == 0:  # it has settled
        return
    T = None if return_map.section.timed else float(course.times[k + n] - course.times[k])
    yield from _solved(case, return_map, course.points[k], T)


def _solved(case: Case, return_map: ReturnMap, X: np.ndarray, T: float | None) -> Iterator[Orbit]:
    """The orbit near X, if there is one."""
    try:
        yield least(Orbit(return_map, solve(return_map, X, T, steps=ROUGH), case))
    except (OrbitError, EngineError):
        return


def same(one: Orbit, other: Orbit) -> bool:
    """Whether two orbits of a scene are one, wherever on them the section is met first."""
    if one.n != other.n or abs(one.period - other.period) > SAME_ORBIT * one.period:
        return False
    weights = one.end.coordinates.weights
    size = np.abs(one.points * weights).max(initial=0.0)
    return bool((np.abs((other.points - one.X) * weights).max(axis=1) <= SAME_ORBIT * size).any())


def search_orbits(
    source: Any,
    overrides: Mapping[str, Any] | None = None,
    *,
    count: int,
    seed: int = 0,
    period: int | None = None,
) -> list[Orbit]:
    """The distinct orbits that are found from `count` random starts.

    Parameters
    ----------
    source, overrides : as of `load_case`
    seed : of the starts
    period : periods of the source, or turns of the motor, that are asked for; None: as they come

    Returns a list of `Orbit`s. Raises OrbitError, CaseError, EngineError.

    >>> import vibsim
    >>> [orbit.n for orbit in vibsim.search_orbits("gallery/friction-oscillator", count=2, seed=1)]
    [1]
    """

    check_count("count", count)
    if period is not None:
        check_count("period", period)
    case = load_case(source, by_key("overrides", overrides, '{"Omega0": "6.5 Hz"}'))
    attempts = search_attempts(case, count, seed, period)
    return [one for attempt in attempts for one in attempt.orbits]


# From a state near an orbit to the orbit, with its least period.


State = Mapping[str, float] | ArrayLike  # by name of the column, or all in a row
STILL = 1e-9  # of the size of the unknowns: a swing that is none
SAME_ROUNDING = 64  # times what rounding makes of an unknown: two fixed points nearer than that are one


def find_orbit(
    scene: Scene,
    state: State,
    n: int = 1,
    T: float | None = None,
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
    return_map = ReturnMap(scene, n)
    X = unknowns(return_map.coordinates, state)
    return least(Orbit(return_map, solve(return_map, X, T), case))


def unknowns(coordinates: Coordinates, state: State) -> np.ndarray:
    """The unknowns of a state by name or in a row. Raises OrbitError for what is none."""
    return coordinates.of(components_of(state, coordinates.components))


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
    uncertainty = SAME_ROUNDING * (tolerance(once) + _displaced(orbit))
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

"""An orbit from a case, a run or another orbit: what `vibsim orbit` and `vibsim.orbit` do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.number import number
from vibsim.engine.errors import EngineError
from vibsim.orbits.errors import NotConverged, OrbitError, check_count
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.returns.return_map import ReturnMap
from vibsim.orbits.search.finding import least, unknowns
from vibsim.orbits.search.growing import growing
from vibsim.orbits.search.newton import solve
from vibsim.orbits.search.settling import (
    MORE,
    Course,
    course_of,
    course_of_result,
    first_point,
    likely_periods,
)

if TYPE_CHECKING:
    from vibsim.cases.case import Case
    from vibsim.results.result import Result

INITIAL = "initial"  # the start that is the case's own
TRIES = 6  # numbers of periods that are tried
NEAR = 0.3  # of the spread of the points: an orbit further away is not where the run goes
FURTHER = 16 * MORE  # periods that a run is followed beyond its end where it is near an unstable orbit
FAR = 0.05  # of it: a run that comes no nearer to itself is not about to repeat itself


def orbit(
    source: Any,
    overrides: Mapping[str, Any] | None = None,
    start: Any = None,
    period: int | None = None,
    engine: str = "auto",
) -> Orbit:
    """The periodic orbit that a run goes to, or one near a start.

    Parameters
    ----------
    source : a Case, the path of a case file or the name of a shipped case; or a `Result` of `vibsim.simulate`
        or its file, which may hold a stored orbit
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
        return _from_initial(case, begin, period, engine)
    if begin is not None:
        return _from_start(case, begin, period, engine)
    return _from_run(case, None if overrides else result, period, engine)


def opened(source: Any, changes: Mapping[str, Any] | None) -> tuple[Case, Result | None]:
    """The case of a source, and the result where it is one, or the file of one."""
    from vibsim.cases.loading import load_case
    from vibsim.results.opening import names_a_result, open_trajectory_file
    from vibsim.results.result import Result

    if isinstance(source, str | PathLike) and names_a_result(Path(source)):
        source = open_trajectory_file(Path(source))
    result = source if isinstance(source, Result) else None
    case = load_case(source) if result is None else result.case
    return (case.with_values(changes) if changes else case), result


def _is_orbit(result: Result | None) -> bool:
    return result is not None and "orbit_periods" in result.attrs


def _from_start(case: Case, start: Any, period: int | None, engine: str) -> Orbit:
    """The orbit near a start."""
    state, n, T = start_of(start)
    return_map = ReturnMap(case.scene(), period or n, engine)
    X = unknowns(return_map.coordinates, state)
    T = T * return_map.n / n if T else None
    return least(Orbit(return_map, solve(return_map, X, T), case))


def _from_initial(case: Case, start: str, period: int | None, engine: str) -> Orbit:
    """The orbit near the initial state of a case."""
    if start != INITIAL:
        raise OrbitError(f"the start is an orbit, a state or {INITIAL!r}, got {start!r:.60}")
    return_map = ReturnMap(case.scene(), period or 1, engine)
    X = first_point(case.scene(), return_map.coordinates, return_map.carrier.engine)
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


def _from_run(case: Case, result: Result | None, period: int | None, engine: str) -> Orbit:
    """The orbit that a run goes to."""
    return_map = ReturnMap(case.scene(), period or 1, engine)
    orbit_there = _after(MORE, case, result, return_map, period)
    if orbit_there.stable or period:
        return orbit_there
    later = _after(FURTHER, case, result, return_map, period)  # a run may pass unstable orbits on its way
    return later if later.stable else orbit_there


def _after(more: int, case: Case, result: Result | None, return_map: ReturnMap, period: int | None) -> Orbit:
    """The orbit near the point to which a run comes `more` periods of its source beyond its end."""
    at, engine = return_map.coordinates, return_map.carrier.engine
    course = (
        course_of(case.scene(), at, engine, more=more)
        if result is None
        else course_of_result(result, at, engine, more)
    )
    if len(course.points) < 4:
        raise OrbitError(
            f"the run meets the section {len(course.points)} times only; give a longer one, or a start"
        )
    numbers, distances = ([period], None) if period else likely_periods(course.points)
    near = NEAR * np.ptp(course.points, axis=0).max(initial=0.0)
    return _nearest(case, return_map, course, numbers[:TRIES], near, distances)


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
        f"the run does not come near itself: nearest after {n} periods, to {number(min(distances), 2)} of "
        "its spread; look for orbits that it leaves (search_orbits), or give period=N"
    )

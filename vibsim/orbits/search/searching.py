"""Orbits from random starts: those that runs go to, and those that Newton's method meets on the way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.errors import EngineError
from vibsim.orbits.errors import OrbitError, check_count
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.returns.return_map import ReturnMap
from vibsim.orbits.returns.start import placed
from vibsim.orbits.search.finding import least
from vibsim.orbits.search.newton import solve
from vibsim.orbits.search.settling import course_of, likely_periods
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.cases.case import Case

SETTLE = 192  # periods that a start is followed before it is looked at again
TRIES = 2  # numbers of periods that are tried behind them
WIDER = 2.0  # the box of the starts, by the extremes of a run of the case
ROUGH = 12  # Newton steps: a start that needs more goes anywhere
SAME = 1e-6  # of the size of the points: orbits nearer than that are one


@dataclass(frozen=True)
class Attempt:
    """What came of one start: orbits, none of which was there before."""

    number: int
    orbits: list[Orbit]


def search_attempts(
    case: Case, count: int, seed: int = 0, period: int | None = None, engine: str = "auto"
) -> Iterator[Attempt]:
    """Look for orbits of a case from `count` random starts; a generator of `Attempt`s.

    The starts fill a box twice as wide as the extremes of a run of the case on the section. From each of them
    Newton's method looks for orbits of `period` periods, 1 where it is left out, and the run from it for the
    orbit that it goes to. Raises OrbitError, EngineError.
    """
    scene = case.scene()
    return_map = ReturnMap(scene, period or 1, engine)
    low, high = _box(scene, return_map, engine)
    random = np.random.default_rng(seed)
    known: list[Orbit] = []
    for number in range(count):
        X = low + (high - low) * random.random(len(low))
        new = [one for one in _from(case, return_map, X, period, engine) if not _is_among(one, known)]
        distinct = [one for i, one in enumerate(new) if not _is_among(one, new[:i])]
        known += distinct
        yield Attempt(number, distinct)


def _box(scene: Scene, return_map: ReturnMap, engine: str) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest of the unknowns of the starts (m)."""
    course = course_of(scene, return_map.coordinates, engine)
    if not len(course.points):
        raise OrbitError(
            "the run of the case never meets the section, and starts are drawn from where it does"
        )
    middle, half = (course.low + course.high) / 2, WIDER * (course.high - course.low) / 2
    low, high = middle - half, middle + half
    if not (return_map.section.timed or return_map.section.turning):  # the rotor turns forwards
        low[-1] = max(low[-1], 0.1 * course.high[-1])
    return low, high


def _from(
    case: Case, return_map: ReturnMap, X: np.ndarray, period: int | None, engine: str
) -> Iterator[Orbit]:
    """The orbits from one start: the one that Newton's method finds, and the one that the run goes to."""
    yield from _solved(case, return_map, X, None)
    at, state = return_map.coordinates, return_map.coordinates.state(X)
    try:
        course = course_of(placed(case.scene(), state, 0.0), at, engine, more=SETTLE)
    except EngineError:
        return
    if len(course.points) < 4:
        return
    numbers = [period] if period else likely_periods(course.points)[0][:TRIES]
    for n in numbers:
        over = return_map.of(n)
        T = None if over.section.timed else float(course.times[-1] - course.times[-1 - n])
        yield from _solved(case, over, course.points[-1], T)


def _solved(case: Case, return_map: ReturnMap, X: np.ndarray, T: float | None) -> Iterator[Orbit]:
    """The orbit near X, if there is one."""
    try:
        yield least(Orbit(return_map, solve(return_map, X, T, steps=ROUGH), case))
    except (OrbitError, EngineError):
        return


def _is_among(orbit: Orbit, others: Iterable[Orbit]) -> bool:
    return any(same(orbit, other) for other in others)


def same(one: Orbit, other: Orbit) -> bool:
    """Whether two orbits of a scene are one, wherever on them the section is met first."""
    if one.n != other.n or abs(one.period - other.period) > SAME * one.period:
        return False
    weights = one.end.coordinates.weights
    size = np.abs(one.points * weights).max(initial=0.0)
    return bool((np.abs((other.points - one.X) * weights).max(axis=1) <= SAME * size).any())


def search_orbits(
    source: Any,
    count: int,
    seed: int = 0,
    period: int | None = None,
    engine: str = "auto",
    overrides: Mapping[str, Any] | None = None,
) -> list[Orbit]:
    """The distinct orbits that are found from `count` random starts.

    Parameters
    ----------
    source, overrides : as of `load_case`
    seed : of the starts
    period : periods of the source, or turns of the motor, that are asked for; None: as they come

    Returns a list of `Orbit`s. Raises OrbitError, CaseError, EngineError.

    >>> import vibsim
    >>> [orbit.n for orbit in vibsim.search_orbits("gallery/friction-oscillator", 2, seed=1)]
    [1]
    """
    from vibsim.cases.loading import load_case

    check_count("count", count)
    if period is not None:
        check_count("period", period)
    attempts = search_attempts(load_case(source, overrides), count, seed, period, engine)
    return [one for attempt in attempts for one in attempt.orbits]

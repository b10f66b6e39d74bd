"""One Newton solve decides: is there a stable orbit where the section ends, and does the run go there?

The section tells a period only where it has been seen often enough. An orbit is there or is not: Newton's
method finds it from the last point, its multipliers tell whether it attracts, and the distances of the points
from it whether the run comes nearer. So a motion that is still settling, or was seen for too few cycles, is
known to be periodic, and its exponents are those of the orbit.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain
from math import isfinite
from typing import Any

import numpy as np

from vibsim.analysis.regime.points import Judged
from vibsim.analysis.regime.recurrence import EXACT, MOSTLY, NEAR, SHRINKS, TOLERANCE
from vibsim.analysis.regime.section import Coordinates
from vibsim.cases.number import number
from vibsim.engine.errors import EngineError
from vibsim.orbits.errors import OrbitError
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.returns.return_map import ReturnMap
from vibsim.orbits.search.finding import least
from vibsim.orbits.search.newton import solve
from vibsim.orbits.search.settling import likely_periods
from vibsim.physics.parts import Scene

OPEN = (
    "periodic",
    "transient",
    "undecided",
)  # verdicts that an orbit can settle; the others have their evidence
TRIES = 2  # numbers of periods that are tried besides the one that the section tells
FEWEST = 12  # points from which a trend can be told
STEPS = 8  # of Newton's method: an orbit that is near is met in four

States = Mapping[str, np.ndarray]


def decided(
    judged: Judged, scene: Scene, states: States, coordinates: Coordinates, sizes: np.ndarray
) -> Judged:
    """The verdict on a section, settled by an orbit where there is one that the run goes to.

    states : the points of the section by name of the column, among them `time` [s], each (n)
    sizes : by which `coordinates` of them are divided
    """
    if judged.verdict not in OPEN or len(states["time"]) < FEWEST:
        return judged
    for orbit in _orbits(judged, scene, states):
        if not orbit.stable:
            continue
        distances = _distances(orbit, states, coordinates, sizes)
        if _is_approached(distances, judged.verdict == "periodic"):
            return _settled(judged, orbit, distances)
    return judged


def _orbits(judged: Judged, scene: Scene, states: States) -> Iterator[Orbit]:
    """Orbits near the last point; where one is unstable, the doubled one beside it too."""
    try:
        return_map = ReturnMap(scene)
    except OrbitError:
        return
    if return_map.section.turning:
        return
    at, times = return_map.coordinates, states["time"]
    X = at.of(np.stack([states[name] for name in at.columns], axis=1))
    told = [judged.period] if judged.period else []
    numbers = list(dict.fromkeys([*told, *likely_periods(X)[0][:TRIES]]))
    for n in chain.from_iterable((n, 2 * n) for n in numbers):
        if n >= len(X):
            continue
        over = return_map.of(n)
        T = None if over.section.timed else float(times[-1] - times[-1 - n])
        try:
            yield least(Orbit(over, solve(over, X[-1], T, STEPS)))
        except (OrbitError, EngineError):
            continue


def _distances(orbit: Orbit, states: States, coordinates: Coordinates, sizes: np.ndarray) -> np.ndarray:
    """Distance of each point from the orbit's of its place, relative to the vibration (n)."""
    columns, count = orbit.end.coordinates.columns, len(states["time"])
    place = np.arange(1 - count, 1) % orbit.n
    lifted = np.array([orbit.end.coordinates.lifted(point) for point in orbit.points])[place]
    both = {name: np.concatenate([states[name], lifted[:, i]]) for i, name in enumerate(columns)}
    both["time"] = np.concatenate([states["time"]] * 2)
    points = coordinates.points(both, sizes)
    return np.asarray(np.abs(points[:count] - points[count:]).max(axis=1))


def _is_approached(distances: np.ndarray, repeats: bool) -> bool:
    """Whether points come near and nearer, by their first and last quarter; those that repeat themselves need
    but be near.
    """
    first, last = (float(np.quantile(part, MOSTLY)) for part in np.array_split(distances, 4)[::3])
    near_enough = TOLERANCE if repeats else EXACT
    return last <= near_enough or (last <= NEAR and last <= SHRINKS * first)


def _settled(judged: Judged, orbit: Orbit, distances: np.ndarray) -> Judged:
    apart = np.flatnonzero(distances > TOLERANCE)
    onset = int(apart[-1]) + 1 if len(apart) else 0
    known: dict[str, Any] = {
        "multipliers": tuple((mu.real, mu.imag) for mu in orbit.multipliers.tolist()),
        "exponents": tuple(rate if isfinite(rate) else None for rate in orbit.exponents),
        "drift_rates": orbit.drift_rates,
    }
    if judged.verdict == "periodic" and judged.period == orbit.n:
        return replace(judged, **known)
    reason = f"a stable orbit is there, {number(distances[-1], 2)} of the vibration from the last point"
    return replace(
        judged,
        verdict="periodic",
        reason=reason,
        period=orbit.n,
        onset=onset if onset < len(distances) else None,
        step=float(distances[-1]),
        **known,
    )

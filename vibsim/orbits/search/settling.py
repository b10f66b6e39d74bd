"""Where a run goes: its last points on the section, followed for as long as it takes to see them repeat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vibsim.engine.resume import Row, rows_of_instant
from vibsim.engine.state import start_of
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.errors import OrbitError
from vibsim.orbits.returns.coordinates import Coordinates
from vibsim.orbits.returns.turning import returns, slowest_period
from vibsim.physics.arithmetic.numbers import Doubles
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene
from vibsim.physics.rates import source_period

if TYPE_CHECKING:
    from vibsim.results.result import Result

LONGEST = 64  # periods of an orbit looked for
MORE = 2 * LONGEST  # periods that a run is followed beyond its end
KEPT = 4 * LONGEST  # last points that are looked at
NEARLY = 4  # times the nearest: as near, where all come nearer with time


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
    engine: str = "auto",
    resume: Sequence[Row] | None = None,
    more: int = MORE,
) -> Course:
    """The course of a run of `scene` to its end, and `more` periods of its source beyond it.

    resume : event rows to go on from, as of `open_trajectory`. Raises EngineError where the run fails.
    """
    if coordinates.section.turning:
        return _course_of_turns(scene, coordinates, engine, resume, more)
    beyond = replace(scene, t_end=scene.t_end + more * source_period(scene), stop_on_violation=False)
    trajectory = open_trajectory(beyond.without_samples(), engine, resume, section=True)
    times, points = np.empty(0), np.empty((0, coordinates.count))
    low, high = np.full(coordinates.count, np.inf), np.full(coordinates.count, -np.inf)
    for block in trajectory.blocks():
        rows = [block.section[name] for name in coordinates.columns]
        X = coordinates.of(np.stack(rows, axis=1))
        low = np.minimum(low, X.min(axis=0, initial=np.inf))
        high = np.maximum(high, X.max(axis=0, initial=-np.inf))
        times = np.concatenate([times, block.section["time"]])[-KEPT:]
        points = np.concatenate([points, X])[-KEPT:]
    return Course(times, points, low, high)


def _course_of_turns(
    scene: Scene, coordinates: Coordinates, engine: str, resume: Sequence[Row] | None, more: int
) -> Course:
    """The same of a run that nothing drives."""
    beyond = replace(scene, t_end=scene.t_end + more * slowest_period(scene), stop_on_violation=False)
    times, states = returns(beyond, coordinates, engine, resume)
    if not len(times):
        raise OrbitError(
            f"an orbit without a source is found where {coordinates.section.body} turns round; on this run "
            "it comes to rest, or keeps moving one way"
        )
    X = coordinates.of(states)
    return Course(times[-KEPT:], X[-KEPT:], X.min(axis=0), X.max(axis=0))


def first_point(scene: Scene, coordinates: Coordinates, engine: str = "auto") -> np.ndarray:
    """Unknowns where a run of `scene` first is on the section: at t = 0, but for a motor that starts at
    another angle and a body that nothing drives, which are followed until they come to it.

    Raises OrbitError where they never do on the run, EngineError where that fails.
    """
    section = coordinates.section
    if section.turning:
        _, states = returns(scene, coordinates, engine, None)
        if len(states):
            return coordinates.of(states[0])
    elif section.timed or (scene.motor is not None and scene.motor.phi == 0):
        start = start_of(scene, Doubles)
        spin = [start.phase, start.w] if scene.motor is not None else []
        return coordinates.of([*start.x, *start.v, *spin])
    else:
        for block in open_trajectory(scene.without_samples(), engine, section=True).blocks():
            if len(block.section["time"]):
                return coordinates.of([block.section[name][0] for name in coordinates.columns])
    raise OrbitError(f"the run of the case never comes to the section, {section.place}; give a longer one")


def course_of_result(
    result: Result, coordinates: Coordinates, engine: str = "auto", more: int = MORE
) -> Course:
    """The same of a stored run, from its last event on."""
    events = result.events
    last = int(np.flatnonzero(events["kind"] != EVENT_KINDS["end"])[-1])
    scene = replace(result.case.scene(), t_end=result.t_reached)
    return course_of(scene, coordinates, engine, rows_of_instant(events, last), more)


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
    about = [int(n) for n in sorted(order) if distances[n - 1] <= NEARLY * nearest]
    return about + [int(n) for n in order if n not in about], distances

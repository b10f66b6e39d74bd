"""An attempt judged by the truth: its error at every instant, until when it is faithful, its events."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, nan, pi

import numpy as np

from vibsim.evidence.benchmark.event_counts import EventCount, count_events
from vibsim.evidence.benchmark.truth import Truth
from vibsim.evidence.peers.attempt import Attempt
from vibsim.physics.parts import Scene, columns_of
from vibsim.physics.rates import natural_rates, source_rates

FAITHFUL = 1e-3  # m: largest error of the displacements of a faithful run, a gap of the paper
SMALL = 0.05  # of the largest displacement, where that is smaller


@dataclass(frozen=True)
class Score:
    """error : largest error of the displacements at each instant [m], NaN beyond the end of the attempt;
    faithful_time : until when it stays within `faithful_error` [s]; events : counts until then by kind, of
    the kinds that the method reports
    """

    error: np.ndarray
    faithful_time: float
    events: dict[str, EventCount] = field(default_factory=dict)


def score(attempt: Attempt, truth: Truth, scene: Scene) -> Score:
    """Judge an attempt at the instants of the truth."""
    time = truth.samples["time"]
    error = np.full(len(time), nan)
    reached = min(len(attempt.states), len(time))
    error[:reached] = displacement_error(attempt.states[:reached], truth, displacements_of(scene))
    faithful = faithful_time(time, error, faithful_error(truth, scene))
    counts = count_events(truth.events, attempt.events, faithful, shortest_period(scene) / 4)
    return Score(error, faithful, {name: counts[name] for name in attempt.kinds})


def displacements_of(scene: Scene) -> list[str]:
    """Names of the columns of displacements; states have each of them in front of its velocity."""
    return [columns_of(body.name)[0] for body in scene.bodies]


def displacement_error(states: np.ndarray, truth: Truth, names: Sequence[str]) -> np.ndarray:
    """Largest error [m] of the displacements `names` in the states (rows, at the truth's first instants)."""
    apart = [np.abs(states[:, 2 * i] - truth.samples[name][: len(states)]) for i, name in enumerate(names)]
    return np.asarray(np.maximum.reduce(apart))


def faithful_error(truth: Truth, scene: Scene) -> float:
    """The largest error of a faithful run [m]: FAITHFUL, or a share of the largest displacement."""
    largest = max(float(np.abs(truth.samples[name]).max()) for name in displacements_of(scene))
    return min(FAITHFUL, SMALL * largest) if largest else FAITHFUL


def faithful_time(time: np.ndarray, error: np.ndarray, allowed: float) -> float:
    """The last instant [s] before the error passes the `allowed` one [m], or is not known."""
    lost = np.flatnonzero(~(error <= allowed))
    return float(time[max(lost[0] - 1, 0)] if len(lost) else time[-1])


def shortest_period(scene: Scene) -> float:
    """Shortest period in the motion [s]: of vibration with all stops in contact, or of a source."""
    fastest = max([*source_rates(scene), *natural_rates(scene, scene.stops)], default=0.0)
    return 2 * pi / fastest if fastest else inf

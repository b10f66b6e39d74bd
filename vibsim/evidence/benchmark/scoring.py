"""An attempt judged by the truth: its error at every instant, until when it is faithful, its events."""

from dataclasses import dataclass, field
from math import inf, nan, pi, sqrt
from typing import Any

import numpy as np

from vibsim.evidence.benchmark.event_counts import EventCount, count_events
from vibsim.evidence.benchmark.truth import Truth
from vibsim.evidence.peers.attempt import Attempt
from vibsim.physics.two_blocks import TwoBlocks

FAITHFUL = 1e-3  # m: largest error of the displacements of a faithful run, a gap of the paper


@dataclass(frozen=True)
class Score:
    """error : largest error of the displacements at each instant [m], NaN beyond the end of the attempt;
    faithful_time : until when it stays within FAITHFUL [s]; events : counts until then by kind, of the kinds
    that the method reports
    """

    error: np.ndarray
    faithful_time: float
    events: dict[str, EventCount] = field(default_factory=dict)


def score(attempt: Attempt, truth: Truth, scene: TwoBlocks) -> Score:
    """Judge an attempt at the instants of the truth."""
    time = truth.samples["time"]
    error = np.full(len(time), nan)
    reached = min(len(attempt.states), len(time))
    error[:reached] = displacement_error(attempt.states[:reached], truth)
    faithful = faithful_time(time, error)
    counts = count_events(truth.events, attempt.events, faithful, shortest_period(scene) / 4)
    return Score(error, faithful, {name: counts[name] for name in attempt.kinds})


def displacement_error(states: np.ndarray, truth: Truth) -> np.ndarray:
    """max(|dx1|, |dx2|) [m] of the states (rows, at the first instants of the truth)."""
    apart = [
        np.abs(states[:, column] - truth.samples[name][: len(states)])
        for column, name in ((0, "x1"), (2, "x2"))
        if name in truth.samples
    ]
    return np.maximum.reduce(apart)


def faithful_time(time: np.ndarray, error: np.ndarray) -> float:
    """The last instant [s] before the error passes FAITHFUL or is not known."""
    lost = np.flatnonzero(~(error <= FAITHFUL))
    return float(time[max(lost[0] - 1, 0)] if len(lost) else time[-1])


def shortest_period(scene: TwoBlocks) -> float:
    """Shortest period in the motion [s]: of the vibration in contact, of the free one, or of the source."""
    mass = scene.m1 + (scene.m3 if scene.has_motor else 0.0)
    mobility = 1 / mass + (1 / scene.m2 if scene.has_block2 else 0.0)
    stiffness = scene.k1 + (scene.k2 if scene.has_stop else 0.0)
    source: Any = {"none": 0.0, "harmonic": scene.omega, "motor": scene.Omega0}[scene.source]
    fastest = max(abs(source), sqrt(stiffness * mobility))
    return 2 * pi / fastest if fastest else inf

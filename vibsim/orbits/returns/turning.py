"""Runs of scenes that nothing drives, seen where a body turns round: the returns to their section.

The section is met where the velocity of the body comes through zero, at its least or its greatest
displacement. A run is sampled finely against its fastest vibration, and each crossing is found on the flow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from vibsim.engine.resume import Row
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.returns.section import Section
from vibsim.physics.parts import Scene
from vibsim.physics.rates import natural_rates

if TYPE_CHECKING:
    from vibsim.orbits.returns.coordinates import Coordinates

SAMPLES = 64  # in a period of the fastest vibration, all elastic stops in contact
FINEST = 10**9  # of a second: what times of samples are whole multiples of
LEAST = 1e-9  # share of a step: a motion needs some time
STEPS = 4  # of Newton's method for a crossing
MANY = 128  # slowest periods that a run is followed where it is not said how long


def slowest_period(scene: Scene) -> float:
    """Of the slowest natural vibration [s]."""
    return 2 * pi / natural_rates(scene, scene.stops)[0]


def returns(
    scene: Scene,
    at: Coordinates,
    engine: str = "auto",
    resume: Sequence[Row] | None = None,
    first: int | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and state components (n, N) where a run of `scene` meets its section.

    at : `Coordinates` of the scene; resume : event rows to go on from, as of `open_trajectory`
    first : so many are enough. Raises EngineError where the run fails.
    """
    step = max(1, int(FINEST * 2 * pi / natural_rates(scene, scene.stops)[-1] / SAMPLES))
    sampled = replace(scene, every_num=step, every_den=FINEST, stop_on_violation=False)
    carrier, p = Carrier(scene, engine), at.section.component
    times, states, last = [], [], np.empty((1 + len(at.columns), 0))
    for block in open_trajectory(sampled, engine, resume).blocks():
        rows = np.stack([block.samples[name] for name in ("time", *at.columns)])
        rows = np.concatenate([last, rows], axis=1)
        rates = at.section.sense * rows[1 + p]
        for i in np.flatnonzero((rates[:-1] < 0) & (rates[1:] >= 0)):
            passed, state = _crossing(carrier, rows[1:, i], rows[0, i + 1] - rows[0, i], at.section)
            times.append(rows[0, i] + passed)
            states.append(state)
        if first is not None and len(times) >= first:
            break
        last = rows[:, -1:]
    return np.array(times), np.array(states).reshape(-1, len(at.columns))


def _crossing(carrier: Carrier, state: np.ndarray, step: float, section: Section) -> tuple[float, np.ndarray]:
    """(time, state) of the crossing within a step behind a state."""
    s = step / 2
    for _ in range(STEPS):
        there = carrier.carry(state, s, [])
        v, a = there.state[section.component], there.rate[section.component]
        if section.sense * a > 0:
            s = min(max(s - v / a, LEAST * step), step)
    return s, carrier.carry(state, s, []).state

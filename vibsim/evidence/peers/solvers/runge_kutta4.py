"""The classical Runge-Kutta method of order 4 with a fixed step, sgn(v) and no events."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import ceil, isfinite

import numpy as np

from vibsim.evidence.peers.attempt import CONTACTS, Attempt
from vibsim.evidence.peers.equations.compiled import start_of
from vibsim.evidence.peers.solvers.eventless import eventless_motion
from vibsim.evidence.peers.solvers.sign_changes import SignChanges, depths_of
from vibsim.evidence.peers.time_limit import OutOfTime, TimeLimit
from vibsim.physics.parts import Scene

STAGES = 4  # right-hand sides of a step
ROUNDING = 1e-9  # of a step count: 50 ms / 1 ms is 50 steps and not 51


class RungeKutta4:
    """A scene stepped by `step` [s], or by the largest smaller step that divides the sampling interval."""

    def __init__(self, scene: Scene, step: float):
        self.scene, self.step = scene, step
        self.motion, self.depths = eventless_motion(scene), depths_of(scene)

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at the ascending `times` [s], from 0 to the end. Raises ArithmeticError where it fails."""
        state, motion = start_of(self.scene), self.motion
        changes = SignChanges(self.depths, state)
        samples, steps, stopped, grid = [state], 0, False, times.tolist()
        try:
            for start, end in pairwise(grid):
                count = max(ceil((end - start) / self.step - ROUNDING), 1)
                h = (end - start) / count
                for i in range(count):
                    state = rk4_step(motion, start + i * h, state, h)
                    changes.look(start + (i + 1) * h, state)
                if not isfinite(state[0]):
                    raise ArithmeticError(f"no longer finite at {end:g} s")
                samples.append(state)
                steps += count
                limit.check()
        except OutOfTime:
            stopped = True
        t_reached = grid[len(samples) - 1]
        evaluations = STAGES * steps
        return Attempt(np.array(samples), t_reached, steps, evaluations, changes.events, CONTACTS, stopped)


def rk4_step(
    motion: Callable[[float, Sequence[float]], Sequence[float]], t: float, state: list[float], h: float
) -> list[float]:
    """The state a step h [s] after `state`: Kutta (1901)."""
    a = motion(t, state)
    b = motion(t + h / 2, [x + h / 2 * rate for x, rate in zip(state, a, strict=True)])
    c = motion(t + h / 2, [x + h / 2 * rate for x, rate in zip(state, b, strict=True)])
    d = motion(t + h, [x + h * rate for x, rate in zip(state, c, strict=True)])
    stages = zip(state, a, b, c, d, strict=True)
    return [x + h / 6 * (p + 2 * (q + r) + s) for x, p, q, r, s in stages]

"""scipy's solve_ivp without events, in one call: what most people do."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vibsim.evidence.peers.attempt import CONTACTS, Attempt
from vibsim.evidence.peers.equations.compiled import start_of
from vibsim.evidence.peers.solvers.eventless import Motion, eventless_motion
from vibsim.evidence.peers.solvers.sign_changes import SignChanges, depths_of
from vibsim.evidence.peers.solvers.solver_steps import watched
from vibsim.evidence.peers.time_limit import OutOfTime, TimeLimit
from vibsim.physics.parts import Scene


class EventlessSolver:
    """A scene for solve_ivp with `method` at the tolerances rtol, atol.

    width : of the smoothed friction law tanh(v / width) [m/s]; None: sgn(v)
    """

    def __init__(self, scene: Scene, method: str, rtol: float, atol: float, width: float | None = None):
        self.scene, self.method = scene, method
        self.tolerances = {"rtol": rtol, "atol": atol}
        self.motion, self.depths = eventless_motion(scene, width), depths_of(scene)

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at the ascending `times` [s], from 0 to the end. Raises ArithmeticError where it fails."""
        start, motion = start_of(self.scene), self.motion
        steps = _Steps(times, SignChanges(self.depths, start), start, limit)
        stopped = False
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # LSODA warns where it fails, which is said anyway
            try:
                answer = solve_ivp(
                    steps.counted(motion), (0.0, times[-1]), start,
                    watched(self.method, steps.taken), times[-1:], **self.tolerances,
                )  # fmt: skip
                if answer.status < 0:
                    raise ArithmeticError(answer.message)
            except OutOfTime:
                stopped = True
        states, events = np.array(steps.samples), steps.changes.events
        return Attempt(states, steps.t, steps.count, steps.evaluations, events, CONTACTS, stopped)


class _Steps:
    """Samples and contacts gathered step by step: of a run that the limit ends, solve_ivp returns nothing."""

    def __init__(self, times: np.ndarray, changes: SignChanges, start: list[float], limit: TimeLimit):
        self.times, self.changes, self.limit = times, changes, limit
        self.samples, self.count, self.evaluations, self.t = [np.array(start)], 0, 0, 0.0

    def counted(self, motion: Motion) -> Callable[[float, np.ndarray], tuple[float, ...]]:
        """What solve_ivp calls."""

        def rates(t: float, state: np.ndarray) -> tuple[float, ...]:
            self.evaluations += 1
            return motion(t, state.tolist())

        return rates

    def taken(self, solver: Any) -> None:
        """Look at the step that `solver` has just taken."""
        self.count += 1
        self.t = solver.t
        passed = len(self.samples)
        if passed < len(self.times) and self.times[passed] <= solver.t:
            ahead = int(np.searchsorted(self.times, solver.t, side="right"))
            self.samples += list(solver.dense_output()(self.times[passed:ahead]).T)
        self.changes.look(solver.t, solver.y)
        self.limit.check()

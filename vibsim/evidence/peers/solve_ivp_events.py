"""scipy's solve_ivp with terminal events, one call per mode."""

import warnings
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vibsim.evidence.peers.attempt import EVERY_KIND, Attempt
from vibsim.evidence.peers.equations import Equations
from vibsim.evidence.peers.mode import Mode
from vibsim.evidence.peers.solver_steps import watched
from vibsim.evidence.peers.time_limit import OutOfTime, TimeLimit
from vibsim.evidence.peers.tolerances import SHARE
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.two_blocks import TwoBlocks


class EventSolver:
    """A scene for solve_ivp with `method` ("DOP853", "Radau", "LSODA", ...) at the tolerance rtol."""

    def __init__(self, scene: TwoBlocks, method: str, rtol: float):
        self.scene, self.method = scene, method
        self.tolerances = {"rtol": rtol, "atol": SHARE * rtol}

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at the ascending `times` [s], from 0 to the end. Raises ArithmeticError where it fails."""
        run = _EventRun(self, times, limit)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # LSODA warns where it fails, which is said anyway
            return run.attempt()


class _EventRun:
    """One run in progress."""

    def __init__(self, peer: EventSolver, times: np.ndarray, limit: TimeLimit):
        self.times, self.limit, self.tolerances = times, limit, peer.tolerances
        self.equations = Equations(peer.scene)
        self.solver = watched(peer.method, self._taken)
        self.t, self.state = 0.0, self.equations.start()
        self.mode = Mode(self.equations, self.state)
        self.steps = 0
        self.samples: list[np.ndarray] = []
        self.sampled = 0
        self.events: list[tuple[float, int]] = []

    def attempt(self) -> Attempt:
        """Run to the end or to the limit."""
        stopped = False
        try:
            while self.t < self.times[-1]:
                self._call()
        except OutOfTime:
            stopped = True
        states = np.concatenate(self.samples) if self.samples else np.empty((0, len(self.state)))
        evaluations = self.equations.evaluations
        return Attempt(states, self.t, self.steps, evaluations, self.events, EVERY_KIND, stopped)

    def _call(self) -> None:
        """One call of solve_ivp, to the end of the mode."""
        functions = self.mode.event_functions()
        answer = solve_ivp(
            self._motion, (self.t, self.times[-1]), self.state, self.solver, self.times[self.sampled :],
            events=functions or None, **self.tolerances,
        )  # fmt: skip
        if answer.status < 0:
            raise ArithmeticError(answer.message)
        if len(answer.t):
            self.samples.append(answer.y.T)
            self.sampled += len(answer.t)
        if answer.status == 0:
            self.t = self.times[-1]
            return
        happened = next(i for i, times in enumerate(answer.t_events) if len(times))
        self.t = float(answer.t_events[happened][0])
        self.state = answer.y_events[happened][0].tolist()
        kind = self.mode.switch(functions[happened], self.state)
        if kind is not None:
            self.events.append((self.t, EVENT_KINDS[kind]))

    def _motion(self, t: float, state: np.ndarray) -> tuple[float, ...]:
        return self.mode.motion(t, state.tolist())

    def _taken(self, solver: Any) -> None:
        self.steps += 1
        self.limit.check()

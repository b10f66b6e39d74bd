"""scipy's solve_ivp with terminal events, one call per mode.

solve_ivp looks at events at the ends of its steps alone (scipy 9228): a free flight is one step, and what is
met in it is passed through. So steps are at most a share of the shortest period of the motion.
"""

import warnings
from collections.abc import Callable
from math import inf, pi
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vibsim.evidence.peers.attempt import Attempt, kinds_of
from vibsim.evidence.peers.automaton.mode import Mode
from vibsim.evidence.peers.automaton.strike import NEVER, Shortest
from vibsim.evidence.peers.equations.compiled import Compiled, start_of
from vibsim.evidence.peers.solvers.progress import Progress
from vibsim.evidence.peers.solvers.solver_steps import watched
from vibsim.evidence.peers.solvers.tolerances import SHARE
from vibsim.evidence.peers.time_limit import OutOfTime, TimeLimit
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene
from vibsim.physics.rates import fastest_rate

INSIDE = 1e-300  # stands for an event function that is exactly 0: solve_ivp takes 0 after 0 for an event
LONGEST = 0.25  # of the shortest period with all stops closed: a step; a contact lasts half of it
FIRST = 0.25  # of a hop that has just begun: its first step, so that the next ones see it end
BEHIND_A_BLOW = 0.01  # of the longest step, where the hop has no end in sight yet


class EventSolver:
    """A scene for solve_ivp with `method` ("DOP853", "Radau", "LSODA", ...) at the tolerance rtol."""

    def __init__(self, scene: Scene, method: str, rtol: float):
        self.scene, self.method = scene, method
        rate = fastest_rate(scene)
        longest = LONGEST * 2 * pi / rate if rate else inf
        self.settings = {"rtol": rtol, "atol": SHARE * rtol, "max_step": longest}
        self.compiled = Compiled(scene)

    def run(self, times: np.ndarray, limit: TimeLimit) -> Attempt:
        """States at the ascending `times` [s], from 0 to the end. Raises ArithmeticError where it fails."""
        run = _EventRun(self, times, limit)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # LSODA warns where it fails, which is said anyway
            return run.attempt()


class _EventRun:
    """One run in progress."""

    def __init__(self, peer: EventSolver, times: np.ndarray, limit: TimeLimit):
        self.times, self.limit, self.settings = times, limit, peer.settings
        self.compiled, self.scene = peer.compiled, peer.scene
        self.solver = watched(peer.method, self._taken)
        self.t, self.state = 0.0, start_of(peer.scene)
        self.mode = Mode(self.compiled, Shortest(peer.settings["atol"]))
        self.progress = Progress()
        self.events = self._named(self.mode.begin(self.state))
        self.steps = self.evaluations = self.sampled = 0
        self.samples: list[np.ndarray] = []

    def attempt(self) -> Attempt:
        """Run to the end or to the limit."""
        stopped = False
        try:
            while self.t < self.times[-1]:
                self._call()
        except OutOfTime:
            stopped = True
        states = np.concatenate(self.samples) if self.samples else np.empty((0, len(self.state)))
        kinds = kinds_of(self.scene)
        return Attempt(states, self.t, self.steps, self.evaluations, self.events, kinds, stopped)

    def _call(self) -> None:
        """One call of solve_ivp, to the end of the mode."""
        (owners, ends), span = self._ends(), (self.t, self.times[-1])
        answer = solve_ivp(
            self._motion, span, np.array(self.state), self.solver, self.times[self.sampled :],
            events=ends or None, first_step=self._first_step(), **self.settings,
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
        self.events += self._named(self.mode.switch(owners[happened], self.t, self.state))
        self.progress.event(self.t)

    def _first_step(self) -> float | None:
        """Of a call behind a blow; None leaves it to solve_ivp, which would step over the whole hop."""
        if self.mode.hop_ends == NEVER:
            return None
        step = min(self.mode.hop_ends * FIRST, self.settings["max_step"] * BEHIND_A_BLOW)
        return step if step < self.times[-1] - self.t else None

    def _named(self, kinds: list[str]) -> list[tuple[float, int]]:
        return [(self.t, EVENT_KINDS[kind]) for kind in kinds]

    def _motion(self, t: float, state: np.ndarray) -> tuple[float, ...]:
        self.evaluations += 1
        rates: tuple[float, ...] = self.compiled.motion(t, state.tolist(), self.mode.parameters)
        return rates

    def _ends(self) -> tuple[list[int], list[Callable[..., float]]]:
        """The event functions of the mode, terminal and falling, and the part of each."""
        states = enumerate(self.mode.states)
        pairs = [(i, self._end(end)) for i, state in states for end in self.compiled.ends(i, state)]
        return [i for i, _ in pairs], [end for _, end in pairs]

    def _end(self, function: Callable[..., Any]) -> Callable[..., float]:
        parameters = self.mode.parameters

        def end(t: float, state: np.ndarray) -> float:
            return function(t, state.tolist(), parameters)[0] or INSIDE

        end.terminal, end.direction = True, -1  # type: ignore[attr-defined]
        return end

    def _taken(self, solver: Any) -> None:
        self.steps += 1
        self.limit.check()

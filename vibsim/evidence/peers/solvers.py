"""The solvers themselves: scipy's with events and without, the classical Runge-Kutta method."""

import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf, isfinite, pi
from typing import Any

import numpy as np
import scipy.integrate
from scipy.integrate import solve_ivp

from vibsim.evidence.peers.automaton import NEVER, Mode, Shortest, rk4_step
from vibsim.evidence.peers.equations import (
    Compiled,
    Equations,
    ModeEquations,
    Number,
    start_of,
    state_count,
    tie_parameters,
)
from vibsim.evidence.peers.straight_line import REST, STICK, OperationLog, switches_of
from vibsim.physics.parts import AT_FORCE, EVENT_KINDS, Friction, Scene, Stop
from vibsim.physics.rates import fastest_rate

# Equations of motion with the switches left inside: what is written down when nobody looks for events.
#
# An elastic stop acts wherever its depth is positive, and friction follows a function of the velocity of
# slip: sgn as printed in Eq. (2.7), or tanh(v / width), which smooths it (then bodies creep instead of
# sticking). Rigid stops cannot be written so.


Motion = Callable[[float, Sequence[float]], tuple[float, ...]]


def eventless_motion(scene: Scene, width: float | None = None) -> Motion:
    """d state/dt at (t, state), whatever the mode there; width of tanh [m/s], None for sgn."""
    tape = OperationLog(state_count(scene))
    at = Equations(scene, tape, tape.t, tape.states)
    switches = switches_of(scene)
    weights: list[Number] = []
    acting: list[Number] = []
    for switch in switches:
        slides, idle = isinstance(switch.part, Friction), [0.0] * (len(switch.states) - 2)
        weights += _slipping(tape, at, switch.part, width) if slides else _in_contact(tape, at, switch.part)
        acting += _ways(tape, at, switch.part) if slides else weights[-2:]
        weights, acting = weights + idle, acting + idle
    untied = tie_parameters(scene, [switch.states[0] for switch in switches])
    return tape.function(ModeEquations(scene, tape, tape.t, tape.states, [*weights, *untied], acting).rates)


def _slipping(tape: OperationLog, at: Equations, part: Friction, width: float | None) -> list[Number]:
    """Shares of slip forwards and backwards, 0 to 1."""
    slip = at.slip_velocity(part)
    sign = tape.sgn(slip) if width is None else tape.tanh(slip / width)
    return [tape.where(slip, sign, 0.0), tape.where(slip, 0.0, -sign)]


def _ways(tape: OperationLog, at: Equations, part: Friction) -> list[Number]:
    """1 or 0: whether it slips forwards, and backwards."""
    slip = at.slip_velocity(part)
    return [tape.where(slip, 1.0, 0.0), tape.where(slip, 0.0, 1.0)]


def _in_contact(tape: OperationLog, at: Equations, part: Stop) -> list[Number]:
    """0 for free, and whether it acts."""
    deep = tape.where(at.depth(part), 1.0, 0.0)
    if part.release != AT_FORCE:
        return [0.0, deep]
    label = ("deep", part.name)
    at.formulas.flags[label] = deep
    return [0.0, tape.choose(deep, tape.where(at.contact_force(part, label), 1.0, 0.0), 0.0)]


# What a peer's run comes to.


@dataclass
class Attempt:
    """One run of one method.

    Attributes
    ----------
    states : x, v of each body in turn (, phi, phidot) at the first of the instants asked for
        (reached, states)
    t_reached : time until which it ran [s]
    steps : steps taken
    evaluations : right-hand sides evaluated; None for a method that evaluates series instead
    events : (time [s], kind code) of the events that it reports, ascending
    kinds : names of the kinds of event that it can report at all
    stopped : whether the time limit ended it
    """

    states: np.ndarray
    t_reached: float
    steps: int
    evaluations: int | None
    events: list[tuple[float, int]]
    kinds: tuple[str, ...]
    stopped: bool = False


EVERY_KIND = ("contact_begin", "contact_end", "reversal", "stick_begin", "stick_end")
RIGID_KINDS = ("impact", "rest_begin", "rest_end")
CONTACTS = ("contact_begin", "contact_end")


def kinds_of(scene: Scene) -> tuple[str, ...]:
    """The kinds of event that are compared: those of rigid stops only where there are such."""
    return EVERY_KIND + RIGID_KINDS if scene.rigid_stops else EVERY_KIND


# A limit on the wall time of a run, and a way to interrupt it: looked at after every step or few.


class OutOfTime(Exception):
    """The limit has passed, or nobody waits for the result any more."""


class TimeLimit:
    """From its making on, `check` raises OutOfTime after `seconds`, or once `going_on` says False."""

    def __init__(self, seconds: float = inf, going_on: Callable[[], bool] = lambda: True):
        self._end = time.perf_counter() + seconds
        self._going_on = going_on

    def check(self) -> None:
        """Raise OutOfTime where the run is to end here."""
        if time.perf_counter() > self._end or not self._going_on():
            raise OutOfTime


# The classical Runge-Kutta method of order 4 with a fixed step, sgn(v) and no events.


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


# Contacts read off a run without events: where the depth of a stop changes sign between two steps.


BEGIN, END = EVENT_KINDS["contact_begin"], EVENT_KINDS["contact_end"]

Depths = Callable[[float, Sequence[float]], tuple[float, ...]]


def depths_of(scene: Scene) -> Depths:
    """The depths [m] of the stops of a scene at (t, state)."""
    tape = OperationLog(state_count(scene))
    at = Equations(scene, tape, tape.t, tape.states)
    return tape.function([at.depth(stop) for stop in scene.stops])


class SignChanges:
    """Collects `events` (time [s], kind) while it is shown the states of a run step by step."""

    def __init__(self, depths: Depths, state: Sequence[float]):
        self.events: list[tuple[float, int]] = []
        self._depths, self._t, self._last = depths, 0.0, depths(0.0, state)

    def look(self, t: float, state: Sequence[float]) -> None:
        """The next state; a sign that has changed since the last is a contact, timed on the chord."""
        depths = self._depths(t, state)
        for depth, last in zip(depths, self._last, strict=True):
            if (depth >= 0) != (last >= 0):
                crossing = self._t + (t - self._t) * last / (last - depth)
                self.events.append((crossing, BEGIN if depth >= 0 else END))
        self._t, self._last = t, depths


# scipy's solve_ivp without events, in one call: what most people do.


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
        """Right-hand side that solve_ivp calls, counted."""

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


# scipy's solve_ivp with terminal events, one call per mode.
#
# solve_ivp looks at events at the ends of its steps alone (scipy 9228): a free flight is one step, and what
# is met in it is passed through. So steps are at most a share of the shortest period of the motion.


INSIDE = 1e-300  # stands for an event function that is exactly 0: solve_ivp takes 0 after 0 for an event, and
# LSODA interpolates some of the zeros that a mode begins with to below 0
LONGEST = 0.25  # of the shortest period with all stops closed: a step; a contact lasts half of it
INTERVALS = 5  # of samples: a step beside a stop whose law is a formula, which has no period to go by
FIRST = 0.25  # of a hop that has just begun: its first step, so that the next ones see it end
BEHIND_A_IMPACT = 0.01  # of the longest step, where the hop has no end in sight yet


BETWEEN = 32  # looks within a period of the fastest source at what ties carry
BELOW = 1e-12  # of what is seen in a step, beyond which it is below zero


class SteppedOver(Exception):
    """A tie is overloaded inside a step and not at its end; step: that shows it [s]."""

    @property
    def step(self) -> float:
        """Its argument [s]."""
        return float(self.args[0])


class EventSolver:
    """A scene for solve_ivp with `method` ("DOP853", "Radau", "LSODA", ...) at the tolerance rtol.

    looks : whether what sticks and rests is looked at between the ends of steps as well, and a mode begun
        anew with shorter steps where one has stepped over an end of it. All that moves may be at rest while a
        source pulls at it: then no step is too long for the motion.
    """

    def __init__(self, scene: Scene, method: str, rtol: float, looks: bool = False):
        self.scene, self.method = scene, method
        sources = [float(term.omega) for term in scene.harmonics if term.amplitude != 0]
        self.look_rate = BETWEEN * max(sources, default=0.0) / (2 * pi) if looks else 0.0
        rate = fastest_rate(scene)
        longest = LONGEST * 2 * pi / rate if rate else inf
        if any(stop.force is not None for _, stop in scene.elastic_stops):
            longest = min(longest, INTERVALS * scene.every_num / scene.every_den)
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
        self.compiled, self.scene, self.look_rate = peer.compiled, peer.scene, peer.look_rate
        self.ties: list[Callable[..., float]] = []  # event functions of what sticks and rests
        self.solver = watched(peer.method, self._taken)
        self.t, self.state = 0.0, start_of(peer.scene)
        self.mode = Mode(self.compiled, Shortest(peer.settings["atol"]))
        self.progress = SolverProgress()
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
        owners, ends = self._ends()
        tied = {i for i, state in enumerate(self.mode.states) if state in (STICK, REST)}
        self.ties = [end for (i, _), end in zip(owners, ends, strict=True) if i in tied]
        settings = dict(self.settings)
        while True:
            try:
                answer = self._solved(ends, settings)
                break
            except SteppedOver as over:
                settings["max_step"] = over.step
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
        self.events += self._named(self.mode.switch(*owners[happened], self.t, self.state))
        self.progress.event(self.t)

    def _solved(self, ends: Sequence[Callable[..., float]], settings: dict[str, float]) -> Any:
        """Solution of solve_ivp from here on. Raises SteppedOver."""
        span, times = (self.t, self.times[-1]), self.times[self.sampled :]
        return solve_ivp(
            self._motion, span, np.array(self.state), self.solver, times,
            events=ends or None, first_step=self._first_step(), **settings,
        )  # fmt: skip

    def _first_step(self) -> float | None:
        """Of a call behind an impact; None leaves it to solve_ivp, which would step over the whole hop."""
        if self.mode.hop_ends == NEVER:
            return None
        step = min(self.mode.hop_ends * FIRST, self.settings["max_step"] * BEHIND_A_IMPACT)
        return step if step < self.times[-1] - self.t else None

    def _named(self, kinds: list[str]) -> list[tuple[float, int]]:
        return [(self.t, EVENT_KINDS[kind]) for kind in kinds]

    def _motion(self, t: float, state: np.ndarray) -> tuple[float, ...]:
        self.evaluations += 1
        rates: tuple[float, ...] = self.compiled.motion(t, state.tolist(), self.mode.parameters)
        return rates

    def _ends(self) -> tuple[list[tuple[int, int]], list[Callable[..., float]]]:
        """The event functions of the mode, terminal and falling, and part and place of each."""
        states = [*self.mode.states, *[""] * len(self.mode.sides)]
        ends = {
            (i, place): self._end(end)
            for i, state in enumerate(states)
            for place, end in enumerate(self.compiled.ends(i, state))
        }
        return list(ends), list(ends.values())

    def _end(self, function: Callable[..., Any]) -> Callable[..., float]:
        parameters, start = self.mode.parameters, self.t
        touches = function(start, self.state, parameters)[0] == 0

        def end(t: float, state: np.ndarray) -> float:
            if touches and t == start:
                return INSIDE
            return function(t, state.tolist(), parameters)[0] or INSIDE

        end.terminal, end.direction = True, -1  # type: ignore[attr-defined]
        return end

    def _taken(self, solver: Any) -> None:
        self.steps += 1
        self.limit.check()
        length = solver.t - solver.t_old
        count = ceil(length * self.look_rate)
        if count > 1 and self.ties:
            inside = solver.dense_output()
            looks = [(t, inside(t)) for t in np.linspace(solver.t_old, solver.t, count + 1)[1:]]
            for end in self.ties:
                values = [end(*look) for look in looks]
                if values[-1] > 0 and min(values) < -BELOW * max(abs(value) for value in values):
                    raise SteppedOver(length / (2 * count))


# The solvers of scipy, counted and timed step by step under solve_ivp.


def watched(method: str, taken: Callable[[Any], None]) -> Any:
    """The solver class `method` of scipy that calls taken(solver) after every step."""
    base: Any = getattr(scipy.integrate, method)

    def step(solver: Any) -> Any:
        message = base.step(solver)
        taken(solver)
        return message

    return type("Watched", (base,), {"step": step})


# How solve_ivp is told a tolerance.


TIGHTEST = 2.3e-14  # smallest rtol that it takes: 100 units of round-off
SHARE = 1e-3  # atol / rtol, as in its own defaults: displacements are of the order of 1e-2 m


# Whether time goes on from event to event.


MOST = 1000  # events at one instant that are no error: far more than a scene has parts


class SolverProgress:
    """Counts events at one instant, as a zero that is met again and again makes them."""

    def __init__(self) -> None:
        self._t, self._count = -1.0, 0

    def event(self, t: float) -> None:
        """Raise ArithmeticError where events go on without time going on."""
        self._count = self._count + 1 if t == self._t else 0
        self._t = t
        if self._count == MOST:
            raise ArithmeticError(f"{MOST} events at {t:.9g} s: time does not go on")

"""The driver: one loop over segments, the same for either flow. This is the readable twin of the C engine.

Output cadence never changes a trajectory: samples are read off the flow, states are not restarted there.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from math import inf
from typing import Any, Generic

from vibsim.engine.errors import EngineError, State, Stopped, start_of
from vibsim.engine.events.automaton import Automaton
from vibsim.engine.extremes import Extremes, Gap
from vibsim.engine.flows.expansion import highest_derivative
from vibsim.engine.flows.flow import Flow
from vibsim.engine.flows.taylor_rounding import PythonExpansion
from vibsim.engine.ledger import Ledger
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import STRIKE, Event
from vibsim.engine.modes.status import Status
from vibsim.engine.modes.ties import Edge
from vibsim.engine.resume import Point
from vibsim.engine.section import StroboscopicSection
from vibsim.engine.tangent.bundle import TangentBundle
from vibsim.engine.tangent.disturbances import Disturbances
from vibsim.physics.numbers import Doubles, Kit, N
from vibsim.physics.parts import EVENT_KINDS, Scene

Velocities = tuple[list[N], N]  # of the bodies [m/s], speed of the rotor [rad/s]
# code of the kind, part, state and mode behind, velocities in front
EventRecord = tuple[int, int, State[N], Status, Velocities[N]]
EVENTS_AT_ONE_INSTANT = 64
SAMPLES_AT_ONCE = 256
MOST_STRETCHES, PROGRESS = 50_000, 2.0**-30  # stretches that a run in doubles may take for this share of it
AS_SOON = 8  # roundings of a time
MEETING = 2.0**-40  # of a time: so near to an event its rounding may lie, and the motion before it goes on


class Driver(Generic[N]):
    """Runs a scene made of parts from its start, or from `resume` = (state, status, known zeros), to its
    end.

    tangent : disturbances whose growth is told, and from when [s]; carry : disturbances that are carried as
    they are; flow : one of the scene that does more than its own; early, dither : as of `open_trajectory`
    """

    def __init__(
        self,
        scene: Scene[N],
        kit: Kit[N],
        resume: Point[N] | None = None,
        section: bool = False,
        ledger: bool = False,
        momentum: bool = False,
        tangent: tuple[int, N | float] = (0, 0.0),
        carry: Sequence[Sequence[N]] = (),
        flow: Flow[N] | None = None,
        extremes: tuple[Sequence[Edge], Sequence[Gap], float] | None = None,
        early: bool = False,
        dither: int = 0,
    ) -> None:
        self.scene, self.kit = scene, kit
        self.maker = RowMaker(scene, kit)
        self.flow = flow or Flow(scene, kit)
        certificate = self.flow.certificate
        expansion: Any = PythonExpansion(scene, kit, certificate, highest_derivative(scene) + 1)
        self.automaton = Automaton(scene, self.maker, expansion, certificate)
        self.automaton.rigid.chatter.early = early
        self.dither, self.dithered = dither, 0
        self.section = StroboscopicSection(scene, self.flow) if section else None
        self.ledger = Ledger(scene, kit, self.maker, self.flow, momentum) if ledger or momentum else None
        self.extremes = Extremes(scene, kit, self.flow, *extremes) if extremes else None
        self.tangent: Disturbances[N] | None = None
        if tangent[0]:
            self.tangent = TangentBundle(scene, kit, self.flow, *tangent)
        elif len(carry):
            self.tangent = Disturbances(scene, kit, self.flow, carry)
        self.samples: list[tuple[State[N], Status]] = []
        self.events: list[EventRecord[N]] = []
        self.counts = [0] * len(EVENT_KINDS)
        self.first_violation: N | None = None
        self.next_sample = 0
        self.finished = False
        if resume is None:
            self.state = start_of(scene, kit)
            self.status, known = self.automaton.initial(self.state)
        else:
            self.state, self.status, known = resume
            self.next_sample = scene.sample_index(self.state.t)
            if self.section:
                self.section.skip_to(self.state.t)
        self.start = self.state.copy(), self.status
        self.known, self.known_since, self.events_at_instant = known, self.state.t, 0
        self.progress_deadline, self.stretches = self.state.t, 0
        self._record("start", -1)
        if any(self.status.clearances):
            self._note_violation()
        if self.tangent:
            self.tangent.open(self.state, self.maker.rows(self.status))
        self.flow.enter(self.state, self.maker.rows(self.status), known)
        self.worked_to = self.state.t
        self._course = self._stretches()

    def run(self, steps: int, sample_room: int = SAMPLES_AT_ONCE, seconds: float = inf) -> None:
        """Advance until `steps` pieces of work are done, so many samples wait to be taken, so many `seconds`
        are gone, or the run ends.
        """
        late = time.monotonic() + seconds
        for _ in range(steps):
            if self.finished or len(self.samples) >= sample_room:
                return
            try:
                next(self._course)
            except (ArithmeticError, ValueError) as error:  # where C's arithmetic goes on with inf and NaN
                raise EngineError("diverged", self.state) from error
            if time.monotonic() > late:
                return

    def state_at(self, t: N) -> State[N]:
        """State at t [s] before the next recorded event; t ascending from call to call.

        Events that are not recorded, such as the end of the depth of a lifted stop, are taken on the way.
        """
        while True:
            end, event = self.flow.advance(self.scene.t_end)
            if end >= t or end >= self.scene.t_end or (event is not None and t - end <= MEETING * t):
                return self.flow.state_at(t)
            state, _ = self._arrive(end, event)
            if not self._is_finite(state):
                return self.flow.state_at(t)
            if event is None:
                self.flow.carry_on(state)
            else:
                self._switch(state, event)

    def _is_finite(self, state: State[N]) -> bool:
        total = state.w
        for value in (*state.x, *state.v):
            total = total + value
        return self.kit.finite(total)

    def _stretches(self) -> Iterator[None]:
        """The run, stretch by stretch; a generator, which yields wherever it may be left for a while."""
        while not self.finished:
            yield from self._stretch()
            self.worked_to = self.state.t
            yield

    def _stretch(self) -> Iterator[None]:
        """One stretch of the flow: its samples, section and ledger, then its event."""
        if self.kit is Doubles:
            self._check_progress()
        end, event = self.flow.advance(self.scene.t_end)
        if self.extremes:
            self.extremes.open(self.state.t, self.status)
        yield from self._sample_until(end, last=end >= self.scene.t_end)
        if self.section:
            for mark in self.section.gather(self.state, end):
                if self.extremes:
                    yield from self.extremes.until(mark)
                    self.extremes.close()
                yield
        state, tau = self._arrive(end, event)
        if not self._is_finite(state):
            raise EngineError("diverged", self.state)
        if self.extremes:
            yield from self.extremes.until(state.t)
        if self.ledger:
            for worked_to in self.ledger.gather(self.state, tau, self.maker.rows(self.status)):
                self.worked_to = worked_to
                yield
        if self.tangent:
            for worked_to in self.tangent.gather(self.state, end, tau, state, event is not None):
                self.worked_to = worked_to
                yield
        if event is not None:
            self._switch(state, event)
        else:
            self.state = state
            if end < self.scene.t_end:
                self.flow.carry_on(state)
        if not self.finished and end >= self.scene.t_end:
            self._finish()

    def _check_progress(self) -> None:
        """Raise EngineError for a run that would never end, stretch by stretch within its rounding."""
        if self.state.t > self.progress_deadline:
            self.progress_deadline, self.stretches = self.state.t + PROGRESS * self.scene.t_end, 0
            return
        self.stretches += 1
        if self.stretches > MOST_STRETCHES:
            raise EngineError("standstill", self.state)

    def _arrive(self, end: N, event: Event[N] | None) -> tuple[State[N], N]:
        """State at the end of a stretch, and how long after its start that is [s]: there, or at the very
        instant of an impact. So a speed grows or shrinks by nothing but the impact, however short the stretch
        is against the grid of time. No rounding moves a state that is struck where the stretch begins.
        """
        at = end if event is None else self._dithered(end)
        if event is None or event.kind != STRIKE:
            return self.flow.state_at(at).settled(self.kit), at - self.flow.t0
        tau = self.flow.meeting(event, end)
        state = self.flow.state_after(tau) if tau != 0 else self.flow.start.copy()
        state.t = at
        return state.settled(self.kit), tau

    def _dithered(self, end: N) -> N:
        """The time of an event [s], which is rounded to the grid of time; with `dither` = k > 0 the next time
        on that grid. For the n-th event it is later where an even number of binary digits 1 of n stand k
        places before another (k = 1: Rudin and Shapiro), else earlier: as uncorrelated as random signs.
        """
        if not self.dither or end <= self.flow.t0:
            return end
        self.dithered += 1
        later = (self.dithered & (self.dithered >> self.dither)).bit_count() % 2 == 0
        at = self.kit.next_after(end, inf if later else -inf)
        return at if self.flow.t0 < at <= self.scene.t_end else end

    def _sample_until(self, end: N, last: bool) -> Iterator[None]:
        """Samples in [now, end), or up to and including the end of the run.

        They are doubles in every number type: the last one may be the double nearest to the end.
        """
        t = self.scene.sample_time(self.next_sample)
        while t < end or (last and t <= float(end)):
            self.samples.append((self.flow.state_at(self.kit.number(t)), self.status))
            self.next_sample += 1
            t = self.scene.sample_time(self.next_sample)
            if self.next_sample % SAMPLES_AT_ONCE == 0:
                yield

    def _switch(self, state: State[N], event: Event[N]) -> None:
        """Take the event: new mode, record, new segment."""
        before, before_velocities = self.status, (list(state.v), state.w)
        again = event.kind == STRIKE or state.t == self.flow.t0
        order = self.flow.order_of(event) if again else 0
        try:
            status, happened, known = self.automaton.take(state, self.status, event, order)
        except Stopped:
            self.state = state
            raise
        if self.tangent:
            rows = self.maker.rows(before), self.maker.rows(status)
            self.tangent.cross(event, state, *rows, self.automaton.touch(event))
        if state.t == self.known_since or (not happened and self._is_as_soon(state.t)):
            known = {**self.known, **known}
            self.events_at_instant += 1
            if self.events_at_instant > EVENTS_AT_ONE_INSTANT:
                raise EngineError("accumulation", state)
        else:
            self.events_at_instant = 0
        self.state, self.status, self.known, self.known_since = state, status, known, state.t
        if self.ledger:
            self.ledger.cross(state, before, self.maker.rows(status))
            self.ledger.strike(state, self.automaton.touch(event))
        for kind, part in happened:
            self._record(kind, part, before_velocities)
            if kind == "violation_begin":
                self._note_violation()
        if not self.finished:
            self.flow.enter(state, self.maker.rows(status), known)

    def _is_as_soon(self, t: N) -> bool:
        """Whether rounding alone may part the time t [s] from the last event. A law that has a kink where a
        sliding velocity is zero bends there once the friction has let go: that velocity is still zero then.
        """
        return t - self.known_since <= AS_SOON * self.kit.eps * t

    def _note_violation(self) -> None:
        if self.first_violation is None:
            self.first_violation = self.state.t
        if self.scene.stop_on_violation:
            self._finish()

    def _finish(self) -> None:
        self._record("end", -1)
        self.finished = True

    def take(
        self,
    ) -> tuple[list[tuple[State[N], Status]], list[EventRecord[N]], list[State[N]], list[tuple[N, ...]]]:
        """The samples, events, section points and rows of extremes collected since the last call."""
        samples, events = self.samples, self.events
        section: list[State[N]] = []
        extremes: list[tuple[N, ...]] = []
        self.samples, self.events = [], []
        if self.extremes:
            extremes, self.extremes.rows = self.extremes.rows, []
        if self.section:  # a point whose period is still worked out waits for its row
            count = len(extremes) if self.extremes else len(self.section.states)
            section, self.section.states = self.section.states[:count], self.section.states[count:]
        return samples, events, section, extremes

    def _record(self, kind: str, part: int, before: Velocities[N] | None = None) -> None:
        """Keep an event; before: velocities of the bodies and speed of the rotor in front of it."""
        self.counts[EVENT_KINDS[kind]] += 1
        before = before or (list(self.state.v), self.state.w)
        self.events.append((EVENT_KINDS[kind], part, self.state.copy(), self.status, before))

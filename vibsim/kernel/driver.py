"""The driver: one loop over segments, the same for either flow. This is the readable twin of the C engine.

A flow offers `enter(state, mode, known)`, `advance(limit) -> (time, event function or NOTHING)`,
`state_at(t)`, `carry_on(state)` and `relative_jet(state, mode, count)`. Output cadence never changes a
trajectory: samples are read off the flow, states are not restarted there.
"""

import time
from math import inf

from vibsim.events.automaton import initial_mode, transition
from vibsim.events.watch import NOTHING
from vibsim.kernel.errors import KernelError
from vibsim.kernel.ledger import EnergyLedger
from vibsim.kernel.stroboscopic import StroboscopicSection
from vibsim.kernel.tangent_bundle import TangentBundle
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.state import State

EVENTS_AT_ONE_INSTANT = 64
SAMPLES_AT_ONCE = 256


class Driver:
    """Runs a scene from its start, or from `resume` = (state, mode, known zeros), to its end."""

    def __init__(self, scene, kit, flow, resume=None, section=False, ledger=False, tangent=(0, 0.0)):
        self.scene, self.kit, self.flow = scene, kit, flow
        self.section = StroboscopicSection(scene, flow, section)
        self.ledger = EnergyLedger(scene, kit, flow, ledger)
        self.tangent = TangentBundle(scene, kit, flow, *tangent)
        self.samples, self.events = [], []
        self.counts = [0] * len(EVENT_KINDS)
        self.first_violation = None
        self.next_sample = 0
        self.finished = False
        if resume is None:
            self.state = self._start_state()
            self.mode, known = initial_mode(scene, flow, self.state)
        else:
            self.state, self.mode, known = resume
            self.next_sample = scene.sample_index(self.state.t)
            self.section.skip_to(self.state.t)
        self.known, self.known_since, self.crowd = known, self.state.t, 0
        self.ledger.open(self.state, self.mode)
        self.tangent.open(self.state, self.mode)
        self._record("start")
        if self.mode.violated:
            self._note_violation()
        flow.enter(self.state, self.mode, known)
        self.worked_to = self.state.t
        self._course = self._stretches()

    def _start_state(self):
        scene, kit = self.scene, self.kit
        zero = kit.number(0)
        phase, turns, w = zero, zero, zero
        if scene.has_motor:
            phase, turns = kit.reduce_angle(scene.phi)
            w = scene.phidot
        x2, v2 = (scene.x2, scene.v2) if scene.has_block2 else (zero, zero)
        return kit.settle(State(zero, scene.x1, scene.v1, x2, v2, phase, turns, w))

    def run(self, sample_room, event_room, steps, seconds=inf):
        """Advance until a buffer of so many samples or events is full, `steps` pieces of work or so many
        `seconds` on the clock are spent, or the run ends.
        """
        late = time.monotonic() + seconds
        for _ in range(steps):
            if self.finished or len(self.samples) >= sample_room or len(self.events) + 2 >= event_room:
                return
            try:
                next(self._course)
            except (ArithmeticError, ValueError) as error:  # where C's arithmetic goes on with inf and NaN
                raise KernelError("diverged", self.state) from error
            if time.monotonic() > late:
                return

    def _stretches(self):
        """The run, stretch by stretch; a generator, which yields wherever it may be left for a while."""
        while not self.finished:
            yield from self._stretch()
            self.worked_to = self.state.t
            yield

    def _stretch(self):
        """One stretch of the flow: its samples, then its event."""
        end, function = self.flow.advance(self.scene.t_end)
        yield from self._sample_until(end, last=end >= self.scene.t_end)
        yield from self.section.gather(self.state, end)
        state = self.kit.settle(self.flow.state_at(end))
        if not self.kit.finite(state.x1 + state.v1 + state.x2 + state.v2 + state.w):
            raise KernelError("diverged", self.state)
        for worked_to in self._gathered(end, state):
            self.worked_to = worked_to
            yield
        if function != NOTHING:
            self._switch(state, function)
        else:
            self.state = state
            if end < self.scene.t_end:
                self.flow.carry_on(state)
        if not self.finished and end >= self.scene.t_end:
            self._finish()

    def _gathered(self, end, state):
        yield from self.ledger.gather(self.state, end, state, self.mode)
        yield from self.tangent.gather(self.state, end, state)

    def _sample_until(self, end, last):
        """Samples in [now, end), or up to and including the end of the run.

        They are doubles in every number type: the last one may be the double nearest to the end.
        """
        t = self.scene.sample_time(self.next_sample)
        while t < end or (last and t <= float(end)):
            self.samples.append((self.flow.state_at(t), self.mode))
            self.next_sample += 1
            t = self.scene.sample_time(self.next_sample)
            if self.next_sample % SAMPLES_AT_ONCE == 0:
                yield

    def _switch(self, state, function):
        """Take the event: new mode, record, new segment."""
        mode, kind, known = transition(self.scene, self.flow, state, self.mode, function)
        self.tangent.cross(kind, state, self.mode)
        if state.t == self.known_since:
            known = {**self.known, **known}
            self.crowd += 1
            if self.crowd > EVENTS_AT_ONE_INSTANT:
                raise KernelError("accumulation", state)
        else:
            self.crowd = 0
        self.state, self.mode, self.known, self.known_since = state, mode, known, state.t
        if kind is not None:
            self._record(kind)
            if kind == EVENT_KINDS["violation_begin"]:
                self._note_violation()
        if not self.finished:
            self.flow.enter(state, mode, known)

    def _note_violation(self):
        if self.first_violation is None:
            self.first_violation = self.state.t
        if self.scene.stop_on_violation:
            self._finish()

    def _finish(self):
        self._record("end")
        self.finished = True

    def _record(self, kind):
        code = EVENT_KINDS[kind] if isinstance(kind, str) else kind
        self.counts[code] += 1
        self.events.append((code, State(**vars(self.state)), self.mode))

    def take(self):
        """The samples, events and section points collected since the last call."""
        samples, events, section = self.samples, self.events, self.section.states
        self.samples, self.events, self.section.states = [], [], []
        return samples, events, section

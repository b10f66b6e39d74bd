"""What changes of a scene's numbers make of a motion: its derivative by them, through events.

Between events the Taylor flow carries derivatives along (`vibsim.physics.arithmetic.sloped_numbers`), at
fixed times. Where an event function h depends on the numbers too, the event moves by dt = -dh / h', and with
the vector fields f- and f+ on both sides

    d(behind) = d(before) + (f- - f+) dt,    at a blow R:  d(behind) = dR(state, numbers at t + dt) - f+ dt,

which is the saltation matrix with what the numbers add to it (Aizerman & Gantmakher 1958; Mueller 1995).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vibsim.engine.driver import Driver
from vibsim.engine.events.certificate import Certificate
from vibsim.engine.events.impacts.newton_moreau import Contact, blow, masses
from vibsim.engine.flows.harmonics import value_and_rate
from vibsim.engine.flows.series.taylor import Taylor
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import GAP, HOLD, PUSH, SLIDE, STRIKE
from vibsim.engine.state import State
from vibsim.orbits.errors import OrbitError
from vibsim.physics.arithmetic.numbers import Doubles
from vibsim.physics.arithmetic.sloped_numbers import Sloped, SlopedNumbers, slope_of
from vibsim.physics.modes import EVENT_NAMES
from vibsim.physics.rates import fastest_rate

PIECES = 4096  # of the run at once
SHARE = 0.5  # of the step that the flow itself would take: derivatives ask for more terms than values
OF_EVENTS = {
    "contact_begin": (GAP, PUSH),
    "contact_end": (GAP, PUSH),
    "reversal": (SLIDE,),
    "stick_begin": (SLIDE,),
    "stick_end": (HOLD,),
    "impact": (STRIKE,),
}
NOT_FOLLOWED = ("transmitted", "chatter", "rest_begin", "rest_end")


class NotFollowed(Exception):
    """An event, or a mode, whose derivative by the numbers is not known in closed form."""


def parameter_slopes(started: Any, sloped: Any, count: int) -> np.ndarray:
    """Derivatives of the components at the end of a motion by `count` numbers, (count, components).

    started : the scene in doubles, from its start to its end; sloped : the same with derivatives

    Raises NotFollowed for several rigid stops at one instant, rest on a rigid stop, blows on what sticks, and
    what holds on ground and base at once while the derivative is by an amplitude of 0;
    OrbitError at a tangency; EngineError where the run fails.
    """
    driver = Driver(started, Doubles)
    while not driver.finished:
        driver.run(PIECES)
    followed = _Followed(sloped, started, count)
    _, _, start, status, _ = driver.events[0]
    state = start.copy()
    for code, part, there, behind, _ in driver.events[1:]:
        kind = EVENT_NAMES[code]
        state = followed.carried(state, status, float(there.t))
        if behind != status or kind == "impact":
            state = followed.crossed(state, status, behind, kind, part)
        state, status = _with_slopes(there, state, count), behind
    return _components(state, count, started.motor is not None)


class _Followed:
    """Follows derivatives along a motion that is known."""

    def __init__(self, scene: Any, started: Any, count: int):
        self.scene, self.count, self.kit = scene, count, SlopedNumbers
        varied = any(isinstance(term.amplitude, Sloped) for term in scene.base)
        self.maker = RowMaker(scene, SlopedNumbers, started.base_moves or varied)
        damping = [
            part.c / started.bodies[end].m
            for part in (*started.links, *started.stops)
            if getattr(part, "c", 0)
            for end in (part.P, part.Q)
            if end >= 0
        ]
        rate = max([fastest_rate(started), *damping])
        self.longest = 1 / rate if rate else np.inf

    def flow(self, state: Any, status: Any) -> Any:
        """The Taylor flow at a state in a mode."""
        rows, ground = self.maker.rows(status), self.maker.n
        if rows.leader[ground + 1] == ground:
            raise NotFollowed("bodies that hold on to the ground and to a base that is about to move")
        flow: Any = Taylor(self.scene, self.kit, Certificate(self.kit))
        flow.enter(state, rows, {})
        return flow

    def carried(self, state: Any, status: Any, end: float) -> Any:
        """The state at the time `end` [s] in one mode."""
        while state.t < end:
            flow = self.flow(state, status)
            h = min(SHARE * float(flow.h), self.longest)
            state = flow.state_at(end if state.t + 1.25 * h >= end else state.t + h)
        return state

    def crossed(self, state: Any, before: Any, after: Any, kind: str, part: int) -> Any:
        """The state, and its derivatives at the same time, behind an event."""
        if kind in NOT_FOLLOWED:
            raise NotFollowed(kind)
        if kind not in OF_EVENTS:  # a limit that is watched exerts no force
            return state
        flow = self.flow(state, before)
        event = self._event(flow, kind, part)
        if kind == "impact":
            return self._struck(flow, event, state, before, after)
        jump = self._rates(self.flow(state, after)) - self._rates(flow)
        if not jump.any():
            return state
        later = self._later(flow, event)
        return _moved(state, -(jump[:, None] * later), self.count)

    def _event(self, flow: Any, kind: str, part: int) -> Any:
        """The event function that has come to zero."""
        events = []
        for event in flow.rows.events:
            ties = [tie for tie, _ in flow.rows.cuts[event.part].ties] if event.kind == HOLD else [event.part]
            if event.kind in OF_EVENTS[kind] and part in ties:
                events.append((abs(float(flow.derivatives(event, 0)[0])) / (float(event.size) or 1.0), event))
        return min(events, key=lambda pair: pair[0])[1]

    def _later(self, flow: Any, event: Any) -> np.ndarray:
        """By how much later the event comes, per unit of each number [s]."""
        h, rate = flow.derivatives(event, 1)
        if float(rate) == 0:
            raise OrbitError(f"at {float(flow.t0):.6g} s the motion is tangent to an event: no derivative")
        return -slope_of(h, self.count) / float(rate)

    def _rates(self, flow: Any) -> np.ndarray:
        """Rates of velocities, and of the rotor's speed where there is a motor."""
        speeds = flow.v[: flow.n] if flow.rotor is None else [*flow.v[: flow.n], flow.rotor.w]
        return np.array([float(series[1]) for series in speeds])

    def _struck(self, flow: Any, event: Any, state: Any, before: Any, after: Any) -> Any:
        """Behind a blow on one rigid stop."""
        if before.tied or after.tied:
            raise NotFollowed("impact")
        later, rates, n = self._later(flow, event), self._rates(flow), flow.n
        meeting = _shifted(state, rates, later, self.count)
        stop = self.scene.stops[event.part]
        _, V = value_and_rate(self.kit, self.scene.base, Sloped(float(state.t), later))
        bodies = masses(self.scene, self.kit, meeting.phase)
        contact = Contact(event.part, *self.maker.ends(stop), stop.sense, stop.e)
        v, w, _ = blow(self.kit, bodies, [contact], [*meeting.v, 0.0, V], meeting.w)
        struck = State(state.t, meeting.x, v[:n], meeting.phase, state.turns, w)
        return _shifted(struck, self._rates(self.flow(struck, after)), -later, self.count)


def _shifted(state: Any, rates: np.ndarray, later: np.ndarray, count: int) -> Any:
    """The state at a time that depends on the numbers: dx = v dt, dv = a dt."""
    n = len(state.x)
    x = [_plus(x, float(v) * later, count) for x, v in zip(state.x, state.v, strict=True)]
    v = [_plus(v, a * later, count) for v, a in zip(state.v, rates.tolist(), strict=False)]
    phase, w = _plus(state.phase, float(state.w) * later, count), state.w
    if len(rates) > n:
        w = _plus(w, float(rates[n]) * later, count)
    return State(state.t, x, v, phase, state.turns, w)


def _moved(state: Any, change: np.ndarray, count: int) -> Any:
    """The state with changed derivatives of its velocities, and of the rotor's speed."""
    n = len(state.x)
    v = [_plus(one, row, count) for one, row in zip(state.v, change, strict=False)]
    w = _plus(state.w, change[n], count) if len(change) > n else state.w
    return State(state.t, state.x, v, state.phase, state.turns, w)


def _plus(number: Any, slope: np.ndarray, count: int) -> Sloped:
    return Sloped(float(number), slope_of(number, count) + slope)


def _with_slopes(there: Any, state: Any, count: int) -> Any:
    """The state of the run, with the derivatives of what was carried to it."""

    def lifted(value: Any, carried: Any) -> Sloped:
        return Sloped(float(value), slope_of(carried, count))

    x = [lifted(*pair) for pair in zip(there.x, state.x, strict=True)]
    v = [lifted(*pair) for pair in zip(there.v, state.v, strict=True)]
    return State(there.t, x, v, lifted(there.phase, state.phase), there.turns, lifted(there.w, state.w))


def _components(state: Any, count: int, motor: bool) -> np.ndarray:
    parts: Sequence[Any] = [*state.x, *state.v, *((state.phase, state.w) if motor else ())]
    return np.transpose([slope_of(part, count) for part in parts])

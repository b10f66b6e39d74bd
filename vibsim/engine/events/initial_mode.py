"""The mode that a run starts in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.events.departures import DerivativeSigns, leading, sign
from vibsim.engine.events.impacts.rigid_stops import RigidStops
from vibsim.engine.events.settling import StickSlipResolution
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import CLEARANCE, GAP, HOLD, PUSH, SLIDE, STRIKE, Joined, Known
from vibsim.engine.modes.status import BACKWARD, CONTACT, FORWARD, KEPT, LIFTED, OPEN, STICK, VIOLATED, Status
from vibsim.engine.modes.ties import Edge
from vibsim.physics.numbers import N
from vibsim.physics.parts import Friction, RigidStop, Scene, Stop


class InitialMode(Generic[N]):
    """Decides the mode of a start, which is exact: what touches there touches."""

    def __init__(
        self, scene: Scene[N], maker: RowMaker[N], settling: StickSlipResolution[N], rigid: RigidStops[N]
    ) -> None:
        self.scene, self.maker, self.settling, self.rigid = scene, maker, settling, rigid
        self.departures: DerivativeSigns[N] = settling.departures
        self.relative, self.flow = settling.relative, settling.flow
        self.elastic = dict(scene.elastic_stops)

    def initial(self, state: State[N]) -> tuple[Status, Known]:
        """Status that the motion starts in from `state`, and the known zeros there."""
        scene = self.scene
        depths = [self.relative.depth(stop, state) for stop in scene.stops]
        met = [
            self.relative.met(stop, g, state, stop.gap) or self._rests(stop, g, state)
            for stop, g in zip(scene.stops, depths, strict=True)
        ]
        deep = [
            g > 0 and not at and isinstance(s, Stop)
            for g, at, s in zip(depths, met, scene.stops, strict=True)
        ]
        stops = tuple(CONTACT if inside else OPEN for inside in deep)
        slacks = [self.relative.excess(c, state) for c in scene.clearances]
        clearances = tuple(VIOLATED if over > 0 else KEPT for over in slacks)
        rates = [self._slip(friction, state) for friction in scene.frictions]
        frictions = tuple(sign(rate) for rate in rates)
        status = self._pressing(state, Status(stops, frictions, clearances), met)
        known: Known = {}
        touching, seated = self.rigid.at_start(state, [i for i, at in enumerate(met) if at])
        standing = [i for i, sense in enumerate(frictions) if sense == 0]
        standing += [len(frictions) + i for i in seated]
        if standing:
            standing = self.settling.standing(status, standing)
            status = self.settling.settle(state, status, standing)
            known |= {(SLIDE, i): 1 for i in standing if i < len(frictions) and status.frictions[i] != STICK}
        known |= {
            (STRIKE, i): 1 if parting else self.departures.departure(state, status, (STRIKE, i))[1]
            for i, parting in touching.items()
            if status.stops[i] == OPEN
        }
        for i, (g, stop) in enumerate(zip(depths, scene.stops, strict=True)):
            if self.relative.blurred(g, stop, state, stop.sense * stop.gap, met[i]):
                self.departures.doubt(state)
            if met[i] and i in self.elastic and i not in self.maker.guarded:
                sense, order = self.departures.departure(state, status.with_stop(i, OPEN), (GAP, i))
                status = status.with_stop(i, CONTACT if sense < 0 else OPEN)
                known[GAP, i] = order
        for i, over in enumerate(slacks):
            at = self.relative.met(scene.clearances[i], over, state, scene.clearances[i].distance)
            if self.relative.blurred(over, scene.clearances[i], state, -scene.clearances[i].distance, at):
                self.departures.doubt(state)
            if at:
                sense, order = self.departures.departure(
                    state, status.with_clearance(i, KEPT), (CLEARANCE, i)
                )
                status = status.with_clearance(i, VIOLATED if sense < 0 else KEPT)
                known[CLEARANCE, i] = order
        return status, known | self._held(state, status)

    def _rests(self, stop: Stop[N] | RigidStop[N], g: N, state: State[N]) -> bool:
        """Whether a start that does not meet a rigid stop rests on it all the same, in doubt."""
        rests = self.relative.rests(stop, g, state)
        if rests:
            self.departures.doubt(state)
        return rests

    def _slip(self, friction: Friction[N], state: State[N]) -> N:
        """The sliding velocity at the start: none, in doubt, where the base's rounding may be all of it. A
        period after a start that sticks on the base a body has the base's velocity but for that.
        """
        rate = self.relative.slip(friction, state)
        if not self.relative.turned_by_base(friction, rate, state.t):
            return rate
        self.departures.doubt(state)
        return self.relative.kit.number(0)

    def _held(self, state: State[N], status: Status) -> Known:
        """Orders of the zeros from which what ties may carry begins to grow."""
        known: Known = {}
        rows = self.departures.enter(state, status)
        for event in rows.events:
            if event.kind == HOLD:
                values = self.departures.hold_values(state, rows, event)
                order = leading(values, 0)
                if order > 0 and values[order] > 0:
                    known[event.key] = order
        return known

    def _pressing(self, state: State[N], status: Status, met: Sequence[bool]) -> Status:
        """The status with the stops whose force velocities tell: ties at rest are settled under it. Those
        that are `met` push where they close; deep ones whose damper would have to pull are lifted.
        """
        for i, stop in enumerate(self.scene.stops):
            if i in self.maker.guarded:
                continue
            if met[i] and isinstance(stop, Stop):
                vP, vQ = self.relative.ends(stop, state, "v")
                status = status.with_stop(i, CONTACT if -(stop.sense * (vP - vQ)) > 0 else OPEN)
            elif status.stops[i] == CONTACT and self._pulls(state, status, i):
                status = status.with_stop(i, LIFTED)
        return status

    def _pulls(self, state: State[N], status: Status, i: int) -> bool:
        """Whether the damper of stop `i`, in contact, would have to pull."""
        stop = self.elastic[i]
        if not stop.lets_go:
            return False
        event = self.departures.event(self.departures.enter(state, status), (PUSH, i))
        values = self.flow.derivatives(event, self.departures.jet)
        if self.departures.is_open(state, event, values, 0):
            self.departures.doubt(state)
        return values[0] < 0


# The mode of a start that leaves no doubt: no depth, no sliding velocity anywhere near zero.
#
# `Automaton.initial` says the signs of these; here they are told without asking the rest.
# Newton's method for orbits begins motions by the thousand.


# of the sizes that a depth or a velocity is the difference of: rounding is a thousandth of it
NEAR = 2.0**-40


class UnambiguousStart:
    """Tells the modes of plain starts of a scene; `known` says whether it can have any."""

    def __init__(self, scene: Scene, ends: Callable[[Joined], Edge]) -> None:
        self.known = not (
            scene.base
            or scene.clearances
            or any(isinstance(stop, RigidStop) or stop.lets_go for stop in scene.stops)
        )
        self.stops = [(*ends(stop), stop.sense, stop.gap) for stop in scene.stops]
        self.frictions = [(*ends(friction), friction.belt) for friction in scene.frictions]
        self._modes: dict[tuple[int, ...], Status] = {}

    def status(self, state: State) -> Status | None:
        """The mode of `state`, or None where a sign is not plain."""
        x, v = (*state.x, 0.0, 0.0), (*state.v, 0.0, 0.0)  # ground and base rest
        stops: list[int] = []
        frictions: list[int] = []
        for P, Q, sense, gap in self.stops:
            one, other = x[P], x[Q]
            depth = -(sense * (one - other)) - gap
            if abs(depth) <= NEAR * (abs(one) + abs(other) + abs(gap)):
                return None
            stops.append(CONTACT if depth > 0 else OPEN)
        for P, Q, belt in self.frictions:
            one, other = v[P], v[Q]
            rate = (one - other) - belt
            if abs(rate) <= NEAR * (abs(one) + abs(other) + abs(belt)):
                return None
            frictions.append(FORWARD if rate > 0 else BACKWARD)
        key = *stops, *frictions
        status = self._modes.get(key)
        if status is None:
            status = self._modes[key] = Status(tuple(stops), tuple(frictions), ())
        return status

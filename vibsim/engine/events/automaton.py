"""What follows an event: the one mode that is consistent with the state behind it, the Filippov solution.

A mode is consistent where each of its event functions is positive just behind the instant: its first
derivative that is not zero is. So every decision at a zero looks at derivatives, never at the sign of a
rounded zero. Each transition tells which event functions are zero at its instant, and to which order. A
decision that rounding could turn is in doubt, and the certificate counts it. Two events at one instant are
taken one after the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations, product
from typing import Generic

from vibsim.engine.events.parting import let_go, meets
from vibsim.engine.events.rigid_stops import Happened, RigidStops, Taken, Touch
from vibsim.engine.flows.flow import Flow
from vibsim.engine.flows.harmonics import TURN_ROUNDING, series_rounding, value_and_rate
from vibsim.engine.flows.taylor_rounding import TaylorRounding
from vibsim.engine.modes.rows import (
    CLEARANCE,
    COUPLING,
    DIFFERENCE,
    GAP,
    HOLD,
    PUSH,
    SLIDE,
    STRIKE,
    Event,
    EventKey,
    Joined,
    Known,
    ModeRows,
    RowMaker,
)
from vibsim.engine.modes.status import (
    BACKWARD,
    CONTACT,
    FORWARD,
    KEPT,
    LIFTED,
    OPEN,
    RESTING,
    STICK,
    VIOLATED,
    Status,
)
from vibsim.engine.state import State
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import AT_FORCE, Clearance, Friction, Motor, RigidStop, Scene, Stop

JET = 7  # order of the highest derivative consulted where lower ones vanish
# of all forces of a mode: nearer to its limit than that the force of a tie is measured closely
NEAR = 2.0**-40


class Automaton(Generic[N]):
    """Decides the modes of a run.

    Derivatives are those of the Taylor recurrences in every mode: what is zero by the laws of motion, as the
    acceleration of a body whose springs are slack, is exactly zero there. Modal coordinates leave rounding.
    """

    def __init__(self, scene: Scene[N], maker: RowMaker[N], flow: Flow[N], kit: Kit[N]) -> None:
        self.scene, self.maker, self.flow, self.kit = scene, maker, flow.taylor, kit
        self.elastic = dict(scene.elastic_stops)
        self.rigid = RigidStops(self)

    # -- start

    def initial(self, state: State[N]) -> tuple[Status, Known]:
        """Status that the motion starts in from `state`, and the known zeros there."""
        scene = self.scene
        depths = [self._depth(stop, state) for stop in scene.stops]
        met = [self._met(stop, g, state, stop.gap) for stop, g in zip(scene.stops, depths, strict=True)]
        deep = [
            g > 0 and not at and isinstance(s, Stop)
            for g, at, s in zip(depths, met, scene.stops, strict=True)
        ]
        stops = tuple(CONTACT if inside else OPEN for inside in deep)
        slacks = [self._excess(c, state) for c in scene.clearances]
        clearances = tuple(VIOLATED if over > 0 else KEPT for over in slacks)
        rates = [self._slip(f, state) for f in scene.frictions]
        if any(self._turned_by_base(f, rate, state) for f, rate in zip(scene.frictions, rates, strict=True)):
            self._doubt(state)
        frictions = tuple(sign(rate) for rate in rates)
        status = self._pressing(state, Status(stops, frictions, clearances), met)
        known: Known = {}
        touching, seated = self.rigid.at_start(state, [i for i, at in enumerate(met) if at])
        standing = [i for i, sense in enumerate(frictions) if sense == 0]
        standing += [len(frictions) + i for i in seated]
        if standing:
            standing = self.standing(status, standing)
            status = self._settle(state, status, standing)
            known |= {(SLIDE, i): 1 for i in standing if i < len(frictions) and status.frictions[i] != STICK}
        known |= {(STRIKE, i): order for i, order in touching.items() if status.stops[i] == OPEN}
        for i, (g, stop) in enumerate(zip(depths, scene.stops, strict=True)):
            if self._blurred(g, stop, state, stop.sense * stop.gap, met[i]):
                self._doubt(state)
            if met[i] and i in self.elastic and i not in self.maker.guarded:
                sense, order = self._departure(state, status.with_stop(i, OPEN), (GAP, i))
                status = status.with_stop(i, CONTACT if sense < 0 else OPEN)
                known[GAP, i] = order
        for i, over in enumerate(slacks):
            at = self._met(scene.clearances[i], over, state, scene.clearances[i].distance)
            if self._blurred(over, scene.clearances[i], state, -scene.clearances[i].distance, at):
                self._doubt(state)
            if at:
                sense, order = self._departure(state, status.with_clearance(i, KEPT), (CLEARANCE, i))
                status = status.with_clearance(i, VIOLATED if sense < 0 else KEPT)
                known[CLEARANCE, i] = order
        return status, known

    def _pressing(self, state: State[N], status: Status, met: Sequence[bool]) -> Status:
        """The status with the stops whose force velocities tell: ties at rest are settled under it. Those
        that are `met` push where they close; deep ones whose damper would have to pull are lifted.
        """
        for i, stop in enumerate(self.scene.stops):
            if i in self.maker.guarded:
                continue
            if met[i] and isinstance(stop, Stop):
                vP, vQ = self._ends(stop, state, "v")
                status = status.with_stop(i, CONTACT if -(stop.sense * (vP - vQ)) > 0 else OPEN)
            elif status.stops[i] == CONTACT and self._pulls(state, status, i):
                status = status.with_stop(i, LIFTED)
        return status

    def _pulls(self, state: State[N], status: Status, i: int) -> bool:
        """Whether the damper of stop `i`, in contact, would have to pull."""
        stop = self.elastic[i]
        if stop.c == 0 or stop.release != AT_FORCE:
            return False
        event = self._event(self._enter(state, status), (PUSH, i))
        values = self.flow.derivatives(event, JET)
        if self._open(state, event, values, 0):
            self._doubt(state)
        return values[0] < 0

    def _ends(self, part: Joined, state: State[N], of: str) -> tuple[N, N]:
        values = (*(state.x if of == "x" else state.v), self.kit.number(0), self._base(state, of))
        P, Q = self.maker.ends(part)
        return values[P], values[Q]

    def _base(self, state: State[N], of: str) -> N:
        """Displacement or velocity of the base, which is 0 where it turns round at the start: cos(90 deg)."""
        value, rate = value_and_rate(self.kit, self.scene.base, state.t)
        if of == "x":
            return value
        return self.kit.number(0) if self._base_turns(state, rate) else rate

    def _base_turns(self, state: State[N], rate: N) -> bool:
        """Whether the velocity `rate` of the base is what is left of none at the start."""
        fastest = sum((abs(one.amplitude * one.omega) for one in self.scene.base), self.kit.number(0))
        return state.t == 0 and abs(rate) <= TURN_ROUNDING * self.kit.eps * fastest

    def _base_rounding(self, columns: tuple[int, int], state: State[N]) -> tuple[N, N]:
        """What rounding of the base leaves open of a difference of two columns and of its rate."""
        zero, base = self.kit.number(0), self.scene.base
        if not base or self.maker.n + 1 not in columns:
            return zero, zero
        place, rate = series_rounding(self.kit, base, state.t, 2)
        return place, zero if self._base_turns(state, value_and_rate(self.kit, base, state.t)[1]) else rate

    def _turned_by_base(self, part: Joined, rate: N, state: State[N]) -> bool:
        """Whether the rounding of the base's velocity could turn the sign of a relative one. What is zero in
        doubles moves with the base.
        """
        return 0 < abs(rate) <= self._base_rounding(self.maker.ends(part), state)[1]

    def _depth(self, stop: Stop[N] | RigidStop[N], state: State[N]) -> N:
        xP, xQ = self._ends(stop, state, "x")
        return -(stop.sense * (xP - xQ)) - stop.gap

    def _excess(self, clearance: Clearance[N], state: State[N]) -> N:
        xP, xQ = self._ends(clearance, state, "x")
        return (xP - xQ) - clearance.distance

    def _slip(self, friction: Friction[N], state: State[N]) -> N:
        vP, vQ = self._ends(friction, state, "v")
        return (vP - vQ) - friction.belt

    def _met(
        self, part: Stop[N] | RigidStop[N] | Clearance[N], value: N, state: State[N], distance: N
    ) -> bool:
        """Whether the ends of a part just touch, see `meets`."""
        return meets(self.kit, part, value, self._ends(part, state, "x"), distance)

    def _blurred(
        self,
        value: N,
        part: Stop[N] | RigidStop[N] | Clearance[N],
        state: State[N],
        distance: N,
        met: bool,
    ) -> bool:
        """Whether the rounding of the base, of x_P - x_Q and of its sum with `distance` could turn the sign
        of `value`; of the base alone where the ends are met, of nothing where exact numbers say so.
        """
        if met and part.at_start:
            return False
        lost = self._base_rounding(self.maker.ends(part), state)[0]
        if not met:
            xP, xQ = self._ends(part, state, "x")
            y = xP - xQ
            lost = (
                lost + abs(_difference_error(xP, xQ, y)) + abs(_difference_error(y, -distance, y + distance))
            )
        return 0 < lost >= abs(value)

    def _doubt(self, state: State[N]) -> None:
        self.flow.certificate.doubt(state.t)

    # -- event functions at a state

    def _enter(self, state: State[N], status: Status) -> ModeRows[N]:
        rows = self.maker.rows(status)
        self.flow.look(state, rows)
        return rows

    def _event(self, rows: ModeRows[N], key: EventKey) -> Event[N]:
        return next(event for event in rows.events if event.key == key)

    def _leading_sign(self, state: State[N], status: Status, key: EventKey, first: int = 1) -> int:
        """Sign of the first derivative, from order `first`, that is not zero; 0 where all are. That of order
        1 is one of velocities where differences alone make the function, and no rounding of a flow is in it.
        """
        values = self._derivatives(state, self._event(self._enter(state, status), key))
        return sign(values[leading(values, first)])

    def _departure(self, state: State[N], status: Status, key: EventKey, first: int = 1) -> tuple[int, int]:
        """Sign as of `_leading_sign`, and order, of a function that begins at zero: in doubt where rounding
        could have it leave to the other side, or later than it does.
        """
        event = self._event(self._enter(state, status), key)
        values = self._derivatives(state, event)
        order = leading(values, first)
        if self._open(state, event, values, first):
            self._doubt(state)
        return sign(values[order]), order

    def _open(self, state: State[N], event: Event[N], values: Sequence[N], first: int) -> bool:
        """Whether rounding leaves the first of the derivatives `values`, from order `first`, that is not zero
        open, or one before it. That of order 1 of displacements is one of velocities.
        """
        order = leading(values, first)
        bounds = TaylorRounding(self.flow, JET + 1, state.t == 0).derivatives(event, order)
        if order > 0 and all(term.kind == DIFFERENCE for term in event.terms):
            bounds[1] = self.kit.number(0)
            for term in event.terms:
                bounds[1] = (
                    bounds[1] + abs(term.coefficient) * self._base_rounding((term.P, term.Q), state)[1]
                )
        return any(
            0 < lost >= abs(value) for value, lost in zip(values[first:], bounds[first:], strict=False)
        )

    def _derivatives(self, state: State[N], event: Event[N]) -> list[N]:
        """Derivatives of an event function of the mode entered last at `state`."""
        values = self.flow.derivatives(event, JET)
        if all(term.kind == DIFFERENCE for term in event.terms):
            values[1] = self._direct_rate(state, event)
        return values

    # -- events

    def take(self, state: State[N], status: Status, event: Event[N], order: int = 0) -> Taken:
        """What the zero of `event` at `state` leads to: (status, [(kind name, part)], known zeros).

        order : of the zero of the same function that the stretch began with, 0 for none; of a rigid stop, or
            where the stretch ends in the instant in which it began

        Moves the velocities of bodies that stick onto each other. At a reversal it keeps the residue of the
        time grid: the friction force turns dt too late, where cutting the residue would take momentum.
        """
        if event.kind == GAP:
            return self._contact_switch(state, status, event, order)
        if event.kind == STRIKE:
            return self.rigid.meet(state, status, event.part, hop=order == 1)
        if event.kind == PUSH:
            return self._push_switch(state, status, event, order)
        if event.kind == CLEARANCE:
            return self._clearance_switch(state, status, event, order)
        if event.kind == SLIDE:
            return self._sliding_ends(state, status, event)
        return self._hold_ends(state, status, event, order)

    def touch(self, event: Event[N]) -> Touch[N] | None:
        """The `Touch` of rigid stops that `event`, taken just now, was; None of other events."""
        return self.rigid.touch if event.kind == STRIKE else None

    def _contact_switch(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        i = event.part
        stop, before = self.elastic[i], status.stops[i]
        crossing = self._crossing(state, status, event.key, order)
        deeper = -event.direction * crossing  # sign of the depth behind here
        after = before if deeper == 0 else CONTACT if deeper > 0 else OPEN
        if before == LIFTED:
            after = OPEN if deeper < 0 else LIFTED
        status = status.with_stop(i, after)
        happened: Happened = []
        if after != before and before != LIFTED:
            happened.append(("contact_begin" if after == CONTACT else "contact_end", i))
        known: Known = {event.key: 1}
        if after != before and stop.c != 0 and status.tied:
            tied = status
            status = self._settle(state, status, tied.tied)
            happened += self._changes(tied, status, known)
        return status, happened, known

    @staticmethod
    def _changes(before: Status, after: Status, known: Known) -> Happened:
        """Events of frictions and rigid stops whose status differs; adds the zeros of those that begin to
        slip or part to `known`.
        """
        happened: Happened = []
        for i, (old, new) in enumerate(zip(before.frictions, after.frictions, strict=True)):
            if new != STICK and new != old:
                known.setdefault((SLIDE, i), 1)
                happened.append(("stick_end" if old == STICK else "reversal", i))
            elif new != old:
                happened.append(("stick_begin", i))
        for i, (old, new) in enumerate(zip(before.stops, after.stops, strict=True)):
            if (old, new) == (RESTING, OPEN):
                known[STRIKE, i] = 2
                happened.append(("rest_end", i))
            elif (old, new) == (OPEN, RESTING):
                happened.append(("rest_begin", i))
        return happened

    def _crossing(self, state: State[N], status: Status, key: EventKey, order: int) -> int:
        """+1 where the event function goes on falling through its zero, -1 where it turns back.

        order : of a zero here from which it was taken to rise, and fell back within the grid of time: its
            derivatives up to that order are rounding
        """
        event = self._event(self.maker.rows(status), key)
        if all(term.kind == DIFFERENCE for term in event.terms):
            rate = self._direct_rate(state, event)
            if rate != 0:
                return -sign(rate)
        return -self._leading_sign(state, status, key, order + 1)

    def _direct_rate(self, state: State[N], event: Event[N]) -> N:
        """Rate of a function made of differences, from the velocities: no rounding of a flow in it."""
        v = (*state.v, self.kit.number(0), self._base(state, "v"))
        total = None
        for term in event.terms:
            part = term.coefficient * (v[term.P] - v[term.Q])
            total = part if total is None else total + part
        assert total is not None  # no event function is made of nothing
        return total

    def _hold_values(self, state: State[N], rows: ModeRows[N], event: Event[N]) -> list[N]:
        """Derivatives of a HOLD function; its value straight from the state where couplings alone make it."""
        values = self.flow.derivatives(event, JET)
        if event.terms and all(term.kind == COUPLING for term in event.terms):
            values[0] = self._direct_hold(state, rows, event)
        return values

    def _direct_hold(self, state: State[N], rows: ModeRows[N], event: Event[N]) -> N:
        x = (*state.x, self.kit.number(0), self._base(state, "x"))
        v = (*state.v, self.kit.number(0), self._base(state, "v"))
        total = None
        for term in event.terms:
            one = rows.couplings[term.P]
            force = one.k * (x[one.P] - x[one.Q]) + one.c * (v[one.P] - v[one.Q]) + one.offset
            part = term.coefficient * force
            total = part if total is None else total + part
        assert total is not None
        return total + event.constant

    def _push_switch(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        i, before = event.part, status.stops[event.part]
        if self._crossing(state, status, event.key, order) <= 0:
            return status, [], {event.key: 1}
        after = LIFTED if before == CONTACT else CONTACT
        kind = "contact_end" if after == LIFTED else "contact_begin"
        return status.with_stop(i, after), [(kind, i)], {event.key: 1}

    def _clearance_switch(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        i, before = event.part, status.clearances[event.part]
        turning = self._crossing(state, status, event.key, order)
        after = before if turning <= 0 else 1 - before
        happened = [] if after == before else [("violation_begin" if after else "violation_end", i)]
        return status.with_clearance(i, after), happened, {event.key: 1}

    def _sliding_ends(self, state: State[N], status: Status, event: Event[N]) -> Taken:
        i = event.part
        standing = self.standing(status, [i])
        after = self._settle(state, status, standing)
        known: Known = {}
        if after.frictions[i] == STICK:
            self._join(state, self.maker.rows(after), i)
        else:
            known[SLIDE, i] = 1
        return after, self._changes(status, after, known), known

    def standing(self, status: Status, more: Iterable[int] = ()) -> list[int]:
        """Ties that stand in the moment in which the ties `more` come to rest: these, those that hold, and
        frictions that others which hold then keep from sliding.
        """
        standing = {*more, *status.tied}
        while True:
            tied = status.with_ties(dict.fromkeys(standing, STICK))
            resting = self.maker.resting(tied) - standing
            if not resting:
                return sorted(standing)
            standing |= resting

    def _hold_ends(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        rows = self.maker.rows(status)
        cut = rows.cuts[event.part]
        if self._crossing(state, status, event.key, order) <= 0:
            return status, [], {event.key: 1}
        slips = {i: orientation * event.direction for i, orientation in cut.ties}
        count = len(status.frictions)
        after = status.with_ties(slips)
        drops = [i for i, sense in slips.items() if i < count and self.scene.frictions[i].drops(sense)]
        if drops:
            known: Known = {}
            after = self._settle_behind(state, status, after)
            happened = self._changes(status, after, known)
        else:
            happened = [("stick_end", i) if i < count else ("rest_end", i - count) for i in slips]
            known = {(SLIDE, i): 2 + order for i in slips if i < count}
            known |= {(STRIKE, i - count): 3 + order for i in slips if i >= count}
        after, parted = self._parted(state, status, after, 2 if drops else 3 + order, known)
        return after, happened + parted, known

    def _parted(
        self, state: State[N], status: Status, after: Status, order: int, known: Known
    ) -> tuple[Status, Happened]:
        """As `touching`, behind the release of ties, for the parts that the tied ends just touched."""
        parts = self.touched(state, *let_go(self.maker, status, after))
        return self.touching(state, status, after, parts, order, known)

    def touching(
        self,
        state: State[N],
        status: Status,
        after: Status,
        parts: tuple[Sequence[int], Sequence[int]],
        order: int,
        known: Known,
    ) -> tuple[Status, Happened]:
        """The status `after` an event, with those of some elastic stops and clearances, `parts`, whose ends
        just touch as the motion takes them; what happened to them since `status`. Their functions have a zero
        of some order there, which goes into `known`.
        """
        happened: Happened = []
        for i in parts[0]:
            closes = self._departure(state, after.with_stop(i, OPEN), (GAP, i), order)[0] < 0
            after = after.with_stop(i, CONTACT if closes else OPEN)
            known |= {(GAP, i): order, (PUSH, i): order - 1}
            if status.stops[i] != after.stops[i]:
                happened.append(("contact_begin" if closes else "contact_end", i))
        for i in parts[1]:
            closes = self._departure(state, after.with_clearance(i, KEPT), (CLEARANCE, i), order)[0] < 0
            after = after.with_clearance(i, VIOLATED if closes else KEPT)
            known[CLEARANCE, i] = order
            if status.clearances[i] != after.clearances[i]:
                happened.append(("violation_begin" if closes else "violation_end", i))
        return after, happened

    def touched(
        self, state: State[N], stops: Iterable[int], clearances: Iterable[int]
    ) -> tuple[list[int], list[int]]:
        """Those of some elastic stops and clearances whose ends just touch."""
        near = [(i, self.elastic[i]) for i in stops]
        limits = [(i, self.scene.clearances[i]) for i in clearances]
        return (
            [i for i, one in near if self._met(one, self._depth(one, state), state, one.gap)],
            [i for i, one in limits if self._met(one, self._excess(one, state), state, one.distance)],
        )

    def _settle_behind(self, state: State[N], status: Status, after: Status) -> Status:
        """The mode behind a release at which a friction force drops: the jump of the accelerations may tear
        other ties too. after: the status with the ties of the cut let go.
        """
        standing = status.tied
        settled = self._release(state, after, standing)
        if settled is not None:
            return settled
        self._doubt(state)
        consistent = self._first_consistent(state, after, standing, besides=status)
        return after if consistent is None else consistent

    # -- friction at rest

    def _settle(self, state: State[N], status: Status, standing: Sequence[int]) -> Status:
        """The status in which the ties `standing` (frictions with v_rel = 0, rigid stops with g = g' = 0)
        hold or let go consistently.
        """
        possible = self._possible(self.maker.rows(status.with_ties(dict.fromkeys(standing, STICK))))
        if possible:
            after = self._release(state, status.with_ties(dict.fromkeys(standing, STICK)), standing)
            if after is not None:
                return after
            self._doubt(state)
        consistent = self._first_consistent(state, status, standing)
        if consistent is not None:
            return consistent
        if not possible:
            self._doubt(state)
        return status.with_ties(dict.fromkeys(standing, STICK))

    def _first_consistent(
        self, state: State[N], status: Status, standing: Sequence[int], besides: Status | None = None
    ) -> Status | None:
        """The first consistent combination of the ties `standing`, those with most ties first; None
        without any. besides: a status that has been left.
        """
        for choice in combinations_of(standing, len(status.frictions)):
            candidate = status.with_ties(choice)
            if candidate != besides and self._consistent(state, candidate, standing):
                return candidate
        return None

    def _possible(self, rows: ModeRows[N]) -> bool:
        """Whether the ties of a mode can last: a base that moves cannot be tied to the ground, though it may
        rest for an instant.
        """
        ground = self.maker.n
        tied = rows.leader[ground + 1] == ground
        return not (tied and any(term.amplitude != 0 for term in self.scene.base))

    def _release(self, state: State[N], candidate: Status, standing: Sequence[int]) -> Status | None:
        """As long as cuts are overloaded, the ties of the one that is so most let go. None where that is not
        consistent in the end.
        """
        for _ in range(len(standing) + 1):
            rows = self._enter(state, candidate)
            broken = self._overloaded(state, rows)
            if broken is None:
                break
            cut = rows.cuts[broken.part]
            slips = {i: orientation * broken.direction for i, orientation in cut.ties}
            candidate = candidate.with_ties(slips)
        else:
            return None
        slipping = self._apart(candidate, standing)
        if len(standing) == 1 or self._slips_as_said(state, candidate, slipping):
            return candidate
        return None

    @staticmethod
    def _apart(status: Status, standing: Sequence[int]) -> list[int]:
        """The ties among `standing` that do not hold."""
        tied = set(status.tied)
        return [k for k in standing if k not in tied]

    def _overloaded(self, state: State[N], rows: ModeRows[N]) -> Event[N] | None:
        """The HOLD event furthest below zero behind the instant, or None."""
        worst: Event[N] | None = None
        depth: N | None = None
        forces = self._forces(rows)
        for event in rows.events:
            if event.kind == HOLD:
                values = self._hold_values(state, rows, event)
                if abs(values[0]) <= NEAR * (forces + event.size) and self._open(state, event, values, 0):
                    self._doubt(state)
                if first_sign(values) < 0 and (depth is None or values[0] < depth):
                    worst, depth = event, values[0]
        return worst

    def _forces(self, rows: ModeRows[N]) -> N:
        """Sum of the magnitudes of all forces in the mode entered last [N], of couplings by what each of
        their ends has: what the rounding of any force is below some hundred eps of.
        """
        flow, scene = self.flow, self.scene
        total = inertia = self.kit.number(0)
        for one in rows.couplings:
            places = abs(flow.x[one.P][0]) + abs(flow.x[one.Q][0])
            total = total + one.k * places + abs(one.offset)
            total = total + one.c * (abs(flow.v[one.P][0]) + abs(flow.v[one.Q][0]))
        for force in scene.forces:
            total = total + abs(force.constant)
        for term in (term for force in scene.forces for term in force.terms):
            total = total + abs(term.amplitude)
        for _, value in rows.constants:
            total = total + abs(value)
        for fall in rows.falls:
            total = total + abs(fall.on_P)
        for body in scene.bodies:
            inertia = inertia + body.m
        for term in scene.base:
            total = total + inertia * abs(term.amplitude * term.omega * term.omega)
        return total if scene.motor is None else total + self._motor_forces(scene.motor)

    def _motor_forces(self, motor: Motor[N]) -> N:
        """The same of a motor: of its unbalance, and of its torque at the radius of that."""
        rotor = self.flow.rotor
        assert rotor is not None  # there is a motor
        w = abs(rotor.w[0])
        return motor.m3 * motor.e * (w * w) + motor.M0 * (1 + w / motor.Omega0) / motor.e

    def _slips_as_said(self, state: State[N], status: Status, slipping: Sequence[int]) -> bool:
        """Whether the ties that let go do so in the direction of their status, and stops part."""
        if not slipping:
            return True
        rows, count = self._enter(state, status), len(status.frictions)
        for k in slipping:
            key, order = ((SLIDE, k), 1) if k < count else ((STRIKE, k - count), 2)
            event = self._event(rows, key)
            values = self.flow.derivatives(event, JET)
            if self._open(state, event, values, order):
                self._doubt(state)
            if first_sign(values[order:]) < 0:
                return False
        return True

    def _consistent(self, state: State[N], status: Status, standing: Sequence[int]) -> bool:
        if not self._possible(self.maker.rows(status)):
            return False
        rows = self._enter(state, status)
        if self._overloaded(state, rows) is not None:
            return False
        return self._slips_as_said(state, status, self._apart(status, standing))

    def _join(self, state: State[N], rows: ModeRows[N], i: int) -> None:
        """Give the bodies that friction `i` ties their common velocity; momentum is kept where they move
        freely.
        """
        P, _ = self.maker.ends(self.scene.frictions[i])
        leader, n = rows.leader[P], self.maker.n
        members = [c for c in rows.groups.members[leader] if c < n]
        if leader >= n:
            common = self.kit.number(0) if leader == n else self._base(state, "v")
        else:
            momentum = None
            for c in members:
                share = self.scene.bodies[c].m * (state.v[c] - rows.drift[c])
                momentum = share if momentum is None else momentum + share
            assert momentum is not None  # the leader itself is a member
            common = momentum / rows.own_mass(leader)
        for c in members:
            state.v[c] = common + rows.drift[c]


def _difference_error(a: N, b: N, difference: N) -> N:
    """What rounding took from a - b (Knuth's two-sum)."""
    back = a - difference
    return (a - (difference + back)) + (back - b)


def leading(values: Sequence[N], first: int) -> int:
    """Order of the first derivative, from order `first`, that is not zero; JET where all are."""
    return next((n for n in range(first, JET) if values[n] != 0), JET)


def sign(value: N) -> int:
    """-1, 0 or +1."""
    return 1 if value > 0 else -1 if value < 0 else 0


def combinations_of(standing: Sequence[int], frictions: int) -> Iterator[dict[int, int]]:
    """Statuses {number: status} that ties may go on with: those where most hold first. A tie behind the
    `frictions` is a stop, which opens one way only.
    """
    for count in range(len(standing) + 1):
        for chosen in combinations(standing, count):
            for senses in product(*((FORWARD, BACKWARD) if k < frictions else (FORWARD,) for k in chosen)):
                yield dict.fromkeys(standing, STICK) | dict(zip(chosen, senses, strict=True))


def first_sign(values: Iterable[N]) -> int:
    """Sign of the first value that is not zero; 0 where all are."""
    for value in values:
        if value != 0:
            return sign(value)
    return 0

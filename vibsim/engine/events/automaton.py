"""Transition at an event: the one mode that is consistent with the state behind it, the Filippov solution.

A mode is consistent where each of its event functions is positive just behind the instant: its first
derivative that is not zero is. So every decision at a zero looks at derivatives, never at the sign of a
rounded zero. Each transition tells which event functions are zero at its instant, and to which order. A
decision that rounding could turn is in doubt, and the certificate counts it. Two events at one instant are
taken one after the other. The mode that a run starts in is decided by the same rules.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Generic

from vibsim.engine.doubts import SIDE, SLOW, START, START_AT_REST, called, name_of, name_of_stop
from vibsim.engine.errors import EngineError, State
from vibsim.engine.events.departures import DerivativeSigns, TouchingParts, leading, sign
from vibsim.engine.events.impacts.newton_moreau import rate_of
from vibsim.engine.events.impacts.rigid_stops import RigidStops
from vibsim.engine.events.impacts.simultaneous import SimultaneousImpacts
from vibsim.engine.events.records import Happened, Taken, changes
from vibsim.engine.events.relative_motion import RelativeMotion
from vibsim.engine.events.settling import StickSlipResolution
from vibsim.engine.flows.expansion import Expansion
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import (
    CLEARANCE,
    DOMAIN,
    GAP,
    HOLD,
    PUSH,
    SLIDE,
    STRIKE,
    SWITCH,
    Event,
    Joined,
    Known,
    ModeRows,
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
from vibsim.engine.modes.ties import Edge, TooManyCuts
from vibsim.physics.numbers import N
from vibsim.physics.parts import Friction, RigidStop, Scene, Stop

MOST_LOOKS = 8  # at a start whose switches turn by what stops and frictions do there, and these by them


class Automaton(Generic[N]):
    """Decides the modes of a run: at its start, see `InitialMode`, and behind each event.

    doubt : is called with the time [s] of a decision that rounding could turn, the reason in words and the
        names of what is in doubt
    """

    def __init__(
        self,
        scene: Scene[N],
        maker: RowMaker[N],
        expansion: Expansion[N],
        doubt: Callable[[N, str, Iterable[str]], None],
    ) -> None:
        self.scene, self.maker = scene, maker
        self.elastic = dict(scene.elastic_stops)
        self.struck = False  # whether the event taken last was a kink of the base that made impacts
        relative = RelativeMotion(scene, expansion.kit)
        self.departures = DerivativeSigns(relative, maker, expansion, doubt)
        self.settling = StickSlipResolution(scene, maker, self.departures)
        self.parting = TouchingParts(maker, self.departures)
        self.rigid = RigidStops(scene, maker, self.settling, self.parting)
        self.starts = InitialMode(scene, maker, self.settling, self.rigid)

    def initial(self, state: State[N]) -> tuple[Status, Known]:
        """Status that the motion starts in from `state`, and the known zeros there."""
        with self._cuts_counted(state):
            switches = self.departures.switches
            if switches is None:
                return self.starts.initial(state)
            sides: tuple[int | None, ...] = ()
            for _ in range(MOST_LOOKS):
                before, known = self.starts.initial(state, sides)
                status, zeros = switches.initial(state, self.departures, before)
                if status.switches == switches.with_sides(state, before).switches:
                    break
                sides = status.switches  # with which what touches or stands may do something else
            else:
                raise EngineError("undecided", state)
            return status, known | zeros

    def take(self, state: State[N], status: Status, event: Event[N], order: int = 0) -> Taken:
        """Transition at the zero of `event` at `state`: (status, [(kind name, part)], known zeros).

        order : of the zero of the same function that the stretch began with, 0 for none; of a rigid stop, or
            where the stretch ends in the instant in which it began

        Moves the velocities of bodies that stick onto each other. At a reversal it keeps the residue of the
        time grid: the friction force turns dt too late, where cutting the residue would take momentum.
        Raises EngineError.
        """
        self.struck = False
        switches = self.departures.switches
        with self._cuts_counted(state):
            jumps = switches is not None and (event.kind == STRIKE or switches.kinks(event))
            came = state.copy() if jumps else None
            after, happened, known = self._take(state, status, event, order)
            if switches is not None:
                turned = [key[1] for key in known if key[0] == SWITCH and isinstance(key[1], int)]
                after = self._sides_behind(state, after, turned, status, came)
            return after, happened, known

    def _sides_behind(
        self,
        state: State[N],
        after: Status,
        fixed: Container[int],
        before: Status,
        came: State[N] | None = None,
    ) -> Status:
        """The mode behind an event with the sides of its switches, see `SwitchSides.completed`."""
        switches = self.departures.switches
        assert switches is not None
        open_ones: dict[int, bool] = {}
        after = switches.completed(state, after, fixed, open_ones, before, came)
        switches.doubt(state, self.departures, open_ones, SIDE)
        return after

    @contextmanager
    def _cuts_counted(self, state: State[N]) -> Iterator[None]:
        """Say EngineError of ties that can be cut in too many ways."""
        try:
            yield
        except TooManyCuts as error:
            names = ", ".join(self.scene.bodies[c].name for c in error.args if c < self.maker.n)
            raise EngineError("entangled", state, names) from error

    def _take(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        if event.kind == GAP:
            return self._contact_switch(state, status, event, order)
        if event.kind == STRIKE:
            touched = self.rigid.touch_again(state, status, event, order) if order > 1 else None
            return touched or self.rigid.meet(state, status, event.part, hop=order == 1)
        if event.kind == PUSH:
            return self._push_switch(state, status, event, order)
        if event.kind == CLEARANCE:
            return self._clearance_switch(state, status, event, order)
        if event.kind == SLIDE:
            return self._sliding_ends(state, status, event)
        if event.kind == SWITCH:
            return self._switch_turns(state, status, event, order)
        if event.kind == DOMAIN:
            raise EngineError("domain", state, self._owner_of(status, event))
        return self._hold_ends(state, status, event, order)

    def touch(self, event: Event[N]) -> SimultaneousImpacts[N] | None:
        """The `SimultaneousImpacts` of rigid stops that `event`, taken just now, was, or that a kink of the
        base made; None of other events.
        """
        return self.rigid.touch if event.kind == STRIKE or self.struck else None

    def _contact_switch(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        i = event.part
        stop, before = self.elastic[i], status.stops[i]
        crossing, at = self.departures.crossing(state, status, event.key, order)
        deeper = -event.direction * crossing  # sign of the depth behind here
        after = before if deeper == 0 else CONTACT if deeper > 0 else OPEN
        if before == LIFTED:
            after = OPEN if deeper < 0 else LIFTED
        status = status.with_stop(i, after)
        happened: Happened = []
        if after != before and before != LIFTED:
            happened.append(("contact_begin" if after == CONTACT else "contact_end", i))
        known: Known = {event.key: at}
        if after != before and stop.jumps and status.tied:
            tied = status
            status = self.settling.settle(state, status, tied.tied)
            happened += changes(tied, status, known)
        return status, happened, known

    def _push_switch(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        i, before = event.part, status.stops[event.part]
        crossing, at = self.departures.crossing(state, status, event.key, order)
        if crossing <= 0:
            return status, [], {event.key: at}
        after = LIFTED if before == CONTACT else CONTACT
        kind = "contact_end" if after == LIFTED else "contact_begin"
        return status.with_stop(i, after), [(kind, i)], {event.key: at}

    def _clearance_switch(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        i, before = event.part, status.clearances[event.part]
        turning, at = self.departures.crossing(state, status, event.key, order)
        after = before if turning <= 0 else 1 - before
        happened = [] if after == before else [("violation_begin" if after else "violation_end", i)]
        return status.with_clearance(i, after), happened, {event.key: at}

    def _owner_of(self, status: Status, event: Event[N]) -> str:
        """The name of the part that a formula belongs to."""
        tape = self.maker.rows(status).tape
        return tape.texts[event.part] if tape else ""

    def _switch_turns(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        """The mode on the other side of a switch. Raises EngineError where a jump would lead back."""
        switches, i = self.departures.switches, event.part
        assert switches is not None
        crossing, at = self.departures.crossing(state, status, event.key, order)
        if crossing <= 0:
            return status, [], {event.key: at}
        after = switches.turned(status, event)
        after = self._sides_behind(state, after, {i}, status, state if switches.kinks(event) else None)
        known: Known = {event.key: at}
        if switches.base_jumps(state, status, after, i):
            return self._base_turns(state, status, after, event, at)
        if not switches.jumps(state, status, after, i):
            return after, [], known
        sense, behind = 1, at
        if self.departures.watches(state, after, event.key):
            sense, behind = self.departures.departure(state, after, event.key)
        if sense < 0:
            return self._rest_at_switch(state, status, switches.rows.owners[i])
        after, pressed = self._pressed(state, after)
        happened: Happened = [("switch", switches.rows.part_of[i]), *pressed]
        tied, belts = after, switches.jumping_belts(state, status, after)
        after = after.with_frictions(belts)
        if after.tied:
            after = self.settling.settle(state, after, after.tied)
        happened += changes(tied, after, known)
        known |= {(SLIDE, k): 0 for k, sense in belts.items() if sense != STICK}
        return after, happened, {**known, event.key: behind}

    def _rest_at_switch(self, state: State[N], status: Status, owner: str) -> Taken:
        """The mode in which a friction whose ends come to rest at a switch, to rounding, holds them there.
        Raises EngineError where none does.
        """
        switches = self.departures.switches
        assert switches is not None
        blur, sides = switches.inputs(state, status)[1].v, switches.rows.sides(status)
        for event in self.maker.rows(status).events:
            if event.kind == SLIDE:
                friction = self.scene.frictions[event.part]
                open_to = sum(blur[column] for column in self.maker.ends(friction))
                if abs(self.starts.relative.slip(friction, state, sides)) <= open_to:
                    taken = self._sliding_ends(state, status, event)
                    if taken[0].frictions[event.part] == STICK:
                        return taken
        raise EngineError("held", state, owner)

    def _pressed(self, state: State[N], status: Status, base: bool = False) -> tuple[Status, Happened]:
        """The status with the stops that let go by force as their forces say where these jump: those by
        formulas, and with `base` those on it, whose velocity does; what happened to them.
        """
        happened: Happened = []
        for i, stop in self.scene.elastic_stops:
            moved = base and self.maker.n + 1 in self.maker.ends(stop)
            before = status.stops[i]
            if not stop.lets_go or before == OPEN or not (moved or stop.force is not None):
                continue
            pulls = self.departures.pulls(state, status.with_stop(i, CONTACT), stop, i)
            status = status.with_stop(i, LIFTED if pulls else CONTACT)
            if status.stops[i] != before:
                happened.append(("contact_end" if pulls else "contact_begin", i))
        return status, happened

    def _base_turns(
        self, state: State[N], status: Status, after: Status, event: Event[N], order: int
    ) -> Taken:
        """The mode behind a kink of the base's motion: friction gives no impulse, so that what stuck to the
        base slips; a rigid stop that rested on it is left behind, or struck.
        """
        switches, base = self.departures.switches, self.maker.n + 1
        assert switches is not None
        switches.step_behind_kink(state, after)
        happened: Happened = [("switch", switches.rows.part_of[event.part])]
        senses = switches.jumping_belts(state, status, after, base=True)
        after, pressed = self._pressed(state, after, base=True)
        happened += pressed
        behind = after.with_frictions(senses)
        velocities = self.rigid.impacts.velocities(state)
        struck: list[int] = []
        known: Known = {}
        for j, contact in self.rigid.impacts.contacts.items():
            if base in (contact.P, contact.Q) and after.stops[j] == RESTING:
                rate = rate_of(self.departures.kit, contact, velocities)
                behind = behind.with_stop(j, OPEN)
                struck += [j] if rate > 0 else []
        if struck:
            self.struck = True
            settled, impacts, known = self.rigid.meet(state, behind, struck[0])
            happened += impacts
        else:
            settled = self.settling.settle(state, behind, behind.tied) if behind.tied else behind
        told = {k for kind, k in happened if kind in ("stick_begin", "stick_end", "reversal")}
        zeros: Known = {}
        happened += [
            one for one in changes(after, settled, zeros) if one[1] not in told or one[0] == "rest_end"
        ]
        known = zeros | known
        known |= {(SLIDE, k): 0 for k in senses if settled.frictions[k] != STICK}
        known |= {
            (STRIKE, j): 1 for j in self.rigid.stops if (after.stops[j], settled.stops[j]) == (RESTING, OPEN)
        }
        return settled, happened, {**known, event.key: order}

    def _sliding_ends(self, state: State[N], status: Status, event: Event[N]) -> Taken:
        i = event.part
        standing = self.settling.standing(status, [i])
        after = self.settling.settle(state, status, standing)
        if after.frictions[i] == STICK:
            self.settling.join(state, self.maker.rows(after), i)
        known: Known = {}
        happened = changes(status, after, known)
        return after, happened, known | self._slips(state, after, standing)

    def _slips(self, state: State[N], after: Status, standing: Iterable[int]) -> Known:
        """The zeros of the ends of sliding of those of the frictions among the ties `standing` that slip."""
        return {
            (SLIDE, k): self.departures.clear_order(state, after, (SLIDE, k))
            for k in standing
            if k < len(after.frictions) and after.frictions[k] != STICK
        }

    def _hold_ends(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken:
        rows = self.maker.rows(status)
        cut = rows.cuts[event.part]
        crossing, at = self.departures.crossing(state, status, event.key, order)
        if crossing <= 0:
            return status, [], {event.key: at}
        slips = {i: orientation * event.direction for i, orientation in cut.ties}
        count = len(status.frictions)
        after = status.with_ties(slips)
        drops = [i for i, sense in slips.items() if i < count and self.scene.frictions[i].drops(sense)]
        if drops and self._unloaded(state, rows, event):
            drops = []
        if drops:
            known: Known = {}
            after = self.settling.settle_behind(state, status, after)
            happened = changes(status, after, known)
        else:
            happened = [("stick_end", i) if i < count else ("rest_end", i - count) for i in slips]
            known = {(SLIDE, i): 1 + at for i in slips if i < count}
            known |= {(STRIKE, i - count): 2 + at for i in slips if i >= count}
        after, parted = self.parting.parted(state, status, after, 2 if drops else 2 + at, known)
        return after, happened + parted, known

    def _unloaded(self, state: State[N], rows: ModeRows[N], event: Event[N]) -> bool:
        """Whether a cut lets go because its load comes to nothing: it holds as little the other way, and no
        force drops.
        """
        opposite = (HOLD, rows.cuts[event.part].columns, -event.direction)
        other = next((one for one in rows.events if one.key == opposite), None)
        if other is None:
            return False
        values = self.departures.hold_values(state, self.departures.enter(state, rows.status), other)
        return self.departures.passes_now(state, other, values)


# The mode that a run starts in.


class InitialMode(Generic[N]):
    """Decides the mode of a start, which is exact: what touches there touches."""

    def __init__(
        self, scene: Scene[N], maker: RowMaker[N], settling: StickSlipResolution[N], rigid: RigidStops[N]
    ) -> None:
        self.scene, self.maker, self.settling, self.rigid = scene, maker, settling, rigid
        self.departures: DerivativeSigns[N] = settling.departures
        self.relative = settling.relative
        self.elastic = dict(scene.elastic_stops)

    def initial(self, state: State[N], switches: tuple[int | None, ...] = ()) -> tuple[Status, Known]:
        """Status that the motion starts in from `state`, and the known zeros there; switches: the sides of
        those of formulas, where some are known.
        """
        scene = self.scene
        depths = [self.relative.depth(stop, state) for stop in scene.stops]
        met = [
            self.relative.met(stop, state) or self._rests(stop, g, state)
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
        status = self._pressing(state, Status(stops, frictions, clearances, switches), met)
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
                self.departures.doubt(state, START, [name_of_stop(scene, i)])
        touched = [i for i in self.elastic if met[i] and i not in self.maker.guarded]
        status, orders = self.rigid.parting.left(state, status, touched)
        known |= {(GAP, i): order for i, order in orders.items()}
        for i, over in enumerate(slacks):
            at = self.relative.met(scene.clearances[i], state)
            if self.relative.blurred(over, scene.clearances[i], state, -scene.clearances[i].distance, at):
                self.departures.doubt(state, START, [name_of(scene, CLEARANCE, i)])
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
            self.departures.doubt(state, START_AT_REST, [called("stop", stop)])
        return rests

    def _slip(self, friction: Friction[N], state: State[N]) -> N:
        """The sliding velocity at the start: none, in doubt, where the base's rounding may be all of it. A
        period after a start that sticks on the base a body has the base's velocity but for that.
        """
        rate = self.relative.slip(friction, state)
        if not self.relative.turned_by_base(friction, rate, state.t):
            return rate
        self.departures.doubt(state, SLOW, [called("friction", friction)])
        return self.relative.kit.number(0)

    def _held(self, state: State[N], status: Status) -> Known:
        """Orders of the zeros from which what ties may carry begins to grow."""
        known: Known = {}
        if not status.tied:
            return known
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
                status = status.with_stop(i, CONTACT if self.relative.closing(stop, state) > 0 else OPEN)
            elif status.stops[i] == CONTACT and self.departures.pulls(state, status, self.elastic[i], i):
                status = status.with_stop(i, LIFTED)
        return status


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
            scene.has_base
            or scene.clearances
            or scene.has_courses
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

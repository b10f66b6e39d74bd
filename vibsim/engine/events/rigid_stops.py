"""What follows where rigid stops touch: impacts, rest, and the end of infinite sequences of impacts.

Within one instant, in this order: the law of impacts over all rigid stops that touch, again as long as one of
them still closes; frictions and damped stops as the new velocities say; what is at rest sticks, rests or
parts as the accelerations say. A stop that would be struck again within the resolution of time is at the end
of such a sequence and comes to rest.

Resolution of time: behind a blow with the speed w, against the acceleration a that drives the ends together,
the next blow comes after 2 w / a and the last one after 2 w / (a (1 - e)), as long as a stays what it is. The
former cannot be told from now below NEXT units in the last place of t, the latter is not worth waiting for
below LAST of them; against the base, a unit is no less than the time in which a takes up what the rounding of
its angles leaves open of its velocity. Where the approach itself was as slow as that there was no impact, but
a touch that stays.

Resolution of forces: with e = 1 hops never end. Where forces cancel and rounding of what is left parts two
ends that stand, they would hop on with the speeds that rounding gave them, 1e17 times a second. So a hop no
faster than rounding of the forces can have made it since t = 0 ends in rest, in doubt.

Resolution of length: where a friction turns round at the top of a hop, the motion starts anew from rounded
displacements, and the return is lost in that where the height w^2 / (2 a) is. So the sequence ends below
LOWEST of their rounding, at e = 1 too. With the acceleration b of the return it would have lasted for another
w (1 / a + 1 / sqrt(a b)) / (1 - e sqrt(b / a)), some 1e-7 s, which is told. A friction that holds from where
it comes to rest, after s, takes from the hop as well: it returns from w s - a s^2 / 2 on at b.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING, Generic

from vibsim.engine.errors import EngineError
from vibsim.engine.events.newton_moreau import (
    MOST_BLOWS,
    NEAR,
    Contact,
    Impulse,
    blow,
    masses,
    motor_body,
    rate_of,
    size_of,
    unmet,
)
from vibsim.engine.flows.taylor_rounding import TaylorRounding
from vibsim.engine.modes.rows import PUSH, SLIDE, STRIKE, Known
from vibsim.engine.modes.status import BACKWARD, CONTACT, FORWARD, LIFTED, OPEN, RESTING, STICK, Status
from vibsim.engine.modes.ties import Edge, Groups, Tie
from vibsim.engine.state import State
from vibsim.physics.numbers import N, abs
from vibsim.physics.parts import AT_FORCE, RigidStop

if TYPE_CHECKING:
    from vibsim.engine.events.automaton import Automaton

Happened = list[tuple[str, int]]  # kinds of events by name, and the parts that they happen to
Taken = tuple[Status, Happened, Known]  # the mode behind an event, what happened, and what is zero there

NEXT, LAST = 2, 8  # units in the last place of the time
ROUNDING = 8  # of a sum or a difference of two numbers, in units of eps
IN_TURN = 32  # blows one after the other that are tried where the order is in doubt
TURNING = 4  # times the speed of a hop: what slips faster does not turn round in it
LATEST = 6  # derivative of a depth that is consulted where rounding hides those before it
LOWEST = 1024  # of displacements; event functions near zero are watched to some hundred


@dataclass(frozen=True)
class Catch(Generic[N]):
    """What ends give away as they come to rest on each other behind the hops that are left out.

    stop : where; loss : of energy [J]; impulse : of ground or base on the bodies [N s], zero where these move
    freely; column : of what catches them
    """

    stop: int
    loss: N
    impulse: N
    column: int


@dataclass
class Touch(Generic[N]):
    """The rigid stops that touch at an instant, and what blows did there.

    before : rates of their depths before the first blow; v, w : velocities of all columns and of the rotor
    there
    rates : behind the last one, exactly 0 where the law or rounding says so; blows : by blow, the stops that
    passed an impulse, and these; moved : columns whose velocities they changed
    catches : by group of ends that come to rest on each other
    ended : by stop where an infinite sequence of impacts ended, the speed that rounding of the time hides;
    faded : stops at which one ended without a blow; hop : the stop whose last blow was where the stretch
    began that ends here
    together : whether rounding might decide if another stop, of one of its bodies, is struck before this one
    """

    contacts: list[Contact[N]]
    before: dict[int, N]
    rates: dict[int, N]
    v: list[N]
    w: N
    together: bool
    blows: list[list[tuple[Contact[N], Impulse[N]]]] = field(default_factory=list)
    moved: set[int] = field(default_factory=set)
    catches: list[Catch[N]] = field(default_factory=list)
    ended: dict[int, N] = field(default_factory=dict)
    faded: list[int] = field(default_factory=list)
    hop: int | None = None

    @property
    def passed(self) -> list[Impulse[N]]:
        """The impulses, blow by blow."""
        return [impulse for one in self.blows for _, impulse in one]


@dataclass
class CutOff(Generic[N]):
    """What the ends of infinite sequences of impacts left out, summed: time [s], speed [m/s], distance
    [m].

    ends : (when, distance from then on), by sequence
    """

    time: N
    speed: N
    distance: N
    ends: list[tuple[N, N]] = field(default_factory=list)

    def add(self, t: N, time: N, speed: N, distance: N) -> None:
        """Count one that ended at t [s]."""
        self.time, self.speed, self.distance = self.time + time, self.speed + speed, self.distance + distance
        self.ends.append((t, self.distance))


class RigidStops(Generic[N]):
    """Decides for the `Automaton` what rigid stops do.

    touch : what the event taken last was; cut_off : see `CutOff`; lowest : see LOWEST
    """

    def __init__(self, automaton: Automaton[N]) -> None:
        self.automaton = automaton
        self.scene, self.maker, self.kit = automaton.scene, automaton.maker, automaton.kit
        self.stops = dict(self.scene.rigid_stops)
        self.frictions = len(self.scene.frictions)
        self.touch: Touch[N] | None = None
        self.lowest = LOWEST
        zero = self.kit.number(0)
        self.cut_off = CutOff(zero, zero, zero)

    def meet(self, state: State[N], status: Status, i: int, hop: bool = False) -> Taken:
        """What follows where stop `i` touches, as `Automaton.take`: (status, what happened, known zeros).

        hop : whether the last blow on it was where the stretch began
        """
        touch = self._touching(state, status, i)
        touch.hop = i if hop else None
        self._doubt_order(state, status, touch, i)
        self._strike(state, touch)
        bounds = self._bounds(state, touch)
        after, lifts = self._lifted(state, self._turned(state, status, touch), touch, bounds[0])
        settled = self._settled(state, after, touch)
        while self._ends(state, settled, touch):
            settled = self._settled(state, after, touch)
        if touch.hop is not None:
            self._fade(state, settled, touch, i)
        resting = [j for j in touch.rates if status.stops[j] == OPEN != settled.stops[j]]
        self._seat(state, sorted({*resting, *(one.stop for one in touch.passed)}))
        for k, (old, new) in enumerate(zip(status.frictions, settled.frictions, strict=True)):
            if old != STICK == new:
                self.automaton._join(state, self.maker.rows(settled), k)
        self.touch = touch
        known = self._forgotten(touch, after)
        changes = self.automaton._changes(status, settled, known)
        settled, begun = self.automaton.touching(state, status, settled, bounds, 1, known)
        opened = {j for j in touch.rates if status.stops[j] == RESTING}
        for j in {i, *opened, *(j for one in touch.passed for j in self._twins(touch, one.stop))}:
            if settled.stops[j] == OPEN:
                known[STRIKE, j] = self._parting(state, settled, j) if touch.rates[j] == 0 else 1
        return settled, [*self._happened(touch), *lifts, *changes, *begun], known

    def at_start(self, state: State[N], met: Container[int]) -> tuple[dict[int, int], list[int]]:
        """Of the stops `met` at the start: ({stop: order of the zero of its depth}, those that neither close
        nor part). One that closes is struck at once.
        """
        orders: dict[int, int] = {}
        standing: list[int] = []
        for j, _ in self.scene.rigid_stops:
            if j in met:
                rate = rate_of(self.kit, self._contact(j), self._velocities(state))
                if self.automaton._turned_by_base(self.stops[j], rate, state):
                    self.automaton._doubt(state)
                if rate == 0:
                    standing.append(j)
                if rate <= 0:
                    orders[j] = 2 if rate == 0 else 1
        if standing:
            self._join(state, standing)
            self._seat(state, standing)
        return orders, standing

    # -- who touches

    def _velocities(self, state: State[N]) -> list[N]:
        return [*state.v, self.kit.number(0), self.automaton._base(state, "v")]

    def _contact(self, j: int) -> Contact[N]:
        stop = self.stops[j]
        P, Q = self.maker.ends(stop)
        return Contact(j, P, Q, stop.sense, stop.e)

    def _touching(self, state: State[N], status: Status, i: int) -> Touch[N]:
        """The stops that rest, and those that meet stop `i` within the resolution of time and length.

        A body that was seated at one stop has moved by the rounding of that one's displacements. Stop `i` is
        met at the zero of its depth: what the state has of it tells how far rounding is off for its ends.
        """
        v, kit = self._velocities(state), self.kit
        within = LAST * self._unit_of(state.t)
        off = abs(self.automaton._depth(self.stops[i], state))
        contacts: list[Contact[N]] = []
        together = False
        for j, stop in self.scene.rigid_stops:
            contact, room = self._contact(j), -self.automaton._depth(stop, state)
            rate, size = rate_of(kit, contact, v), self._size(stop, state)
            if j != i and self._share(i, j):
                size = max(size, self._size(self.stops[i], state))
            near = abs(rate) * within + ROUNDING * kit.eps * size
            if j != i and self._share(i, j):
                near = near + off
            if j == i or status.stops[j] == RESTING or room <= near:
                contacts.append(contact)
            if j != i and status.stops[j] == OPEN and rate > 0 and self._share(i, j):
                together |= room <= NEAR * (rate * self._unit_of(state.t) + kit.eps * size)
        rates = {c.stop: rate_of(kit, c, v) for c in contacts}
        return Touch(contacts, dict(rates), rates, v, state.w, together)

    def _share(self, i: int, j: int) -> bool:
        """Whether two stops act on a common body."""
        ends, others = (set(self.maker.ends(self.stops[k])) for k in (i, j))
        return any(column < self.maker.n for column in ends & others)

    def _size(self, stop: RigidStop[N], state: State[N]) -> N:
        xP, xQ = self.automaton._ends(stop, state, "x")
        return abs(xP) + abs(xQ) + abs(stop.gap)

    def _unit_of(self, t: N) -> N:
        """One unit in the last place of a time [s]."""
        return self.kit.next_after(t, inf) - t

    def _resolution(self, t: N, contact: Contact[N], drive: N) -> N:
        """What rounding leaves open of times [s] at a stop that `drive` [m/s^2] closes."""
        kit, unit = self.kit, self._unit_of(t)
        if self.maker.n + 1 not in (contact.P, contact.Q):
            return unit
        blur = kit.number(0)
        for term in self.scene.base:
            angle = kit.turn_angle(term.cycles, term.cycles_lo, t) + term.phase
            blur = blur + abs(term.amplitude * term.omega * (kit.eps * angle))
        return blur / drive if blur > unit * drive else unit

    # -- blows

    def _strike(self, state: State[N], touch: Touch[N]) -> None:
        """Blows as long as a stop closes; the last of too many are plastic. So are those behind one that
        cannot obey its law though the bodies can stand: without room between two stops blows follow each
        other at one instant until nothing is left of the speed.
        """
        v, w = self._velocities(state), state.w
        bodies, contacts = masses(self.scene, self.kit, state.phase), touch.contacts
        size = size_of(contacts, v)
        for count in range(MOST_BLOWS + len(contacts)):
            if not any(rate > 0 for rate in touch.rates.values()):
                break
            if count == MOST_BLOWS:
                contacts = self._plastic(state, contacts)
            struck, turned, passed = blow(self.kit, bodies, contacts, v, w)
            if unmet(self.kit, contacts, v, struck):
                contacts = self._plastic(state, contacts)
                struck, turned, passed = blow(self.kit, bodies, contacts, v, w)
                if unmet(self.kit, contacts, v, struck):
                    raise EngineError("crushed", state, self._names(c.stop for c in contacts))
            v, w = self.kit.all_exact(struck), self.kit.exact(turned)  # radii would grow from blow to blow
            touch.rates = {c.stop: rate_of(self.kit, c, v, size) for c in contacts}
            telling = [one for one in passed if count == 0 or touch.rates[one.stop] != 0]
            for one in telling:
                touch.rates |= dict.fromkeys(self._twins(touch, one.stop), one.after)
            contact = {c.stop: c for c in contacts}
            touch.blows.append([(contact[one.stop], one) for one in passed])
        ends = [(c.P, c.Q) for one in touch.passed for c in contacts if c.stop == one.stop]
        touch.moved = {column for pair in ends for column in pair if column < self.maker.n}
        state.v[:] = [self.kit.exact(value) for value in v[: self.maker.n]]
        state.w = self.kit.exact(w)

    def _plastic(self, state: State[N], contacts: Sequence[Contact[N]]) -> list[Contact[N]]:
        """The stops with e = 0, which is a doubt."""
        self.automaton._doubt(state)
        return [Contact(c.stop, c.P, c.Q, c.sense, self.kit.number(0)) for c in contacts]

    def _names(self, stops: Iterable[int]) -> str:
        return ", ".join(sorted(self.stops[j].name for j in stops))

    def _twins(self, touch: Touch[N], i: int) -> list[int]:
        """The stops that touch between the ends of stop `i` and on its side, itself first: their depths are
        one.
        """
        one = self._contact(i)
        ways = [(one.P, one.Q, one.sense), (one.Q, one.P, -one.sense)]
        return [i, *(c.stop for c in touch.contacts if c.stop != i and (c.P, c.Q, c.sense) in ways)]

    def _doubt_order(self, state: State[N], status: Status, touch: Touch[N], i: int) -> None:
        """Doubt a blow at stop `i` in which others take part that rounding has brought to the same instant,
        where blows one after the other would have another outcome. Those at rest take part anyway, and what
        touches at the start does so exactly.
        """
        open_ones = [c for c in touch.contacts if c.stop != i and status.stops[c.stop] == OPEN]
        loose = [c for c in open_ones if state.t != 0 or not self.stops[c.stop].at_start]
        if loose:
            certain = [c for c in touch.contacts if c not in loose]
            together = self._outcome(state, [touch.contacts])
            one_by_one = [[c] for c in loose]
            noise = NEAR * self.kit.eps * size_of(touch.contacts, touch.v)
            for groups in ([certain, *one_by_one], [*one_by_one, certain]):
                after = self._outcome(state, groups)
                if any(abs(a - b) > noise for a, b in zip(together, after, strict=True)):
                    self.automaton._doubt(state)

    def _outcome(self, state: State[N], groups: Sequence[Sequence[Contact[N]]]) -> list[N]:
        """Velocities behind blows at groups of stops, one group after the other, as long as one closes."""
        v, w = self._velocities(state), state.w
        bodies = masses(self.scene, self.kit, state.phase)
        size = size_of([c for group in groups for c in group], v)
        for _ in range(IN_TURN):
            closing = [g for g in groups if any(rate_of(self.kit, c, v, size) > 0 for c in g)]
            if not closing:
                break
            v, w, _ = blow(self.kit, bodies, closing[0], v, w)
        return v

    def _forgotten(self, touch: Touch[N], status: Status) -> Known:
        """Zeros of functions of velocities that blows have changed: none any more, but for what stands."""
        known: Known = {}
        for i, friction in enumerate(self.scene.frictions):
            if touch.moved & set(self.maker.ends(friction)) and status.frictions[i] != STICK:
                known[SLIDE, i] = 0
        for i, stop in self.scene.elastic_stops:
            if touch.moved & set(self.maker.ends(stop)):
                known[PUSH, i] = 0
        return known

    def _turned(self, state: State[N], status: Status, touch: Touch[N]) -> Status:
        """The status with the frictions of the columns that blows moved as the velocities say."""
        v, size = self._velocities(state), size_of(touch.contacts, touch.v)
        turned: dict[int, int] = {}
        for i, friction in enumerate(self.scene.frictions):
            P, Q = self.maker.ends(friction)
            if touch.moved & {P, Q}:
                slip = (v[P] - v[Q]) - friction.belt
                own = abs(v[P]) + abs(v[Q]) + abs(friction.belt)
                noise = ROUNDING * self.kit.eps * (own if own > size else size)
                turned[i] = STICK if abs(slip) <= noise else FORWARD if slip > 0 else BACKWARD
        return status.with_frictions(turned)

    def _bounds(self, state: State[N], touch: Touch[N]) -> tuple[list[int], list[int]]:
        """The elastic stops and the clearances whose ends just touch and are moved by blows: in doubt behind
        the start, where rounding may have brought them there.
        """
        elastic = ((i, stop) for i, stop in self.scene.elastic_stops if i not in self.maker.guarded)
        stops, clearances = self.automaton.touched(
            state,
            [i for i, stop in elastic if touch.moved & set(self.maker.ends(stop))],
            [i for i, one in enumerate(self.scene.clearances) if touch.moved & set(self.maker.ends(one))],
        )
        if (stops or clearances) and state.t != 0:
            self.automaton._doubt(state)
        return stops, clearances

    def _lifted(
        self, state: State[N], status: Status, touch: Touch[N], bounds: Container[int]
    ) -> tuple[Status, Happened]:
        """The status with the damped stops that let go at zero force as the velocities say, and the elastic
        stops `bounds`, whose ends just touch, in contact where they close; what happened to the former.
        """
        auto = self.automaton
        happened: Happened = []
        for i, stop in self.scene.elastic_stops:
            pressed = stop.release == AT_FORCE and stop.c != 0 and status.stops[i] != OPEN
            if i in bounds:
                vP, vQ = auto._ends(stop, state, "v")
                status = status.with_stop(i, CONTACT if -(stop.sense * (vP - vQ)) > 0 else OPEN)
            elif pressed and touch.moved & set(self.maker.ends(stop)):
                (vP, vQ), depth = auto._ends(stop, state, "v"), auto._depth(stop, state)
                pushes = stop.k * depth - stop.c * (stop.sense * (vP - vQ)) >= 0
                after = CONTACT if pushes else LIFTED
                if after != status.stops[i]:
                    happened.append(("contact_begin" if pushes else "contact_end", i))
                status = status.with_stop(i, after)
        return status, happened

    # -- rest

    def _settled(self, state: State[N], status: Status, touch: Touch[N]) -> Status:
        """The status in which all that stands sticks, rests or parts consistently; tied bodies get their
        common velocities.
        """
        rests = {self.frictions + j: STICK if rate == 0 else FORWARD for j, rate in touch.rates.items()}
        status = status.with_ties(rests)
        touch.catches += self._join(state, [k - self.frictions for k in status.tied if k >= self.frictions])
        standing = self.automaton.standing(status)
        settled = self.automaton._settle(state, status, standing) if standing else status
        if RESTING in settled.stops and not self.automaton._possible(self.maker.rows(settled)):
            resting = (j for j in self.stops if settled.stops[j] == RESTING)
            raise EngineError("crushed", state, self._names(resting))
        return settled

    def _join(self, state: State[N], stops: Sequence[int]) -> list[Catch[N]]:
        """Give bodies that touch without closing at some stops one velocity; momentum is kept where they move
        freely, and that of the rotor everywhere. Tells what they gave away.
        """
        n, zero, motor = self.maker.n, self.kit.number(0), self.scene.motor
        edges = {j: self.maker.ends(self.stops[j]) for j in stops}
        groups = Groups(n, [(0, *edge) for edge in edges.values()])
        inertias = [body.m for body in self.scene.bodies]
        if motor is not None:
            inertias[motor.on], turning = motor_body(motor, inertias[motor.on], self.kit, state.phase)
            before = state.v[motor.on]
        catches: list[Catch[N]] = []
        for leader, members in groups.members.items():
            bodies = [c for c in members if c < n]
            if len(members) > 1 and bodies:
                still = zero if leader <= n else self.automaton._base(state, "v")
                common = still
                if leader < n:
                    common = self._mean([inertias[c] for c in bodies], [state.v[c] for c in bodies])
                loss = impulse = zero
                for c in bodies:
                    gained = inertias[c] * (common - state.v[c])
                    loss = loss - gained * ((state.v[c] + common) / 2 - still)
                    impulse = impulse + gained
                    state.v[c] = common
                if loss != 0 or impulse != 0:
                    stop = next(j for j, edge in edges.items() if groups.leader[edge[0]] == leader)
                    catches.append(Catch(stop, loss, impulse if leader >= n else zero, leader))
        if motor is not None:
            state.w = self.kit.exact(state.w + turning * (state.v[motor.on] - before))
        return catches

    def _mean(self, inertias: Sequence[N], values: Sequence[N]) -> N:
        """Mean of the velocities of bodies, weighted by what impulses meet; equal ones are their mean."""
        if all(value == values[0] for value in values):
            return values[0]
        total = weight = self.kit.number(0)
        for m, value in zip(inertias, values, strict=True):
            total, weight = total + m * value, weight + m
        return self.kit.exact(total / weight)

    def _ends(self, state: State[N], status: Status, touch: Touch[N]) -> bool:
        """Bring open stops to rest that would be struck again within the resolution of time; whether there
        are any.
        """
        chatter = False
        for c in touch.contacts:
            speed = -touch.rates[c.stop]
            if status.stops[c.stop] != OPEN or speed == 0:
                continue
            drive = self._drive(state, status, c.stop)
            if drive <= 0:
                continue
            unit, after = self._resolution(state.t, c, drive), 2 * speed / drive
            hidden = unit * drive
            last = after if c.e == 1 else after / (1 - c.e)
            soon = after <= NEXT * unit or (c.e < 1 and after <= (1 - c.e) * (LAST * unit))
            if c.e == 1 and not soon:
                cancelled = 2 * self._unsure(state, status, c.stop)
                soon = 2 * speed <= NEXT * cancelled
                if soon:
                    hidden = cancelled
                    self.automaton._doubt(state)
            low = not soon and self._is_low(state, c.stop, speed * after / 4)
            rubbing = self._rubbing(state, status, c, speed, after) if low else []
            if rubbing:
                lasting = self._lasting(state, status, c, rubbing, speed, drive)
                soon, last = lasting is not None, last if lasting is None else lasting
            if soon:
                self.cut_off.add(state.t, last, speed, speed * after / 8)
                touch.rates[c.stop], touch.ended[c.stop] = self.kit.number(0), hidden
                chatter = True
        return chatter

    def _fade(self, state: State[N], status: Status, touch: Touch[N], i: int) -> None:
        """Take a hop on stop `i` that ends in rest for the last of its sequence where rounding of velocities
        tells no approach, or none of how a plastic blow tears another stop open that would be struck next.
        """
        if touch.before[i] == 0:
            fading = [i] if 0 < self.stops[i].e < 1 else []
        else:
            fading = [j for j in touch.rates if self._torn(touch, j)] if self.stops[i].e == 0 else []
        for j in fading:
            if status.stops[i] == RESTING == status.stops[j]:
                v, c = self._velocities(state), self._contact(j)
                opened = status
                for twin in self._twins(touch, j):
                    opened = opened.with_stop(twin, OPEN)
                drive = self._drive(state, opened, j)
                if drive > 0:
                    self._leave_out(
                        state.t, self.kit.eps * ROUNDING * (abs(v[c.P]) + abs(v[c.Q])), drive, c.e
                    )
                    touch.faded.append(j)

    def _torn(self, touch: Touch[N], j: int) -> bool:
        """Whether blows moved an end of a stop that rested, and rounding hides what came of it."""
        ends = set(self.maker.ends(self.stops[j]))
        idle = j not in {*touch.ended, *(one.stop for one in touch.passed)}
        return idle and bool(ends & touch.moved) and touch.before[j] == touch.rates[j] == 0

    def _leave_out(self, t: N, speed: N, drive: N, e: N) -> None:
        """Count the hops that are left out from t [s] on, the first of which begins with a speed [m/s]."""
        after = 2 * speed / drive
        self.cut_off.add(t, after / (1 - e), speed, speed * after / 8)

    def _rubbing(self, state: State[N], status: Status, contact: Contact[N], speed: N, after: N) -> list[int]:
        """Frictions at an end of a stop, or at what moves with it, that slip so slowly that a hop which
        begins with a speed [m/s] turns them round, or come to rest before the next blow, `after` [s].
        """
        leader, n = self.maker.ties(status)[0], self.maker.n
        hopping = {leader[column] for column in (contact.P, contact.Q) if leader[column] < n}
        ends = {column for column in range(n) if leader[column] in hopping}
        return [
            i
            for i, one in enumerate(self.scene.frictions)
            if status.frictions[i] != STICK
            and ends & set(self.maker.ends(one))
            and (
                abs(self.automaton._slip(one, state)) <= TURNING * speed
                or 0 < self._halt(state, status, i) <= after
            )
        ]

    def _is_low(self, state: State[N], j: int, height: N) -> bool:
        """Whether rounding of displacements hides a hop of some height [m]."""
        return height <= self.lowest * self.kit.eps * self._size(self.stops[j], state)

    def _lasting(
        self, state: State[N], status: Status, c: Contact[N], rubbing: Sequence[int], speed: N, drive: N
    ) -> N | None:
        """How long a sequence of impacts would go on whose hops rise against `drive` and return with the
        frictions `rubbing` turned round, or holding where they do not turn [s]; None where these take nothing
        of them and e = 1 does not either.
        """
        turned = status.with_frictions({i: -status.frictions[i] for i in rubbing})
        back = self._drive(state, turned, c.stop)
        if not 0 < back < drive:
            lasting = self._lasting_held(state, status, c, rubbing, speed, drive)
            return 2 * speed / drive / (1 - c.e) if lasting is None and c.e < 1 else lasting
        share = self.kit.sqrt(back / drive)
        return speed / drive * (1 + 1 / share) / (1 - c.e * share)

    def _lasting_held(
        self, state: State[N], status: Status, c: Contact[N], rubbing: Sequence[int], speed: N, drive: N
    ) -> N | None:
        """How long a sequence of impacts would go on whose hops return with the frictions `rubbing` holding
        from where they come to rest [s]; None where they do not, or no such hop is lower than the one before.
        """
        back = self._drive_held(state, status, c, rubbing)
        halts = [self._halt(state, status, i) for i in rubbing]
        if not 0 < back < drive or not all(halt > 0 for halt in halts):
            return None
        halt = halts[0]
        for other in halts[1:]:
            halt = other if other > halt else halt
        height, rate = (speed - drive * halt / 2) * halt, speed - drive * halt
        if height <= 0:
            return None
        again = self.kit.sqrt(rate * rate + 2 * back * height)
        share = c.e * again / speed
        return (halt + (rate + again) / back) / (1 - share) if share < 1 else None

    def _drive_held(self, state: State[N], status: Status, c: Contact[N], rubbing: Sequence[int]) -> N:
        """As `_drive`, with the frictions `rubbing` holding; 0 where these hold the ends of the stop."""
        held = status.with_frictions(dict.fromkeys(rubbing, STICK))
        leader = self.maker.ties(held)[0]
        if leader[c.P] == leader[c.Q] or not self.automaton._possible(self.maker.rows(held)):
            return self.kit.number(0)
        return self._drive(state, held, c.stop)

    def _halt(self, state: State[N], status: Status, i: int) -> N:
        """When a friction that slips comes to rest [s]; 0 where it gathers speed."""
        rows = self.automaton._enter(state, status)
        slip, rate = self.automaton.flow.derivatives(self.automaton._event(rows, (SLIDE, i)), 1)[:2]
        return slip / -rate if rate < 0 else self.kit.number(0)

    def _drive(self, state: State[N], status: Status, j: int) -> N:
        """Acceleration that drives the ends of an open stop together [m/s^2]."""
        rows = self.automaton._enter(state, status)
        event = self.automaton._event(rows, (STRIKE, j))
        return -self.automaton.flow.derivatives(event, 2)[2]

    def _parting(self, state: State[N], status: Status, j: int) -> int:
        """Order of the zero with which the ends of stop `j` part: 2, but where their acceleration would close
        them. That a rest ends there is known from its force alone then, and both are rounding: the first
        later derivative tells.
        """
        rows = self.automaton._enter(state, status)
        values = self.automaton.flow.derivatives(self.automaton._event(rows, (STRIKE, j)), LATEST)
        order = next((n for n in range(3, LATEST) if values[n] != 0), LATEST)
        return order if values[2] < 0 < values[order] else 2

    def _unsure(self, state: State[N], status: Status, j: int) -> N:
        """Speed that rounding of the forces may have given the ends of an open stop since t = 0 [m/s]."""
        rows = self.automaton._enter(state, status)
        event = self.automaton._event(rows, (STRIKE, j))
        bounds = TaylorRounding(self.automaton.flow, 3, state.t == 0).derivatives(event, 2)
        return bounds[2] * state.t

    def _seat(self, state: State[N], stops: Iterable[int]) -> None:
        """Take what rounding left of the depths of stops that were struck or come to rest: the ends move
        onto each other, their centre of mass stays where they move freely.
        """
        n = self.maker.n
        edges: list[Tie] = []
        for j in stops:
            stop = self.stops[j]
            depth = self.automaton._depth(stop, state)
            ends = self.maker.ends(stop)
            edges.append((0, *ends))
            if depth != 0:
                self._shift(state, Groups(n, edges[:-1]), ends, stop.sense * depth)

    def _shift(self, state: State[N], groups: Groups, ends: Edge, distance: N) -> None:
        """Move the group of P by `distance` against that of Q, shared as their masses say."""
        sides = [groups.members[groups.leader[end]] for end in ends]
        if set(sides[0]) & set(sides[1]):
            return
        zero = self.kit.number(0)
        held = [any(c >= self.maker.n for c in side) for side in sides]
        if any(held):
            shares = [zero if one else zero + 1 for one in held]
        else:
            own, other = (self._mass(side) for side in sides)
            shares = [other / (own + other), own / (own + other)]
        for side, share, sign in zip(sides, shares, (1, -1), strict=True):
            for c in side:
                if c < self.maker.n:
                    state.x[c] = self.kit.exact(state.x[c] + sign * (share * distance))

    def _mass(self, bodies: Iterable[int]) -> N:
        """Mass of bodies [kg], one by one: sum() of floats compensates from Python 3.12 on."""
        total = self.kit.number(0)
        for c in bodies:
            total = total + self.scene.bodies[c].m
        return total

    # -- what is told

    def _happened(self, touch: Touch[N]) -> Happened:
        """Impacts, blows passed on and ends of infinite sequences, by stop.

        A sequence may end at a stop that was not struck last: at e = 0 two stops that tear each other open
        are struck in turn.
        """
        happened: Happened = []
        ended = set(touch.ended)
        for j in sorted({one.stop for one in touch.passed}):
            approach = touch.before[j]
            slow = j in touch.ended and 2 * approach <= NEXT * touch.ended[j]
            if approach <= 0:
                happened.append(("transmitted", j))
                continue
            happened += [] if slow else [("impact", j)]
            if slow and touch.hop != j:
                ended.discard(j)
        return happened + [("chatter", j) for j in [*sorted(ended), *touch.faded]]

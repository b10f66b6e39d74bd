"""Ends of infinite sequences of impacts.

Resolution of time: behind an impact with the speed w, against the acceleration a that drives the ends
together, the next impact comes after 2 w / a and the last one after 2 w / (a (1 - e)), as long as a stays
what it is. The former cannot be told from now below NEXT units in the last place of t, the latter is not
worth waiting for below LAST of them; against the base, a unit is no less than the time in which a takes up
what the rounding of its angles leaves open of its velocity. Where the approach itself was as slow as that
there was no impact, but a touch that stays.

Resolution of forces: with e = 1 hops never end. Where forces cancel and rounding of what is left parts two
ends that stand, they would hop on with the speeds that rounding gave them, 1e17 times a second. So a hop no
faster than rounding of the forces can have made it since t = 0 ends in rest, in doubt.

Resolution of length: where a friction changes within a hop, the motion starts anew from rounded
displacements, and the return is lost in that where the height w^2 / (2 a) is. So the sequence ends below
LOWEST of their rounding. What it leaves out is some 1e-7 s, and is told: where a hop takes the time T, and
speeds shrink by r from one to the next, it would have lasted for another T / (1 - r). T and r are those of a
hop with the forces of its start, in which each friction turns round or holds from where it comes to rest
(`Hop`). With e = 1 the sequence ends only where these take something of it. So too where an elastic stop
closes with each hop and lets go by force within it, at e < 1: its force is next to none, and r is e.

No speed shrinks that rounded displacements have made. So hops end in rest, in doubt, where an approach was
lower than NOISE of that rounding and the stretch that led to it did not begin with the impact before.

What a run leaves out, its companion (`early`) must not leave out too, or their difference shows nothing of
it. It ends each sequence at least one whole hop before: it asks of the next hop, which is slower by r, and by
SURELY for what r does not know, what a run asks of this one; where hops shrink slowly, of one EARLY as fast.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Generic

from vibsim.engine.doubts import SLOW, name_of
from vibsim.engine.errors import State
from vibsim.engine.events.departures import DerivativeSigns
from vibsim.engine.events.impacts.impacts import ImpactLaw
from vibsim.engine.events.impacts.newton_moreau import Contact
from vibsim.engine.events.impacts.simultaneous import SimultaneousImpacts
from vibsim.engine.events.records import LAST, NEXT, ROUNDING, unit_of
from vibsim.engine.events.settling import StickSlipResolution
from vibsim.engine.flows.accelerations import accelerations
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import SLIDE, STRIKE
from vibsim.engine.modes.status import OPEN, RESTING, STICK, Status
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Scene

TURNING = 4  # times the speed of a hop: what slips faster does not turn round in it
BESIDE = 32  # of displacements: how near a stop closes to where another is struck; impacts.c asks for 64
LOWEST = 1024  # of displacements; event functions near zero are watched to some hundred
NOISE = 64  # of displacements: some times what a start and a return from rounded ones are off
EARLY = 1 / 4  # of the speed of a hop: the one that a companion asks about is no faster
SURELY = 2 / 3  # of the speed of the next hop as it is known
FURTHEST = 2.0**-10  # of the speed of a hop: none that is slower is asked about
CHANGES = 16  # of frictions within a hop that are followed


@dataclass(frozen=True)
class Hop(Generic[N]):
    """A hop with the forces of its start: how long it lasts [s], with which speed it returns [m/s]."""

    time: N
    speed: N


@dataclass
class ChatterRemainder(Generic[N]):
    """Sums of what the ends of infinite sequences of impacts left out: time [s], speed [m/s], distance
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


class Chatter(Generic[N]):
    """Ends sequences of impacts that time, forces or displacements no longer tell from rest.

    cut_off : see `ChatterRemainder`; early : whether they end at least one hop before those of a run
    """

    def __init__(
        self, scene: Scene[N], maker: RowMaker[N], settling: StickSlipResolution[N], impacts: ImpactLaw[N]
    ) -> None:
        self.scene, self.maker, self.settling, self.impacts = scene, maker, settling, impacts
        self.departures, self.relative = settling.departures, settling.relative
        self.kit, self.stops = impacts.kit, impacts.stops
        self.early = False
        zero = self.kit.number(0)
        self.cut_off = ChatterRemainder(zero, zero, zero)

    @cached_property
    def _beyond(self) -> StickSlipResolution[N]:
        """Settles what stands within hops that are only looked at: its doubts are none of the run."""
        expansion = self.departures.expansion
        departures = DerivativeSigns(self.relative, self.maker, expansion, lambda *_: None)
        departures.stopped = self.departures.stopped
        return StickSlipResolution(self.scene, self.maker, departures)

    def _doubt_speed(self, state: State[N], i: int) -> None:
        self.departures.doubt(state, SLOW, [name_of(self.scene, STRIKE, i)])

    def ends(self, state: State[N], status: Status, touch: SimultaneousImpacts[N]) -> bool:
        """Bring open stops to rest that would be struck again within the resolution of time; whether there
        are any.
        """
        chatter = False
        for c in touch.contacts:
            speed = -touch.rates[c.stop]
            if (
                status.stops[c.stop] != OPEN
                or speed == 0
                or self.impacts.governing_stop(touch, c.stop) != c.stop
            ):
                continue
            drive = self._drive(state, status, c.stop)
            if drive <= 0:
                continue
            unit, after = self._resolution(state.t, c, drive), 2 * speed / drive
            hidden, height = unit * drive, speed * after / 4
            furthest = self._ahead(self.kit.number(0))
            near = self._is_low(state, c.stop, furthest * furthest * height)
            rubbing = near and self._rubs(state, status, c, speed, after)
            hop = self._hop(state, status, c, speed) if rubbing else Hop(after, speed)
            share = c.e * (hop.speed / speed) if hop else c.e
            ahead = self._ahead(share)
            soon = ahead * after <= NEXT * unit or (c.e < 1 and ahead * after <= (1 - c.e) * (LAST * unit))
            if c.e == 1 and not soon:
                cancelled = 2 * self.velocity_uncertainty(state, status, c.stop)
                soon = 2 * speed <= NEXT * cancelled
                if soon:
                    hidden = cancelled
                    self._doubt_speed(state, c.stop)
            low = not soon and self._is_low(state, c.stop, ahead * ahead * height)
            if low and rubbing:
                soon = c.e < 1 or share < 1
            elif low and c.e < 1:
                soon = self._switches(state, status, c, speed)
            if not soon and self._is_noise(state, touch, c.stop, drive):
                soon = True
                self._doubt_speed(state, c.stop)
            if soon:
                one, shrinks = (hop.time, share) if hop else (after, c.e)
                lasting = one / (1 - shrinks) if shrinks < 1 else one
                self.cut_off.add(state.t, lasting, speed, height)
                touch.rates |= dict.fromkeys(self.impacts.coincident_stops(touch, c.stop), self.kit.number(0))
                touch.ended[c.stop] = hidden
                chatter = True
        return chatter

    def _ahead(self, share: N) -> N:
        """Speed of the hop that decides on the end, of that of the hop at hand, where the next one has the
        `share` of that.
        """
        number = self.kit.number
        if not self.early:
            return number(1)
        ahead, furthest, nearest = SURELY * share, number(FURTHEST), number(EARLY)
        return furthest if ahead < furthest else nearest if ahead > nearest else ahead

    def _resolution(self, t: N, contact: Contact[N], drive: N) -> N:
        """Uncertainty by rounding of times [s] at a stop that `drive` [m/s^2] closes."""
        kit, unit = self.kit, unit_of(self.kit, t)
        if self.maker.n + 1 not in (contact.P, contact.Q):
            return unit
        blur = kit.number(0)
        for term in self.scene.base:
            angle = kit.turn_angle(term.cycles, term.cycles_lo, t) + term.phase
            blur = blur + abs(term.amplitude * term.omega * (kit.eps * angle))
        return blur / drive if blur > unit * drive else unit

    def end_last_hop(self, state: State[N], status: Status, touch: SimultaneousImpacts[N], i: int) -> None:
        """Take a hop on stop `i` that ends in rest for the last of its sequence where rounding of velocities
        tells no approach, or none of how a plastic impact tears another stop open that would be struck next.
        """
        if touch.before[i] == 0:
            fading = [i] if 0 < self.stops[i].e < 1 else []
        else:
            fading = [j for j in touch.rates if self._torn(touch, j)] if self.stops[i].e == 0 else []
        for j in fading:
            if status.stops[i] == RESTING == status.stops[j]:
                v, c = self.impacts.velocities(state), self.impacts.contacts[j]
                opened = status
                for twin in self.impacts.coincident_stops(touch, j):
                    opened = opened.with_stop(twin, OPEN)
                drive = self._drive(state, opened, j)
                if drive > 0:
                    self._leave_out(
                        state.t, self.kit.eps * ROUNDING * (abs(v[c.P]) + abs(v[c.Q])), drive, c.e
                    )
                    touch.faded.append(j)

    def _torn(self, touch: SimultaneousImpacts[N], j: int) -> bool:
        """Whether impacts moved an end of a stop that rested, and rounding hides what came of it."""
        ends = set(self.maker.ends(self.stops[j]))
        busy = {*touch.ended, *(one.stop for one in touch.passed)}
        idle = j == self.impacts.governing_stop(touch, j) and j not in busy
        return idle and bool(ends & touch.moved) and touch.before[j] == touch.rates[j] == 0

    def _leave_out(self, t: N, speed: N, drive: N, e: N) -> None:
        """Count the hops that are left out from t [s] on, the first of which begins with a speed [m/s]."""
        after = 2 * speed / drive
        self.cut_off.add(t, after / (1 - e), speed, speed * after / 4)

    def _rubs(self, state: State[N], status: Status, contact: Contact[N], speed: N, after: N) -> bool:
        """Whether a friction at an end of a stop, or at what moves with it, slips so slowly that a hop which
        begins with a speed [m/s] turns it round, or comes to rest before the next impact, `after` [s].
        """
        ends, sides = self._hopping(status, contact), self.departures.sides(status)
        return any(
            status.frictions[i] != STICK
            and ends & set(self.maker.ends(one))
            and (
                abs(self.relative.slip(one, state, sides)) <= TURNING * speed
                or 0 < self._halt(state, status, i) <= after
            )
            for i, one in enumerate(self.scene.frictions)
        )

    def _switches(self, state: State[N], status: Status, contact: Contact[N], speed: N) -> bool:
        """Whether an elastic stop at an end of a stop, or at what moves with it, closes just where that is
        struck, and lets go by force, so that it does within each hop of a speed [m/s].
        """
        ends = self._hopping(status, contact)
        for _, stop in self.scene.elastic_stops:
            if stop.lets_go and ends & set(self.maker.ends(stop)):
                vP, vQ = self.relative.ends(stop, state, "v")
                lost = BESIDE * self.kit.eps * self.impacts.size(stop, state)
                if abs(self.relative.depth(stop, state)) <= lost and abs(vP - vQ) <= TURNING * speed:
                    return True
        return False

    def _hopping(self, status: Status, contact: Contact[N]) -> set[int]:
        """The bodies at the ends of a stop, and all that move with them."""
        leader, n = self.maker.tied(status).groups.leader, self.maker.n
        hopping = {leader[column] for column in (contact.P, contact.Q) if leader[column] < n}
        return {column for column in range(n) if leader[column] in hopping}

    def _is_low(self, state: State[N], j: int, height: N, most: int = LOWEST) -> bool:
        """Whether rounding of displacements hides a hop of some height [m]."""
        return height <= most * self.kit.eps * self.impacts.size(self.stops[j], state)

    def _is_noise(self, state: State[N], touch: SimultaneousImpacts[N], j: int, drive: N) -> bool:
        """Whether an approach to stop `j` against `drive` is one that rounded displacements have made."""
        speed = touch.before[j]
        height = speed * (speed / drive) / 2
        return speed > 0 and state.t > 0 and touch.hop != j and self._is_low(state, j, height, NOISE)

    def _hop(self, state: State[N], status: Status, c: Contact[N], speed: N) -> Hop[N] | None:
        """The hop that begins with a speed [m/s] at `state`, where forces change with the frictions of what
        hops alone; None where it does not return.
        """
        at, kit, zero = state.copy(), self.kit, self.kit.number(0)
        height, rate, time = zero, speed, zero
        for _ in range(CHANGES):
            rows = self._beyond.departures.enter(at, status)
            if rows.leader[c.P] == rows.leader[c.Q]:
                return None
            a, _ = accelerations(self.scene, kit, rows, at)
            drive = c.sense * (a[c.Q] - a[c.P])
            back = _return(kit, height, rate, drive)
            i, halt = self._next_halt(at, status, c, a)
            if i is None or (back is not None and back <= halt):
                return None if back is None else Hop(time + back, drive * back - rate)
            time, height = time + halt, height + (rate - drive * halt / 2) * halt
            rate = rate - drive * halt
            at.t, at.v[:] = at.t + halt, [v + one * halt for v, one in zip(at.v, a, strict=False)]
            status = self._beyond.settle(at, status, self._beyond.standing(status, [i]))
            if status.frictions[i] == STICK:
                self._beyond.join(at, self.maker.rows(status), i)
        return None

    def _next_halt(
        self, state: State[N], status: Status, c: Contact[N], accelerations: Sequence[N]
    ) -> tuple[int | None, N]:
        """The friction at what hops that comes to rest first with the accelerations of all columns, and after
        which time [s]; None where none does.
        """
        ends, sides = self._hopping(status, c), self.departures.sides(status)
        first, soonest = None, self.kit.number(0)
        for i, one in enumerate(self.scene.frictions):
            P, Q = self.maker.ends(one)
            sense = status.frictions[i]
            slowing = -sense * (accelerations[P] - accelerations[Q])
            if sense != STICK and ends & {P, Q} and slowing > 0:
                slip = sense * self.relative.slip(one, state, sides)
                halt = slip / slowing if slip > 0 else self.kit.number(0)
                if first is None or halt < soonest:
                    first, soonest = i, halt
        return first, soonest

    def _halt(self, state: State[N], status: Status, i: int) -> N:
        """When a friction that slips comes to rest [s]; 0 where it gathers speed."""
        event = self.departures.entered(state, status, (SLIDE, i))
        slip, rate = self.departures.expansion.derivatives(event, 1)[:2]
        return slip / -rate if rate < 0 else self.kit.number(0)

    def _drive(self, state: State[N], status: Status, j: int) -> N:
        """Acceleration that drives the ends of an open stop together [m/s^2]."""
        event = self.departures.entered(state, status, (STRIKE, j))
        return -self.departures.expansion.derivatives(event, 2)[2]

    def velocity_uncertainty(self, state: State[N], status: Status, j: int) -> N:
        """Speed that rounding of the forces may have given the ends of an open stop since t = 0 [m/s].

        Bodies that pass where their springs are slack bring the rounding of where they came from.
        """
        event = self.departures.entered(state, status, (STRIKE, j))
        return self.departures.bounds(state, event, 2)[2] * state.t


def _return(kit: Kit[N], height: N, rate: N, drive: N) -> N | None:
    """When ends at a height [m] that part at a rate [m/s] against `drive` [m/s^2] meet [s]; None where they
    do not.
    """
    square = rate * rate + 2 * drive * height
    if square < 0 or (drive <= 0 and rate >= 0):
        return None
    root = kit.sqrt(square)
    return (rate + root) / drive if rate > 0 else 2 * height / (root - rate)

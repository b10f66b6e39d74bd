"""Ends of infinite sequences of impacts.

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
it comes to rest, after s, takes from the hop as well: it returns from w s - a s^2 / 2 on at b. So too where
an elastic stop closes with each hop and lets go by force within it, at e < 1: its force is next to none, and
b is a.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Generic

from vibsim.engine.events.impacts.blows import Blows
from vibsim.engine.events.impacts.newton_moreau import Contact
from vibsim.engine.events.impacts.touch import Touch
from vibsim.engine.events.resolution import LAST, NEXT, ROUNDING, unit_of
from vibsim.engine.events.settling import Settling
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import SLIDE, STRIKE
from vibsim.engine.modes.status import OPEN, RESTING, STICK, Status
from vibsim.engine.state import State
from vibsim.physics.arithmetic.numbers import N, abs
from vibsim.physics.parts import AT_FORCE, Scene

TURNING = 4  # times the speed of a hop: what slips faster does not turn round in it
BESIDE = 32  # of displacements: how near a stop closes to where another is struck; blows.c asks for 64
LOWEST = 1024  # of displacements; event functions near zero are watched to some hundred


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


class Chatter(Generic[N]):
    """Ends sequences of impacts that time, forces or displacements no longer tell from rest.

    cut_off : see `CutOff`; lowest : see LOWEST
    """

    def __init__(self, scene: Scene[N], maker: RowMaker[N], settling: Settling[N], blows: Blows[N]) -> None:
        self.scene, self.maker, self.settling, self.blows = scene, maker, settling, blows
        self.departures, self.relative = settling.departures, settling.relative
        self.kit, self.stops = blows.kit, blows.stops
        self.lowest = LOWEST
        zero = self.kit.number(0)
        self.cut_off = CutOff(zero, zero, zero)

    def ends(self, state: State[N], status: Status, touch: Touch[N]) -> bool:
        """Bring open stops to rest that would be struck again within the resolution of time; whether there
        are any.
        """
        chatter = False
        for c in touch.contacts:
            speed = -touch.rates[c.stop]
            if status.stops[c.stop] != OPEN or speed == 0 or self.blows.foremost(touch, c.stop) != c.stop:
                continue
            drive = self._drive(state, status, c.stop)
            if drive <= 0:
                continue
            unit, after = self._resolution(state.t, c, drive), 2 * speed / drive
            hidden = unit * drive
            last = after if c.e == 1 else after / (1 - c.e)
            soon = after <= NEXT * unit or (c.e < 1 and after <= (1 - c.e) * (LAST * unit))
            if c.e == 1 and not soon:
                cancelled = 2 * self.unsure(state, status, c.stop)
                soon = 2 * speed <= NEXT * cancelled
                if soon:
                    hidden = cancelled
                    self.departures.doubt(state)
            low = not soon and self._is_low(state, c.stop, speed * after / 4)
            rubbing = self._rubbing(state, status, c, speed, after) if low else []
            if rubbing:
                lasting = self._lasting(state, status, c, rubbing, speed, drive)
                soon, last = lasting is not None, last if lasting is None else lasting
            if soon or (low and c.e < 1 and self._switches(state, status, c, speed)):
                self.cut_off.add(state.t, last, speed, speed * after / 4)
                touch.rates |= dict.fromkeys(self.blows.twins(touch, c.stop), self.kit.number(0))
                touch.ended[c.stop] = hidden
                chatter = True
        return chatter

    def _resolution(self, t: N, contact: Contact[N], drive: N) -> N:
        """What rounding leaves open of times [s] at a stop that `drive` [m/s^2] closes."""
        kit, unit = self.kit, unit_of(self.kit, t)
        if self.maker.n + 1 not in (contact.P, contact.Q):
            return unit
        blur = kit.number(0)
        for term in self.scene.base:
            angle = kit.turn_angle(term.cycles, term.cycles_lo, t) + term.phase
            blur = blur + abs(term.amplitude * term.omega * (kit.eps * angle))
        return blur / drive if blur > unit * drive else unit

    def fade(self, state: State[N], status: Status, touch: Touch[N], i: int) -> None:
        """Take a hop on stop `i` that ends in rest for the last of its sequence where rounding of velocities
        tells no approach, or none of how a plastic blow tears another stop open that would be struck next.
        """
        if touch.before[i] == 0:
            fading = [i] if 0 < self.stops[i].e < 1 else []
        else:
            fading = [j for j in touch.rates if self._torn(touch, j)] if self.stops[i].e == 0 else []
        for j in fading:
            if status.stops[i] == RESTING == status.stops[j]:
                v, c = self.blows.velocities(state), self.blows.contacts[j]
                opened = status
                for twin in self.blows.twins(touch, j):
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
        busy = {*touch.ended, *(one.stop for one in touch.passed)}
        idle = j == self.blows.foremost(touch, j) and j not in busy
        return idle and bool(ends & touch.moved) and touch.before[j] == touch.rates[j] == 0

    def _leave_out(self, t: N, speed: N, drive: N, e: N) -> None:
        """Count the hops that are left out from t [s] on, the first of which begins with a speed [m/s]."""
        after = 2 * speed / drive
        self.cut_off.add(t, after / (1 - e), speed, speed * after / 4)

    def _rubbing(self, state: State[N], status: Status, contact: Contact[N], speed: N, after: N) -> list[int]:
        """Frictions at an end of a stop, or at what moves with it, that slip so slowly that a hop which
        begins with a speed [m/s] turns them round, or come to rest before the next blow, `after` [s].
        """
        ends = self._hopping(status, contact)
        return [
            i
            for i, one in enumerate(self.scene.frictions)
            if status.frictions[i] != STICK
            and ends & set(self.maker.ends(one))
            and (
                abs(self.relative.slip(one, state)) <= TURNING * speed
                or 0 < self._halt(state, status, i) <= after
            )
        ]

    def _switches(self, state: State[N], status: Status, contact: Contact[N], speed: N) -> bool:
        """Whether an elastic stop at an end of a stop, or at what moves with it, closes just where that is
        struck, and lets go by force, so that it does within each hop of a speed [m/s].
        """
        ends = self._hopping(status, contact)
        for _, stop in self.scene.elastic_stops:
            if stop.c > 0 and stop.release == AT_FORCE and ends & set(self.maker.ends(stop)):
                vP, vQ = self.relative.ends(stop, state, "v")
                lost = BESIDE * self.kit.eps * self.blows.size(stop, state)
                if abs(self.relative.depth(stop, state)) <= lost and abs(vP - vQ) <= TURNING * speed:
                    return True
        return False

    def _hopping(self, status: Status, contact: Contact[N]) -> set[int]:
        """The bodies at the ends of a stop, and all that move with them."""
        leader, n = self.maker.ties(status)[0], self.maker.n
        hopping = {leader[column] for column in (contact.P, contact.Q) if leader[column] < n}
        return {column for column in range(n) if leader[column] in hopping}

    def _is_low(self, state: State[N], j: int, height: N) -> bool:
        """Whether rounding of displacements hides a hop of some height [m]."""
        return height <= self.lowest * self.kit.eps * self.blows.size(self.stops[j], state)

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
        if leader[c.P] == leader[c.Q] or not self.settling.possible(self.maker.rows(held)):
            return self.kit.number(0)
        return self._drive(state, held, c.stop)

    def _halt(self, state: State[N], status: Status, i: int) -> N:
        """When a friction that slips comes to rest [s]; 0 where it gathers speed."""
        rows = self.departures.enter(state, status)
        slip, rate = self.departures.flow.derivatives(self.departures.event(rows, (SLIDE, i)), 1)[:2]
        return slip / -rate if rate < 0 else self.kit.number(0)

    def _drive(self, state: State[N], status: Status, j: int) -> N:
        """Acceleration that drives the ends of an open stop together [m/s^2]."""
        rows = self.departures.enter(state, status)
        event = self.departures.event(rows, (STRIKE, j))
        return -self.departures.flow.derivatives(event, 2)[2]

    def unsure(self, state: State[N], status: Status, j: int) -> N:
        """Speed that rounding of the forces may have given the ends of an open stop since t = 0 [m/s].

        Bodies that pass where their springs are slack bring the rounding of where they came from.
        """
        rows = self.departures.enter(state, status)
        event = self.departures.event(rows, (STRIKE, j))
        return self.departures.bounds(state, event, 2)[2] * state.t

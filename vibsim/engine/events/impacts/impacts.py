"""Which rigid stops touch at an instant, and the impacts there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Generic

from vibsim.engine.doubts import ENDLESS, ORDER, name_of
from vibsim.engine.errors import EngineError, State
from vibsim.engine.events.departures import DerivativeSigns
from vibsim.engine.events.impacts.newton_moreau import (
    MOST_IMPACTS,
    NEAR,
    Contact,
    impact,
    masses,
    rate_of,
    size_of,
    unmet,
)
from vibsim.engine.events.impacts.simultaneous import SimultaneousImpacts, coincident_stops_of, hardest
from vibsim.engine.events.records import LAST, ROUNDING, unit_of
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import STRIKE
from vibsim.engine.modes.status import OPEN, RESTING, Status
from vibsim.physics.numbers import N, abs
from vibsim.physics.parts import RigidStop, Scene, Stop

IN_TURN = 32  # impacts one after the other that are tried where the order is in doubt
MOST_IN_TURN = 1024  # where rounding hides the way between two stops
NOTHING_LEFT = 2.0**-20  # of the speeds in front of these, of what has come to an end


class ImpactLaw(Generic[N]):
    """Applies the law of impacts to all rigid stops that touch."""

    def __init__(self, scene: Scene[N], maker: RowMaker[N], departures: DerivativeSigns[N]) -> None:
        self.scene, self.maker, self.kit = scene, maker, departures.kit
        self.departures, self.relative = departures, departures.relative
        self.stops = dict(scene.rigid_stops)
        self.places = {j: tuple(coincident_stops_of(scene, j)) for j in self.stops}
        ends = {j: maker.ends(stop) for j, stop in self.stops.items()}
        self.contacts = {j: Contact(j, *ends[j], stop.sense, stop.e) for j, stop in self.stops.items()}
        bodies = {j: {column for column in ends[j] if column < maker.n} for j in ends}
        self.beside = {i: {j for j in ends if bodies[i] & bodies[j]} for i in ends}  # with a common body

    def velocities(self, state: State[N]) -> list[N]:
        return list(self.relative.columns_of(state, "v"))

    def touching(self, state: State[N], status: Status, i: int) -> SimultaneousImpacts[N]:
        """The stops that rest, and those that meet stop `i` within the resolution of time and length.

        A body that was seated at one stop has moved by the rounding of that one's displacements. Stop `i` is
        met at the zero of its depth: what the state has of it tells how far rounding is off for its ends.
        """
        v, kit = self.velocities(state), self.kit
        within = LAST * unit_of(self.kit, state.t)
        off = abs(self.relative.depth(self.stops[i], state))
        contacts: list[Contact[N]] = []
        together = False
        for j, stop in self.scene.rigid_stops:
            contact, room = self.contacts[j], -self.relative.depth(stop, state)
            rate, size = rate_of(kit, contact, v), self.size(stop, state)
            beside = j != i and j in self.beside[i]
            if beside:
                size = max(size, self.size(self.stops[i], state))
            near = abs(rate) * within + ROUNDING * kit.eps * size
            if beside:
                near = near + off
            if j == i or status.stops[j] == RESTING or room <= near:
                contacts.append(contact)
            if beside and status.stops[j] == OPEN and rate > 0:
                together |= room <= NEAR * (rate * unit_of(self.kit, state.t) + kit.eps * size)
        rates = {c.stop: rate_of(kit, c, v) for c in contacts}
        return SimultaneousImpacts(contacts, dict(rates), rates, v, state.w, together)

    def size(self, stop: Stop[N] | RigidStop[N], state: State[N]) -> N:
        xP, xQ = self.relative.ends(stop, state, "x")
        return abs(xP) + abs(xQ) + abs(stop.gap)

    def strike(self, state: State[N], touch: SimultaneousImpacts[N]) -> None:
        """Impacts as long as a stop closes; the last of too many are plastic. So are those behind one that
        cannot obey its law though the bodies can stand: without room between two stops impacts follow each
        other at one instant until nothing is left of the speed.
        """
        v, w = self.velocities(state), state.w
        bodies, contacts = masses(self.scene, self.kit, state.phase, state.x), touch.contacts
        size = size_of(contacts, v)
        if touch.collapses:
            contacts = self._plastic(state, contacts)
        for count in range(MOST_IMPACTS + len(contacts)):
            if not any(rate > 0 for rate in touch.rates.values()):
                break
            if count == MOST_IMPACTS:
                contacts = self._plastic(state, contacts)
            struck, turned, passed = impact(self.kit, bodies, contacts, v, w)
            if unmet(self.kit, contacts, v, struck):
                contacts = self._plastic(state, contacts)
                struck, turned, passed = impact(self.kit, bodies, contacts, v, w)
                if unmet(self.kit, contacts, v, struck):
                    raise EngineError("crushed", state, self.names(c.stop for c in contacts))
            v, w = struck, turned
            touch.rates = {c.stop: rate_of(self.kit, c, v, size) for c in contacts}
            telling = [one for one in passed if count == 0 or touch.rates[one.stop] != 0]
            for one in telling:
                touch.rates |= dict.fromkeys(self.coincident_stops(touch, one.stop), one.after)
            contact = {c.stop: c for c in contacts}
            touch.impacts.append([(contact[one.stop], one) for one in passed])
        ends = [(c.P, c.Q) for one in touch.passed for c in contacts if c.stop == one.stop]
        touch.moved = {column for pair in ends for column in pair if column < self.maker.n}
        state.v[:] = v[: self.maker.n]
        state.w = w

    def _plastic(self, state: State[N], contacts: Sequence[Contact[N]]) -> list[Contact[N]]:
        """The stops with e = 0, which is a doubt."""
        self._doubt_impacts(state, ENDLESS, contacts)
        return [Contact(c.stop, c.P, c.Q, c.sense, self.kit.number(0)) for c in contacts]

    def names(self, stops: Iterable[int]) -> str:
        return ", ".join(sorted(self.stops[j].name for j in stops))

    def coincident_stops(self, touch: SimultaneousImpacts[N], i: int) -> list[int]:
        """The stops that touch between the ends of stop `i` and on its side, itself first: their depths are
        one.
        """
        if len(touch.contacts) == 1:
            return [i]
        one = self.contacts[i]
        ways = [(one.P, one.Q, one.sense), (one.Q, one.P, -one.sense)]
        return [i, *(c.stop for c in touch.contacts if c.stop != i and (c.P, c.Q, c.sense) in ways)]

    def governing_stop(self, touch: SimultaneousImpacts[N], i: int) -> int:
        """The hardest of the `coincident_stops` of stop `i`."""
        return hardest(self.stops, self.coincident_stops(touch, i))

    def doubt_order(self, state: State[N], status: Status, touch: SimultaneousImpacts[N], i: int) -> None:
        """Doubt an impact at stop `i` in which others take part that rounding has brought to the same
        instant, where impacts one after the other would have another outcome. Those at rest take part anyway,
        what touches at the start does so exactly, and stops at one place are always struck at once.

        One of the others that parts has just been struck: rounding hides the way of a body between two stops,
        which it is struck by in turn. Where nothing is left of its speed, the impact is plastic.
        """
        open_ones = [
            c for c in touch.contacts if c.stop not in self.places[i] and status.stops[c.stop] == OPEN
        ]
        loose = [c for c in open_ones if state.t != 0 or not self.stops[c.stop].at_start]
        if loose:
            certain = [c for c in touch.contacts if c not in loose]
            together = self._outcome(state, [touch.contacts])
            places = dict.fromkeys(self.places[c.stop] for c in loose)
            one_by_one = [[c for c in loose if c.stop in place] for place in places]
            noise = NEAR * self.kit.eps * size_of(touch.contacts, touch.v)
            for groups in ([certain, *one_by_one], [*one_by_one, certain]):
                after = self._outcome(state, groups)
                if any(abs(a - b) > noise for a, b in zip(together, after, strict=True)):
                    self._doubt_impacts(state, ORDER, touch.contacts)
            parting = [c for c in loose if c.stop in self.beside[i] and touch.rates[c.stop] < 0]
            touch.collapses = bool(parting) and self._comes_to_nothing(state, [certain, *one_by_one])

    def _doubt_impacts(self, state: State[N], reason: str, contacts: Iterable[Contact[N]]) -> None:
        self.departures.doubt(state, reason, (name_of(self.scene, STRIKE, c.stop) for c in contacts))

    def _comes_to_nothing(self, state: State[N], groups: Sequence[Sequence[Contact[N]]]) -> bool:
        """Whether impacts at groups of stops one after the other, between which there is no way, take all
        speeds that the stops have.
        """
        contacts = [c for group in groups for c in group]
        before = max(abs(rate_of(self.kit, c, self.velocities(state))) for c in contacts)
        after = self._outcome(state, groups, MOST_IN_TURN)
        return all(abs(rate_of(self.kit, c, after)) <= NOTHING_LEFT * before for c in contacts)

    def _outcome(
        self, state: State[N], groups: Sequence[Sequence[Contact[N]]], most: int = IN_TURN
    ) -> list[N]:
        """Velocities behind impacts at groups of stops, one group after the other, as long as one closes;
        `most` of them.
        """
        v, w = self.velocities(state), state.w
        bodies = masses(self.scene, self.kit, state.phase, state.x)
        size = size_of([c for group in groups for c in group], v)
        for _ in range(most):
            closing = [g for g in groups if any(rate_of(self.kit, c, v, size) > 0 for c in g)]
            if not closing:
                break
            v, w, _ = impact(self.kit, bodies, closing[0], v, w)
        return v

"""Transitions where rigid stops touch: impacts, rest, and the end of infinite sequences of impacts.

Within one instant, in this order: the law of impacts over all rigid stops that touch, again as long as one of
them still closes; frictions and damped stops as the new velocities say; what is at rest sticks, rests or
parts as the accelerations say. A stop that would be struck again within the resolution of time is at the end
of such a sequence and comes to rest.
"""

from __future__ import annotations

from collections.abc import Container
from typing import Generic

from vibsim.engine.doubts import SLOW, START_AT_REST, TOUCHED, called, name_of
from vibsim.engine.errors import EngineError, State
from vibsim.engine.events.departures import TouchingParts
from vibsim.engine.events.impacts.chatter import Chatter
from vibsim.engine.events.impacts.impacts import ImpactLaw
from vibsim.engine.events.impacts.newton_moreau import rate_of, size_of
from vibsim.engine.events.impacts.simultaneous import RestProjection, SimultaneousImpacts
from vibsim.engine.events.records import NEXT, ROUNDING, Happened, Taken, changes
from vibsim.engine.events.settling import StickSlipResolution
from vibsim.engine.flows.base_motion import belt_velocity
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import CLEARANCE, GAP, PUSH, SLIDE, STRIKE, Event, Known
from vibsim.engine.modes.status import BACKWARD, CONTACT, FORWARD, LIFTED, OPEN, RESTING, STICK, Status
from vibsim.physics.numbers import N, abs
from vibsim.physics.parts import Scene, Stop

LATEST = 6  # derivative of a depth that is consulted where rounding hides those before it


class RigidStops(Generic[N]):
    """Decides what rigid stops do.

    touch : what the event taken last was
    """

    def __init__(
        self, scene: Scene[N], maker: RowMaker[N], settling: StickSlipResolution[N], parting: TouchingParts[N]
    ) -> None:
        self.scene, self.maker, self.settling, self.parting = scene, maker, settling, parting
        self.departures, self.relative, self.kit = settling.departures, settling.relative, settling.kit
        self.impacts = ImpactLaw(scene, maker, self.departures)
        self.chatter = Chatter(scene, maker, settling, self.impacts)
        self.rest_projection = RestProjection(scene, maker, self.relative)
        self.stops = self.impacts.stops
        self.frictions = len(scene.frictions)
        self.touch: SimultaneousImpacts[N] | None = None

    def meet(self, state: State[N], status: Status, i: int, hop: bool = False) -> Taken:
        """Transition where stop `i` touches, as `Automaton.take`: (status, what happened, known zeros).

        hop : whether the last impact on it was where the stretch began
        """
        self._carry(state, status)
        touch = self.impacts.touching(state, status, i)
        i = self.impacts.governing_stop(touch, i)
        touch.hop = i if hop else None
        self.impacts.doubt_order(state, status, touch, i)
        self.impacts.strike(state, touch)
        bounds = self._bounds(state, touch)
        after, lifts = self._lifted(state, self._turned(state, status, touch), touch, bounds[0])
        settled = self._settled(state, after, touch)
        while self.chatter.ends(state, settled, touch):
            settled = self._settled(state, after, touch)
        if touch.hop is not None:
            self.chatter.end_last_hop(state, settled, touch, i)
        resting = [j for j in touch.rates if status.stops[j] == OPEN != settled.stops[j]]
        self.rest_projection.project(state, sorted({*resting, *(one.stop for one in touch.passed)}))
        for k, (old, new) in enumerate(zip(status.frictions, settled.frictions, strict=True)):
            if old != STICK == new:
                self.settling.join(state, self.maker.rows(settled), k)
        self.touch = touch
        known = self._forgotten(touch, after)
        changed = changes(status, settled, known)
        settled, begun = self.parting.touching(state, status, settled, bounds, 1, known)
        opened = {j for j in touch.rates if status.stops[j] == RESTING}
        struck = {i, *(one.stop for one in touch.passed)}
        for j in {*opened, *(twin for one in struck for twin in self.impacts.coincident_stops(touch, one))}:
            if settled.stops[j] == OPEN:
                known[STRIKE, j] = self._parting_order(state, settled, j) if touch.rates[j] == 0 else 1
        for j, rate in touch.rates.items():
            torn = rate < 0 and touch.moved & set(self.maker.ends(self.stops[j]))
            if torn and settled.stops[j] == OPEN and self.relative.depth(self.stops[j], state) == 0:
                known[STRIKE, j] = 1  # whatever order it was of in front of the impact
        return settled, [*self._happened(touch), *lifts, *changed, *begun], known

    def _carry(self, state: State[N], status: Status) -> None:
        """Give what rests or sticks on the base its velocity, which that of the stretch has but for rounding:
        where an impact meets them, they do not close.
        """
        leader = self.maker.tied(status).groups.leader
        carried = [c for c in range(self.maker.n) if leader[c] == self.maker.n + 1]
        if carried:
            base, drift = self.relative.base(state, "v"), self.settling.drift(status, state)
            for c in carried:
                state.v[c] = base + drift[c]

    def touch_again(self, state: State[N], status: Status, event: Event[N], order: int) -> Taken | None:
        """Transition where a stop touches whose ends parted with a zero of `order` above 1: none where
        rounding of that brought them back, and a rest, in doubt, where a plastic one closes no faster than
        rounding of the forces can have made it. None of others, which are met.
        """
        i = event.part
        touch = self.impacts.touching(state, status, i)
        crossing, at = self.departures.crossing(state, status, event.key, order)
        if crossing <= 0:
            self.touch = touch
            return status, [], {event.key: at}
        after = status.with_stop(i, RESTING)
        slow = self.stops[i].e == 0 and touch.rates[i] <= self.chatter.velocity_uncertainty(state, status, i)
        if not slow or not self.settling.possible(after):
            return None
        self.departures.doubt(state, SLOW, [name_of(self.scene, STRIKE, i)])
        touch.catches += self.rest_projection.join(state, [i])
        self.rest_projection.project(state, [i])
        self.touch = touch
        return after, [("rest_begin", i)], {}

    def at_start(self, state: State[N], met: Container[int]) -> tuple[dict[int, bool], list[int]]:
        """Of the stops `met` at the start: ({stop: whether it parts} for those that do not close, those that
        neither close nor part). One that closes is struck at once.
        """
        parting: dict[int, bool] = {}
        standing: list[int] = []
        for j, _ in self.scene.rigid_stops:
            if j in met:
                rate = rate_of(self.kit, self.impacts.contacts[j], self.impacts.velocities(state))
                turned = self.relative.turned_by_base(self.stops[j], rate, state.t)
                if turned:
                    self.departures.doubt(state, START_AT_REST, [called("stop", self.stops[j])])
                if turned or rate == 0:
                    standing.append(j)
                if turned or rate <= 0:
                    parting[j] = rate < 0 and not turned
        if standing:
            self.rest_projection.join(state, standing)
            self.rest_projection.project(state, standing)
        return parting, standing

    def _forgotten(self, touch: SimultaneousImpacts[N], status: Status) -> Known:
        """Zeros of functions of velocities that impacts have changed: none any more, but for what stands."""
        known: Known = {}
        for i, friction in enumerate(self.scene.frictions):
            if touch.moved & set(self.maker.ends(friction)) and status.frictions[i] != STICK:
                known[SLIDE, i] = 0
        for i, stop in self.scene.elastic_stops:
            if touch.moved & set(self.maker.ends(stop)):
                known[PUSH, i] = 0
        return known

    def _turned(self, state: State[N], status: Status, touch: SimultaneousImpacts[N]) -> Status:
        """The status with the frictions of the columns that impacts moved as the velocities say."""
        v, size = self.impacts.velocities(state), size_of(touch.contacts, touch.v)
        turned: dict[int, int] = {}
        sides = self.departures.sides(status)
        for i, friction in enumerate(self.scene.frictions):
            P, Q = self.maker.ends(friction)
            if touch.moved & {P, Q}:
                slip = (v[P] - v[Q]) - belt_velocity(friction, self.kit, state.t, sides)
                own = abs(v[P]) + abs(v[Q]) + abs(friction.belt)
                noise = ROUNDING * self.kit.eps * (own if own > size else size)
                turned[i] = STICK if abs(slip) <= noise else FORWARD if slip > 0 else BACKWARD
        return status.with_frictions(turned)

    def _bounds(self, state: State[N], touch: SimultaneousImpacts[N]) -> tuple[list[int], list[int]]:
        """The elastic stops and the clearances whose ends just touch and are moved by impacts: in doubt
        behind the start, where rounding may have brought them there.
        """
        elastic = ((i, stop) for i, stop in self.scene.elastic_stops if i not in self.maker.guarded)
        stops, clearances = self.relative.touched(
            state,
            [i for i, stop in elastic if touch.moved & set(self.maker.ends(stop))],
            [i for i, one in enumerate(self.scene.clearances) if touch.moved & set(self.maker.ends(one))],
        )
        if (stops or clearances) and state.t != 0:
            kinds = [*((GAP, i) for i in stops), *((CLEARANCE, i) for i in clearances)]
            self.departures.doubt(state, TOUCHED, (name_of(self.scene, *one) for one in kinds))
        return stops, clearances

    def _lifted(
        self, state: State[N], status: Status, touch: SimultaneousImpacts[N], bounds: Container[int]
    ) -> tuple[Status, Happened]:
        """The status with the damped stops that let go at zero force as the velocities say, and the elastic
        stops `bounds`, whose ends just touch, in contact where they close; what happened to the former.
        """
        happened: Happened = []
        for i, stop in self.scene.elastic_stops:
            pressed = stop.lets_go and status.stops[i] != OPEN
            if i in bounds:
                status = status.with_stop(i, CONTACT if self.relative.closing(stop, state) > 0 else OPEN)
            elif pressed and touch.moved & set(self.maker.ends(stop)):
                pushes = self._pushes(state, status, i, stop)
                after = CONTACT if pushes else LIFTED
                if after != status.stops[i]:
                    happened.append(("contact_begin" if pushes else "contact_end", i))
                status = status.with_stop(i, after)
        return status, happened

    def _pushes(self, state: State[N], status: Status, i: int, stop: Stop[N]) -> bool:
        """Whether elastic stop number `i`, which lets go by force, pushes at its depth."""
        if stop.force is not None:
            return not self.departures.pulls(state, status.with_stop(i, CONTACT), stop, i)
        (vP, vQ), depth = self.relative.ends(stop, state, "v"), self.relative.depth(stop, state)
        return bool(stop.k * depth - stop.c * (stop.sense * (vP - vQ)) >= 0)

    def _settled(self, state: State[N], status: Status, touch: SimultaneousImpacts[N]) -> Status:
        """The status in which all that stands sticks, rests or parts consistently; tied bodies get their
        common velocities.
        """
        rests = {self.frictions + j: STICK if rate == 0 else FORWARD for j, rate in touch.rates.items()}
        status = status.with_ties(rests)
        seated = [k - self.frictions for k in status.tied if k >= self.frictions]
        touch.catches += self.rest_projection.join(state, seated)
        standing = self.settling.standing(status)
        settled = self.settling.settle(state, status, standing) if standing else status
        if RESTING in settled.stops and not self.settling.possible(settled):
            resting = (j for j in self.stops if settled.stops[j] == RESTING)
            raise EngineError("crushed", state, self.impacts.names(resting))
        return settled

    def _happened(self, touch: SimultaneousImpacts[N]) -> Happened:
        """Impacts, also those passed on and ends of infinite sequences, by stop.

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

    def _parting_order(self, state: State[N], status: Status, j: int) -> int:
        """Order of the zero with which the ends of stop `j` part: 2, but where their acceleration would close
        them. That a rest ends there is known from its force alone then, and both are rounding: the first
        later derivative tells.
        """
        event = self.departures.entered(state, status, (STRIKE, j))
        values = self.departures.expansion.derivatives(event, LATEST)
        order = next((n for n in range(3, LATEST) if values[n] != 0), LATEST)
        return order if values[2] < 0 < values[order] else 2

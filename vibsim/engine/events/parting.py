"""Elastic stops and clearances that tied ends just touch, and that part or close where the tie lets go.

Their functions rest at zero while the tie holds. Behind the release they have a zero of order 3, as the
motion itself, or of order 2 where a force jumps there.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.events.departures import DerivativeSigns
from vibsim.engine.events.records import Happened
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.rows import CLEARANCE, GAP, PUSH, Known
from vibsim.engine.modes.status import CONTACT, KEPT, OPEN, VIOLATED, Status
from vibsim.physics.numbers import N
from vibsim.physics.parts import Clearance, Scene, Stop


class TouchingParts(Generic[N]):
    """Decides which of these part and which close."""

    def __init__(self, scene: Scene[N], maker: RowMaker[N], departures: DerivativeSigns[N]) -> None:
        self.scene, self.maker, self.departures = scene, maker, departures
        self.relative, self.elastic = departures.relative, dict(scene.elastic_stops)

    def parted(
        self, state: State[N], status: Status, after: Status, order: int, known: Known
    ) -> tuple[Status, Happened]:
        """As `touching`, behind the release of ties, for the parts that the tied ends just touched."""
        parts = self.touched(state, *released_parts(self.maker, status, after))
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
            closes = self.departures.departure(state, after.with_stop(i, OPEN), (GAP, i), order)[0] < 0
            after = after.with_stop(i, CONTACT if closes else OPEN)
            known |= {(GAP, i): order, (PUSH, i): order - 1}
            if status.stops[i] != after.stops[i]:
                happened.append(("contact_begin" if closes else "contact_end", i))
        for i in parts[1]:
            closes = (
                self.departures.departure(state, after.with_clearance(i, KEPT), (CLEARANCE, i), order)[0] < 0
            )
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
            [i for i, one in near if self.relative.met(one, self.relative.depth(one, state), state, one.gap)],
            [
                i
                for i, one in limits
                if self.relative.met(one, self.relative.excess(one, state), state, one.distance)
            ],
        )


def released_parts(maker: RowMaker[N], before: Status, behind: Status) -> tuple[list[int], list[int]]:
    """The numbers of the elastic stops and of the clearances whose ends are tied in the mode `before` and not
    in the one `behind`.
    """
    tied, loose = maker.ties(before)[0], maker.ties(behind)[0]

    def parts(one: Stop[N] | Clearance[N]) -> bool:
        P, Q = maker.ends(one)
        return tied[P] == tied[Q] and loose[P] != loose[Q]

    stops = [i for i, stop in maker.scene.elastic_stops if i not in maker.guarded and parts(stop)]
    return stops, [i for i, one in enumerate(maker.scene.clearances) if parts(one)]

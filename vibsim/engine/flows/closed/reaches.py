"""How far the close measure of rounding may at most be above a few times the plain one (see `rounding.py`).

Whatever the time, a release C swings by 3 at the most, an impulse response S by 4 / w0 and a harmonic
response by (5 + 4 omega / w0) / |Z|, and their rates by some times more, the sum of all rates. So the bound
is a sum over what the segment starts from, of which each mode knows the weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic

from vibsim.engine.flows.closed.modal import Modal
from vibsim.engine.flows.closed.responses import UNHURRIED, Oscillator
from vibsim.engine.modes.rows import ACCELERATION, COUPLING, DIFFERENCE, RATE, Event, ModeRows, Term
from vibsim.physics.arithmetic.numbers import Kit, N, abs

if TYPE_CHECKING:
    from vibsim.engine.flows.closed.closed_form import Constants

FASTER = 4  # times the sum of all rates: how much further a rate swings


@dataclass
class Reach(Generic[N]):
    """place * X + speed * V + rest, X and V the summed magnitudes of displacements and velocities of all
    columns at the start of a segment.
    """

    place: N
    speed: N
    rest: N

    def plus(self, factor: N | int, other: Reach[N]) -> Reach[N]:
        """This and `factor` times another."""
        place, speed = self.place + factor * other.place, self.speed + factor * other.speed
        return Reach(place, speed, self.rest + factor * other.rest)


Reaches = tuple[Reach[N], Reach[N], Reach[N]]  # of a coordinate, its rate and its acceleration


def reaches_of(kit: Kit[N], constants: Constants[N]) -> Reaches[N]:
    """The reaches of a coordinate.

    Where its own terms cancel, plain may be as small as it likes while the coordinate grows without end: of a
    free mass with its velocity, under a load that is a sum, and in resonance. There nothing is told.
    """
    coordinate, osc, zero = constants.coordinate, constants.oscillators[0], kit.number(0)
    always = kit.number(UNHURRIED)
    start = shifts = longest = driven = terms = zero
    for _, weight in coordinate.sources:
        start = start + abs(weight)
    for factor, plus, minus in coordinate.shifts:
        shifts = shifts + abs(factor) * (len(plus) + len(minus))
    held, pace = osc.w0 > 0, osc.w0 + 2 * osc.a
    if not coordinate.free:
        longest = 4 / osc.w0 if held else 1 / (2 * osc.a)
    cancels = resonates = False
    for i, h in enumerate(constants.driven):
        osc, size = constants.oscillators[i], coordinate.sizes[h]
        pace = pace + osc.omega
        driven = driven + size * _response(osc, longest)
        terms = terms + size
        cancels = cancels or size > 2 * (abs(coordinate.sines[h]) + abs(coordinate.cosines[h]))
        resonates = resonates or osc.zz == 0
    steady = 4 * osc.per_b
    q = Reach(start + shifts * steady, start * longest, coordinate.load_size * steady + driven)
    u = Reach(zero, 9 * start, zero).plus(FASTER * pace, q)
    a = Reach(shifts, zero, coordinate.load_size + terms).plus(FASTER * pace, u)
    wanders = coordinate.free and len(coordinate.sources) > 1
    if cancels or (not held and (wanders or coordinate.load_size > 2 * abs(coordinate.load))):
        q.rest = always
    if cancels:
        u.rest = always
    if cancels or resonates:
        a.rest = always
    return q, u, a


def _response(osc: Oscillator[N], longest: N) -> N:
    """Bound of the terms of H [s^2], where it is a quotient."""
    return (5 + osc.omega * longest) * (abs(osc.inverse_r) + abs(osc.inverse_i))


class EventReaches(Generic[N]):
    """Reaches of event functions of a mode."""

    def __init__(
        self, kit: Kit[N], rows: ModeRows[N], modal: Modal[N], reaches: Sequence[Reaches[N]]
    ) -> None:
        self.kit, self.rows, self.modal, self.reaches = kit, rows, modal, reaches

    def of(self, event: Event[N]) -> Reach[N]:
        """The reach of an event function."""
        zero = self.kit.number(0)
        total = Reach(zero, zero, zero)
        for term in event.terms:
            total = total.plus(abs(term.coefficient), self._term(term))
        return total

    def _term(self, term: Term[N]) -> Reach[N]:
        if term.kind == DIFFERENCE:
            return self._shares(self.modal.pairs[term.P, term.Q].terms, 0)
        if term.kind == RATE:
            return self._shares(self.modal.pairs[term.P, term.Q].terms, 1)
        if term.kind == COUPLING:
            one = self.rows.couplings[term.P]
            shares = self.modal.pairs[one.P, one.Q].terms
            stretched = self._shares([], 0).plus(one.k, self._shares(shares, 0))
            return stretched.plus(one.c, self._shares(shares, 1))
        if term.kind == ACCELERATION:
            return self._shares(list(self.modal.places[term.P].shape.items()), 2)
        return self._shares([], 0)

    def _shares(self, shares: Sequence[tuple[int, N | int]], order: int) -> Reach[N]:
        zero = self.kit.number(0)
        total = Reach(zero, zero, zero)
        for m, share in shares:
            total = total.plus(abs(share), self.reaches[m][order])
        return total

"""How far the close measure of rounding may at most be above a few times the plain one (see `rounding.py`).

Whatever the time, a release C swings by 3 at the most, an impulse response S by 4 / w0 and a harmonic
response by (5 + 4 omega / w0) / |Z|, and their rates by some times more, the sum of all rates. So the bound
is a sum over what the segment starts from, of which each mode knows the weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic

from vibsim.engine.errors import State
from vibsim.engine.flows.closed.closed_form_search import FLAT_ORDER
from vibsim.engine.flows.closed.modal import Modal
from vibsim.engine.flows.closed.responses import UNHURRIED, Oscillator
from vibsim.engine.modes.rows import (
    ACCELERATION,
    COUPLING,
    DIFFERENCE,
    RATE,
    Coupling,
    Event,
    Known,
    ModeRows,
    Term,
)
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.engine.flows.closed.closed_form import ClosedForm, Constants


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


# Zeros too flat for the closed form, of event functions with more zero derivatives than that takes.
#
# At the end of a chain whose other end is driven every body between makes two more derivatives zero. In
# Taylor series they are exactly zero; in modal coordinates rounding stands in for them.


def leaves_flat(closed: ClosedForm[N], state: State[N], rows: ModeRows[N], known: Known) -> bool:
    """Whether an event function may leave zero with more zero derivatives than the closed form takes."""
    if closed.dimension(rows) <= FLAT_ORDER:
        return False
    return any(
        known.get(event.key, 0) >= FLAT_ORDER or _rests_at_zero(event, rows, state, closed.scene)
        for event in rows.events
    )


def _rests_at_zero(event: Event[N], rows: ModeRows[N], state: State[N], scene: Scene[N]) -> bool:
    """Whether an event function is zero because all that it is made of stands still."""
    total = state.t - state.t
    for term in event.terms:
        value: N | None = None
        if term.kind == COUPLING:
            value = _still_force(rows.couplings[term.P], state)
        elif term.kind == DIFFERENCE:
            value = _still_distance(state, term.P, term.Q)
        elif term.kind == ACCELERATION and _is_left_alone(rows, rows.leader[term.P], state, scene):
            continue
        if value is None:
            return False
        total = total + term.coefficient * value
    return bool(event.terms) and total + event.constant == 0


def _is_left_alone(rows: ModeRows[N], leader: int, state: State[N], scene: Scene[N]) -> bool:
    """Whether no force acts on a group, nor begins to."""
    leaders, n = rows.leader, len(state.x)
    if leader >= n:
        return leader == n
    if any(leaders[force.on] == leader for force in scene.forces):
        return False
    if any(leaders[column] == leader for column, _ in rows.constants):
        return False
    return all(
        _still_force(one, state) == 0 for one in rows.couplings if leader in (leaders[one.P], leaders[one.Q])
    )


def _still_force(one: Coupling[N], state: State[N]) -> N | None:
    """The force of a coupling whose ends move alike; None of others."""
    apart = _still_distance(state, one.P, one.Q)
    return None if apart is None else one.k * apart + one.offset


def _still_distance(state: State[N], P: int, Q: int) -> N | None:
    """x_P - x_Q of two columns that move alike; None of others, and of the base."""
    n = len(state.x)
    if n < P or n < Q:
        return None
    zero = state.t - state.t
    (xP, vP), (xQ, vQ) = ((state.x[c], state.v[c]) if c < n else (zero, zero) for c in (P, Q))
    return xP - xQ if vP == vQ else None

"""The event functions of the closed-form flow: derivatives, bounds of them ahead, and rounding bounds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Generic

from vibsim.engine.modes.rows import ACCELERATION, COUPLING, DIFFERENCE, LOAD, RATE, Acceleration, Event, Term
from vibsim.physics.numbers import N, abs, total_of
from vibsim.physics.parts import Harmonic

if TYPE_CHECKING:
    from vibsim.engine.flows.closed.closed_form import ClosedForm
    from vibsim.engine.flows.closed.rounding import Scales


class EventFunctions(Generic[N]):
    """Event functions of a `ClosedForm` flow at the point that it evaluated last; call `here` first."""

    def __init__(self, flow: ClosedForm[N]) -> None:
        self.flow, self.kit = flow, flow.kit

    def here(self, count: int) -> None:
        """Take the derivatives of the coordinates up to order `count`."""
        self.jets = self.flow.jets(count)
        self.count = count
        self.base = self.flow.base_jet(count) if self.flow.scene.base else []

    def difference(self, P: int, Q: int, n: int) -> N:
        """n-th derivative of x_P - x_Q."""
        pair = self.flow.modal.pairs[P, Q]
        total = None  # a loop of its own: events are looked for by many of these
        for m, coefficient in pair.terms:
            part = coefficient * self.jets[m][n]
            total = part if total is None else total + part
        total = self.kit.number(0) if total is None else total
        if n == 0:
            for sign, c in pair.fixed:
                total = total + sign * self.flow.x0[c]
        return total + pair.base * self.base[n] if pair.base else total

    def derivative(self, event: Event[N], n: int) -> N:
        """n-th time derivative of an event function, n >= 0."""
        if n > 0 and event.slope:
            return self.kit.exact(total_of(self.kit, [self._slope(one, n) for one in event.slope]))
        value = self._sum(event.terms, n)
        return self.kit.exact(value + event.constant if n == 0 else value)

    def _slope(self, one: Acceleration[N], n: int) -> N:
        force = self._sum(one.terms, n - 1)
        if n == 1:
            for constant in one.constants:
                force = force + constant
        return one.factor * force / one.mass

    def _sum(self, terms: Iterable[Term[N]], n: int) -> N:
        total = None  # a loop, as above
        for term in terms:
            part = term.coefficient * self._term(term, n)
            total = part if total is None else total + part
        return self.kit.number(0) if total is None else total

    def _term(self, term: Term[N], n: int) -> N:
        if term.kind == DIFFERENCE:
            return self.difference(term.P, term.Q, n)
        if term.kind == RATE:
            return self.difference(term.P, term.Q, n + 1)
        if term.kind == COUPLING:
            one = self.flow.rows.couplings[term.P]
            force = one.k * self.difference(one.P, one.Q, n) + one.c * self.difference(one.P, one.Q, n + 1)
            return force + one.offset if n == 0 else force
        if term.kind == LOAD:
            return self.flow.load_jet(term.P, n)[n]
        return self._column(term.P, n + 2)

    def _column(self, c: int, n: int) -> N:
        """n-th derivative of x_c, n > 0."""
        place = self.flow.modal.places[c]
        total = self.base[n] if place.base else self.kit.number(0)
        for m, share in place.shape.items():
            total = total + share * self.jets[m][n]
        return total

    def bound(self, event: Event[N], n: int, reach: N) -> N:
        """Bound of the absolute n-th derivative of an event function up to `reach` ahead [s], n >= 2."""
        if event.slope:
            bounds = [self._bound_of_sum(one.terms, n - 1, reach) for one in event.slope]
            slopes = zip(event.slope, bounds, strict=True)
            return total_of(self.kit, (abs(one.factor) * bound / one.mass for one, bound in slopes))
        return self._bound_of_sum(event.terms, n, reach)

    def _bound_of_sum(self, terms: Iterable[Term[N]], n: int, reach: N) -> N:
        bounds = [abs(term.coefficient) * self._bound_of_term(term, n, reach) for term in terms]
        return total_of(self.kit, bounds)

    def _bound_of_term(self, term: Term[N], n: int, reach: N) -> N:
        if term.kind == DIFFERENCE:
            return self._bound_of_difference(term.P, term.Q, n, reach)
        if term.kind == RATE:
            return self._bound_of_difference(term.P, term.Q, n + 1, reach)
        if term.kind == COUPLING:
            one = self.flow.rows.couplings[term.P]
            force = one.k * self._bound_of_difference(one.P, one.Q, n, reach)
            return force + one.c * self._bound_of_difference(one.P, one.Q, n + 1, reach)
        if term.kind == LOAD:
            forces = [force for force in self.flow.scene.forces if force.on == term.P]
            return self._bound_of_harmonics([t for force in forces for t in force.terms], n)
        place = self.flow.modal.places[term.P]
        total = self._bound_of_harmonics(self.flow.scene.base, n + 2) if place.base else self.kit.number(0)
        for m, share in place.shape.items():
            total = total + abs(share) * self._bound_of_coordinate(m, n + 2, reach)
        return total

    def _bound_of_harmonics(self, terms: Iterable[Harmonic[N]], n: int) -> N:
        total = self.kit.number(0)
        for term in terms:
            size = abs(term.amplitude)
            for _ in range(n):
                size = size * term.omega
            total = total + size
        return total

    def _bound_of_difference(self, P: int, Q: int, n: int, reach: N) -> N:
        pair = self.flow.modal.pairs[P, Q]
        bounds = [abs(coefficient) * self._bound_of_coordinate(m, n, reach) for m, coefficient in pair.terms]
        total = total_of(self.kit, bounds)
        return total + self._bound_of_harmonics(self.flow.scene.base, n) if pair.base else total

    def _bound_of_coordinate(self, m: int, n: int, reach: N) -> N:
        """Bound of |q^(n)| up to `reach` ahead.

        q^(n) obeys the same oscillator: its free part stays below both the energy and the ballistic bound,
        the forced part below |R| omega^n reach^2 / 2 because |S(t)| <= t.
        """
        constants = self.flow.modal.constants[m]
        d, w0 = self.jets[m], constants.oscillators[0].w0
        value, rate = d[n], d[n + 1]
        size = abs(value) + abs(rate) * reach
        if w0 > 0:
            energy = abs(value) + abs(rate) / w0
            if energy < size:
                size = energy
        return size + constants.forced[n] * (reach * reach)

    @property
    def unit(self) -> N:
        """Rounding of an event function in units of its scale."""
        return self.kit.eps * (16 + self.flow.modal.pace * self.flow.tau)

    def scale(self, event: Event[N], scales: Scales[N]) -> N:
        """Scale of the rounding of an event function, from those of the coordinates."""
        total = None
        for term in event.terms:
            part = abs(term.coefficient) * self._scale(term, scales)
            total = part if total is None else total + part
        return event.size if total is None else total + event.size

    def _scale(self, term: Term[N], scales: Scales[N]) -> N:
        flow = self.flow
        if term.kind == DIFFERENCE:
            return self._scale_of_difference(term.P, term.Q, scales.q, True)
        if term.kind == RATE:
            return self._scale_of_difference(term.P, term.Q, scales.u, False)
        if term.kind == COUPLING:
            one = self.flow.rows.couplings[term.P]
            force = one.k * self._scale_of_difference(one.P, one.Q, scales.q, True)
            return force + one.c * self._scale_of_difference(one.P, one.Q, scales.u, False) + abs(one.offset)
        if term.kind == LOAD:
            forces = [force for force in flow.scene.forces if force.on == term.P]
            total = self._bound_of_harmonics([t for force in forces for t in force.terms], 0)
            for load in forces:
                total = total + abs(load.constant)
            return total
        return self._scale_of_acceleration(term, scales.a)

    def _scale_of_acceleration(self, term: Term[N], scales: Sequence[N] | None) -> N:
        if scales is None:
            return self._bound_of_term(term, 0, self.flow.modal.window)
        place = self.flow.modal.places[term.P]
        total = self._bound_of_harmonics(self.flow.scene.base, 2) if place.base else self.kit.number(0)
        for m, share in place.shape.items():
            total = total + abs(share) * scales[m]
        return total

    def _scale_of_difference(self, P: int, Q: int, scales: Sequence[N], places: bool) -> N:
        pair = self.flow.modal.pairs[P, Q]
        total = total_of(self.kit, [abs(coefficient) * scales[m] for m, coefficient in pair.terms])
        if places:
            for _, c in pair.fixed:
                total = total + abs(self.flow.x0[c])
        if not pair.base:
            return total
        return total + self._bound_of_harmonics(self.flow.scene.base, 0 if places else 1)


def reaches(event: Event[N]) -> int:
    """How many orders above its own an event function reads."""
    kinds = {term.kind for term in event.terms}
    kinds |= {term.kind for one in event.slope for term in one.terms}
    return 2 if ACCELERATION in kinds else 1 if kinds & {RATE, COUPLING, LOAD} else 0

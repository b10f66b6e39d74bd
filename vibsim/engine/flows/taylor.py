"""The Taylor flow: any mode, polynomials of high order from step to step.

Inside a mode the motion is analytic and its Taylor coefficients follow by recurrence from the balance of
forces of each group of bodies. One step gives the state to round-off and a polynomial that is the dense
output and carries the event search.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from typing import Generic

from vibsim.engine.errors import EngineError, State
from vibsim.engine.events.records import Certificate, latest_zero, may_vanish_by
from vibsim.engine.events.root_finding import PolynomialSearch
from vibsim.engine.flows.motion import Advance
from vibsim.engine.flows.tape import POWER, Inputs, Tape, TapeSeries, TapeValues
from vibsim.engine.flows.taylor_expansion import TaylorExpansion
from vibsim.engine.ledger_integrals import LedgerIntegrals, QuadratureNode
from vibsim.engine.modes.rows import (
    ACCELERATION,
    COUPLING,
    DIFFERENCE,
    FORMULA,
    HOLD,
    RATE,
    STRIKE,
    Event,
    Known,
    ModeRows,
    Term,
)
from vibsim.physics.elementary import EIGHT, TWELVE, Quadrature
from vibsim.physics.numbers import Kit, N, abs, horner, sizes_at
from vibsim.physics.parts import Force, Scene

# A step of order 20 at full tolerance takes at most 1.32 rad of the fastest rate (h^20 / 20! = 2^-53): there
# eight nodes miss 5e-17 of the power of a velocity, (2 h)^16 (8!)^4 / (2 * 17 (16!)^3); 3e-15 at order 22.
EIGHT_NODES_ORDER = 20


SHORTENINGS = 400  # of a step, each at least by
LEAST_SHORTENING = 0.25  # binary digits
SHORT_CONTACT = 16.0  # binary digits by which a step is too long that ends behind a contact that it begins
BEYOND_ALL = 60.0  # binary digits by which a value that is no number is beyond
NEARER = 0.75  # of a step, where formulas are compared as well
INPUT_ROUNDING = 2  # of displacements and velocities at the end of a step, in units of eps


class Taylor(TaylorExpansion[N]):
    """Flow by Taylor steps of the scene's order, or of `order`, and its tolerance."""

    method = "taylor"

    def __init__(
        self, scene: Scene[N], kit: Kit[N], certificate: Certificate[N], order: int | None = None
    ) -> None:
        super().__init__(scene, kit, order or kit.order(scene))
        self.search = PolynomialSearch(kit)
        self.search.certificate = certificate
        self.evaluations = self.steps = 0
        self.looked_at: tuple[ModeRows[N], tuple[N, ...]] | None = None
        rates = [term.omega for term in scene.harmonics if term.amplitude != 0]
        self.longest = min((3 / rate for rate in rates), default=kit.inf)
        self._quadrature = TWELVE if rates or self.order > EIGHT_NODES_ORDER else EIGHT

    @property
    def quadrature(self) -> Quadrature:
        """Nodes and weights of a piece of a step; where there are formulas those that take more."""
        return TWELVE if self.rows.by_formulas else self._quadrature

    @property
    def certificate(self) -> Certificate[N]:
        """The record of doubts of this run."""
        return self.search.certificate

    def enter(self, state: State[N], rows: ModeRows[N], known: Known) -> None:
        """Expand the motion at `state` in the mode of `rows`; known: {event key: order of its zero here}."""
        self.nearest = 0
        self._expand_in(state, rows, known)
        self.reach(self.order)
        self.steps += 1
        self.h = self.step_length()
        if self.tape is None or not self.tape.tape.ops:
            return
        try:
            self.h = self._sound_step(self.tape)
        except EngineError:
            self.nearest = overflowing_zero(self.kit, self.tape, self.order)
            if not self.nearest:
                raise
            self._expand_in(state, rows, known)
            self.reach(self.order)
            self.h = self.step_length()
            self.h = self._sound_step(self.tape)

    def _sound_step(self, tape: TapeSeries[N]) -> N:
        """The step, or a shorter one, at the end of which the formulas have the values that their series say.

        What a series leaves out may grow where its last terms do not show it: exp far from zero, roots near
        zero. Raises EngineError where no step that moves time is short enough.
        """
        left = self.scene.t_end - self.t0
        if not left > 0:
            return self.h
        h = self._on_grid(self.h) if self.h < left else left
        checks = StepChecks(self, tape)
        shortest = checks.shortest()
        for _ in range(SHORTENINGS):
            excess = checks.excess(h)
            if excess <= 0 or (h <= shortest and excess < BEYOND_ALL):
                return self.h if h == left else h
            h = self._on_grid(shortened(self.kit, h, excess, self.order))
            if self.t0 + h == self.t0:
                break
        raise EngineError("singular", self.start, checks.worst)

    def _on_grid(self, h: N) -> N:
        """A step of length h [s], of which the end is on the grid of time."""
        tau = self.kit.exact(self.kit.exact(self.t0 + h) - self.t0)
        return tau if tau > 0 else h

    def look(self, state: State[N], rows: ModeRows[N]) -> None:
        """Expand the motion at `state` in the mode of `rows` for its derivatives there, as far as they are
        asked for: no step follows. What was looked at last is not expanded anew.
        """
        place = (state.t, *state.x, *state.v, state.phase, state.w)
        if self.looked_at is None or self.looked_at[0] is not rows or self.looked_at[1] != place:
            self.nearest = 0
            self._expand_in(state, rows, {})
            self.looked_at = rows, place

    def _expand_in(self, state: State[N], rows: ModeRows[N], known: Known) -> None:
        self.known, self.looked_at = known, None
        self.t0, self.start = state.t, state
        self.expand(state, rows)

    def carry_on(self, state: State[N]) -> None:
        """Go on from an instant that was no event: the next step."""
        self.enter(state, self.rows, {})

    def polynomial(self, event: Event[N]) -> list[N]:
        """Coefficients of an event function over the step, without the known zeros' rounding."""
        if not event.terms:
            return [event.constant, self.kit.number(0)] + [self.kit.number(0)] * (self.order - 1)
        series = self._term(event.terms[0])
        for term in event.terms[1:]:
            series = [a + b for a, b in zip(series, self._term(term), strict=False)]
        return self.kit.all_exact([series[0] + event.constant] + series[1:])

    def _term(self, term: Term[N]) -> list[N]:
        P, Q, factor, p = term.P, term.Q, term.coefficient, self.order
        if term.kind == DIFFERENCE:
            return [factor * (a - b) for a, b in zip(self.x[P], self.x[Q], strict=True)]
        if term.kind == RATE:
            return [factor * (a - b) for a, b in zip(self.v[P][:-1], self.v[Q][:-1], strict=True)]
        if term.kind == COUPLING:
            return [factor * self.coupling_force(self.rows.couplings[P], n) for n in range(p + 1)]
        if term.kind == ACCELERATION:
            return [factor * ((n + 1) * self.v[P][n + 1]) for n in range(p)]
        if term.kind == FORMULA:
            assert self.tape is not None
            return [factor * value for value in self.tape.output(P)[:p]]
        return [factor * value for value in self._load_on(P)]

    def _load_on(self, column: int) -> list[N]:
        """Series of the load on a column: its forces and what a motor on it exerts while it is tied to the
        ground or the base.
        """
        series = self.load[column] or [self.kit.number(0)] * self.order
        if self.rotors:
            series = [a + b for a, b in zip(series, self.rotors.thrust(column), strict=True)]
        if self.rotor is None or self.rotor.motor.on != column:
            return series
        return [a + b for a, b in zip(series, self.rotor.thrust(), strict=True)]

    def value_and_slope(self, event: Event[N], tau: N) -> tuple[N, N]:
        """Value and slope of an event function a time tau after the expansion point, but for its known zeros
        there: divided by that power of tau.
        """
        return self.search.value_and_slope(self.polynomial(event), self.known.get(event.key, 0), tau)

    def derivatives(self, event: Event[N], count: int) -> list[N]:
        """Derivatives of order 0 to `count` of an event function at the expansion point."""
        self.reach(count + 1)
        factorial = 1
        derivatives: list[N] = []
        series = self.polynomial(event)
        for n in range(count + 1):
            factorial = factorial * n if n > 0 else 1
            derivatives.append(series[n] * factorial)
        return derivatives

    def advance(self, limit: N) -> Advance[N]:
        """One step to its end, to the first event within it or to `limit`; returns (time, event or None)."""
        length = limit - self.t0
        h = self.h if self.h < length else length
        end = limit if self.h >= length else self.kit.exact(self.t0 + h)
        if end <= self.t0:
            self.certificate.doubt(self.t0)
            return self.kit.next_after(self.t0, inf), None
        first: Event[N] | None = None
        for event in self.rows.events:
            known = self.known.get(event.key, 0)
            polynomial = self.polynomial(event)
            if event.kind == STRIKE and known == 0 == polynomial[0] and closes(polynomial):
                return self.t0, event
            if event.kind == STRIKE and known == 0:
                nearer = self.search.nearer(polynomial, self.t0, h, self._magnitude(event))
                if nearer < h:
                    end, first = self.kit.exact(self.t0 + nearer), None
                    h = end - self.t0
            sharp = event.kind == STRIKE
            t, zero = self.search.first_root(polynomial, known, self.t0, h, event.turns, sharp)
            if t is not None and (t < end or (zero and first is None)):
                end, first = t, event if zero else None
                h = end - self.t0
            if h == 0:  # an event at the start: no other can come before it
                break
        if first is not None:
            self._certify_order(first, end)
        return end, first

    def _certify_order(self, first: Event[N], end: N) -> None:
        """Doubt that the zero of `first`, at time `end`, is the first, where that of another event may come
        as soon. Two names of one function vanish together.
        """
        here = self._near_zero(first, end - self.t0)
        if here is None or here[1] >= 0:  # a touch is in doubt by itself
            return
        value, slope, noise = here
        latest = latest_zero(self.kit, value, slope, noise, end)
        for event in self.rows.events:
            there = None if event is first else self._near_zero(event, end - self.t0)
            if there is None:
                continue
            other, fall, blur = there
            if (other, fall) != (value, slope) and may_vanish_by(other, fall, blur, latest):
                self.certificate.doubt(self.t0)

    def _near_zero(self, event: Event[N], tau: N) -> tuple[N, N, N] | None:
        known = self.known.get(event.key, 0)
        near = self.search.near_zero(self.polynomial(event), known, tau, self._magnitude(event))
        return near and (self.kit.exact(near[0]), self.kit.exact(near[1]), near[2])

    def _magnitude(self, event: Event[N]) -> N:
        """Sum of the magnitudes that an event function is made of at the expansion point."""
        total = event.size
        for term in event.terms:
            total = total + abs(term.coefficient) * self._magnitude_of(term)
        return total

    def _magnitude_of(self, term: Term[N]) -> N:
        if term.kind == DIFFERENCE:
            return abs(self.x[term.P][0]) + abs(self.x[term.Q][0])
        if term.kind == RATE:
            return abs(self.v[term.P][0]) + abs(self.v[term.Q][0])
        if term.kind == COUPLING:
            one = self.rows.couplings[term.P]
            places = abs(self.x[one.P][0]) + abs(self.x[one.Q][0])
            speeds = abs(self.v[one.P][0]) + abs(self.v[one.Q][0])
            return one.k * places + one.c * speeds + abs(one.offset)
        if term.kind == ACCELERATION:
            return abs(self.v[term.P][1])
        if term.kind == FORMULA:
            return self.tape_values(self.kit.number(0)).output(term.P)[1] / self.kit.eps
        return abs(self._load_on(term.P)[0])

    def tape_values(self, tau: N) -> TapeValues[N]:
        """Values of the formulas a time tau after the expansion point, from the state there."""
        kit, columns, t = self.kit, range(self.n + 2), self.t0 + tau
        at, blur = [], []
        for series in (self.x, self.v):
            at.append([horner(series[c], tau) if tau != 0 else series[c][0] for c in columns])
            blur.append([INPUT_ROUNDING * kit.eps * abs(value) for value in at[-1]])
        phi = w = kit.number(0)
        if self.rotor:
            phi, w = horner(self.rotor.phi, tau), horner(self.rotor.w, tau)
        lost = INPUT_ROUNDING * kit.eps
        return TapeValues(
            kit,
            self.rows.tape or Tape(),
            Inputs(t, at[0], at[1], phi, w),
            Inputs(kit.eps * abs(t), blur[0], blur[1], lost * abs(phi), lost * abs(w)),
        )

    def longest_piece(self, _tau: N) -> N:
        """Longest stretch [s] that one quadrature rule integrates to round-off: a whole step, or 3 rad of the
        fastest force.
        """
        return self.longest

    def open_nodes(self, integrals: LedgerIntegrals[N]) -> None:
        """Prepare the nodes of the step: the functions that the integrals read, as polynomials."""
        self.series = [self.polynomial(function) for function in integrals.functions]

    def node(self, tau: N, integrals: LedgerIntegrals[N]) -> QuadratureNode[N]:
        """Values that the ledger integrals read a time tau after the expansion point."""
        v = [self.kit.number(0)] * (self.n + 2)
        for c in integrals.columns:
            v[c] = horner(self.v[c], tau)
        forces = [self._force_at(force, tau) for force in self.scene.forces] if integrals.forces else []
        w = horner(self.rotor.w, tau) if self.rotor and integrals.spins else self.kit.number(0)
        return QuadratureNode(v, w, forces, [horner(series, tau) for series in self.series])

    def _force_at(self, force: Force[N], tau: N) -> N:
        kit, total = self.kit, force.constant
        for term in force.terms:
            anchor = kit.turn_angle(term.cycles, term.cycles_lo, self.t0) + term.phase
            sine = kit.sin(anchor + kit.turn_angle(term.cycles, term.cycles_lo, tau))
            total = total + term.amplitude * sine
        return total

    def spin_rate(self, tau: N) -> N:
        """Rate of the speed of the rotor [rad/s^2] a time tau after the expansion point."""
        assert self.rotor is not None
        return self.rotor.spin_rate(tau)

    def state_at(self, t: N) -> State[N]:
        """State at time t within the step."""
        state = self.state_after(t - self.t0)
        state.t = t
        return state

    def state_after(self, tau: N) -> State[N]:
        """State a time tau after the expansion point, which need not be on the time grid."""
        kit = self.kit
        zero = kit.number(0)
        x = [horner(self.x[c], tau) for c in range(self.n)]
        v = [horner(self.v[c], tau) for c in range(self.n)]
        if not self.rotor:
            return State(self.t0 + tau, x, v, zero, zero, zero)
        phase, turns = kit.reduce_angle(horner(self.rotor.phi, tau))
        return State(self.t0 + tau, x, v, phase, self.start.turns + turns, horner(self.rotor.w, tau))


def digits_beyond(kit: Kit[N], off: N, allowed: N) -> float:
    """By how many binary digits, one at least, a difference is beyond what it may be; 0 where it is not. A
    value that overflows, and its bound with it, is beyond.
    """
    if off <= allowed and kit.finite(allowed):
        return 0.0
    if not (kit.finite(off) and allowed > 0):
        return BEYOND_ALL
    return max(1.0, float(kit.exponent(off) - kit.exponent(allowed)))


def shortened(kit: Kit[N], h: N, excess: float, order: int) -> N:
    """The length of a step [s] whose last terms are `excess` binary digits too large, made shorter."""
    return h * kit.power_of_two(-max((excess + 1) / order, LEAST_SHORTENING))


def overflowing_zero(kit: Kit[N], tape: TapeSeries[N], order: int) -> N | int:
    """The time [s] within which the base of a power is at its zero, of powers whose series overflow so near
    it; 0 where none does.
    """
    nearest: N | int = 0
    for op, series in zip(tape.tape.ops, tape.series, strict=True):
        if op.code != POWER or not tape.series[op.a][0] > 0:
            continue
        base = tape.series[op.a]
        if base[1] != 0 and not all(kit.finite(value) for value in series[:order]):
            time = 2 * (base[0] / abs(base[1]))
            nearest = time if time > nearest and kit.finite(time) else nearest
    return nearest


class StepChecks(Generic[N]):
    """Compares series of formulas at the end of a step with their values there."""

    def __init__(self, flow: Taylor[N], tape: TapeSeries[N]) -> None:
        self.flow, self.tape, self.kit = flow, tape, flow.kit
        self.worst = ""
        self.forces: dict[int, list[int]] = {}
        for one in flow.rows.formulas:
            self.forces.setdefault(one.output, []).extend(c for c in (one.P, one.Q) if c >= 0)

    def shortest(self) -> N:
        """The step [s] that is not made shorter: where the base of a power is at its zero within the
        resolution of time, so that the power is known no better. A belt may also carry a body there so slowly
        that shorter steps do not move it.
        """
        for op in self.tape.tape.ops:
            if op.code != POWER:
                continue
            base = self.tape.series[op.a]
            if (base[1] < 0 or op.value > 0) and not base[0] > self.tape.least * abs(base[1]):
                return 2 * self.tape.least
        return self.kit.number(0)

    def excess(self, h: N) -> float:
        """By how many binary digits the worst formula is beyond what it may be wrong by at the end h [s] of a
        step, and at NEARER of it; 0 where none is.
        """
        return max(self._excess_at(h, h), self._excess_at(NEARER * h, h))

    def _excess_at(self, tau: N, h: N) -> float:
        """The same at tau; rounding of the series is that at h."""
        flow, worst = self.flow, 0.0
        values = flow.tape_values(tau)
        for op in self.tape.tape.ops:
            if op.code == POWER:  # begun at a zero of its base, which must not be over before the step is
                base, there = self.tape.series[op.a], values.values[op.a]
                if there < -values.bounds[op.a] and self._begins(base):
                    worst = SHORT_CONTACT
        for k, text in enumerate(self.tape.tape.texts):
            value, bound = values.output(k)
            series = self.tape.output(k)[: flow.order]
            off, bound, share = abs(value - horner(series, tau)), 2 * bound, self._share(k, tau, value)
            beyond = digits_beyond(self.kit, off, bound + share)
            if beyond > 0:  # the rounding of the series is seldom needed
                rounding = 2 * self.kit.eps * sizes_at(series, h)
                beyond = digits_beyond(self.kit, off, bound + rounding + share)
            if beyond > worst:
                worst, self.worst = beyond, text
        return worst

    def _begins(self, base: Sequence[N]) -> bool:
        """Whether the base of a power begins at its zero: it rises from there, of whatever order the zero
        is.
        """
        if base[0] > self.tape.least * abs(base[1]):
            return False
        return next((value > 0 for value in base[1 : self.flow.order] if value != 0), False)

    def _share(self, k: int, h: N, value: N) -> N:
        """How wrong a force may be so that velocities are not wrong beyond the tolerance of the step; of
        what is at rest and begins to move, where `value` is the force at h, beyond that of the speed it
        would come to.
        """
        flow, share, mobile = self.flow, self.kit.inf, False
        for c in self.forces.get(k, ()):
            leader = flow.rows.leader[c]
            mobility = flow.rows.mobility[leader]
            if mobility > 0:
                speed = self._speed(leader, h)
                if not speed > 0:
                    speed = mobility * abs(value) * (flow.scene.t_end - flow.t0)
                one = speed / (h * mobility)
                share, mobile = one if one < share else share, True
        if not mobile:
            share = self._held(k, h, value)
        return flow.order * self.kit.power_of_two(flow.tolerance_exponent) * share

    def _held(self, k: int, h: N, value: N) -> N:
        """What a force that moves nothing has to be small beside: what holds the ties that it pulls at. Where
        none may give way, the force of which the impulse over the rest of the run is that of `value`
        over the step; of what is no force 0.
        """
        flow, least = self.flow, self.kit.inf
        for event in flow.rows.events:
            if event.kind == HOLD and any((term.kind, term.P) == (FORMULA, k) for term in event.terms):
                size = event.size
                for term in event.terms:
                    if term.kind == FORMULA:
                        size = size + abs(self.tape.output(term.P)[0])
                least = size if size < least else least
        if self.kit.finite(least):
            return least
        return abs(value) * (flow.scene.t_end - flow.t0) / h if k in self.forces else self.kit.number(0)

    def _speed(self, leader: int, h: N) -> N:
        """Size of a velocity over a step: of a body that of all bodies together."""
        flow = self.flow
        if leader in flow.alone:
            return abs(flow.v[leader][0]) + h * abs(flow.v[leader][1])
        total = self.kit.number(0)
        for c in range(flow.n):
            if c not in flow.alone:
                total = total + (abs(flow.v[c][0]) + h * abs(flow.v[c][1]))
        return total


def closes(polynomial: Iterable[N]) -> bool:
    """Whether a function falls from where it is: its first coefficient that is not zero is negative."""
    return next((value < 0 for value in polynomial if value != 0), False)

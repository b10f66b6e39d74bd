"""The closed-form flow: one exact expression per modal coordinate from event to event.

Inside a mode that has a closed form every modal coordinate is a damped oscillator, or a free mass, under a
constant and harmonic loads. A trajectory costs a few evaluations per event, however long the stretches
between them.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.events.records import Certificate
from vibsim.engine.flows.closed.closed_form_search import JET_ORDER, ClosedFormSearch
from vibsim.engine.flows.closed.modal import (
    Coordinate,
    Modal,
    Source,
    harmonic_key,
    nonzero_harmonics,
    pitches,
)
from vibsim.engine.flows.closed.modal_maker import modal_of
from vibsim.engine.flows.closed.reaches import EventReaches, Reach, reaches_of
from vibsim.engine.flows.closed.responses import UNHURRIED, Oscillator, Responses, free_harmonic_response
from vibsim.engine.flows.motion import Advance
from vibsim.engine.ledger_integrals import LedgerIntegrals, QuadratureNode
from vibsim.engine.modes.rows import Event, EventKey, Known, ModeRows
from vibsim.physics.elementary import TWELVE
from vibsim.physics.numbers import Kit, N, abs, total_of
from vibsim.physics.parts import Force, Harmonic, Scene


class Constants(Generic[N]):
    """Oscillators and load bounds of one modal coordinate."""

    def __init__(self, kit: Kit[N], coordinate: Coordinate[N], rates: Sequence[N]) -> None:
        self.coordinate = coordinate
        self.driven = [h for h in range(len(rates)) if coordinate.sines[h] != 0 or coordinate.cosines[h] != 0]
        omegas = [rates[h] for h in self.driven] or [kit.number(0)]
        self.oscillators = [Oscillator(kit, coordinate.a, coordinate.b, omega) for omega in omegas]
        self.forced: list[N] = []  # by n: sum over harmonics of |amplitude| omega^n / 2
        sizes = [(abs(coordinate.sines[h]) + abs(coordinate.cosines[h])) / 2 for h in self.driven]
        for _ in range(JET_ORDER + 3):
            self.forced.append(total_of(kit, sizes))
            sizes = [size * rates[h] for size, h in zip(sizes, self.driven, strict=True)]


@dataclass
class ModalMotion(Modal[N]):
    """A closed form ready to move.

    constants : of each coordinate
    window : length [s] of a stretch on which bounds of the motion are tight
    pace : the largest of the coordinates' rates [rad/s]
    reaches : of event functions
    """

    constants: list[Constants[N]]
    window: N
    pace: N
    reaches: dict[EventKey, Reach[N]]


class ClosedForm(Generic[N]):
    """Flow by modal coordinates; time is absolute, the anchor is the last event."""

    method = "closed_form"
    quadrature = TWELVE
    modal: ModalMotion[N]

    def __init__(self, scene: Scene[N], kit: Kit[N], certificate: Certificate[N]) -> None:
        self.scene, self.kit, self.certificate = scene, kit, certificate
        self.n = len(scene.bodies)
        self.harmonics = pitches(scene)
        self.rates = [omega for omega, *_ in self.harmonics]
        self.evaluations = 0
        self.search = ClosedFormSearch(self)

    @property
    def steps(self) -> int:
        """Steps of the search for events."""
        return self.search.steps

    @property
    def known(self) -> Known:
        """Orders of the zeros that the segment began with."""
        return self.search.known

    def covers(self, rows: ModeRows[N]) -> bool:
        """Whether the mode has a closed form; prepares it where it has."""
        if not rows.modal_sought:
            modal = modal_of(self.scene, self.kit, rows, self.harmonics)
            rows.modal = None if modal is None else self._prepare(modal, rows)
            rows.modal_sought = True
        return rows.modal is not None

    def dimension(self, rows: ModeRows[N]) -> int:
        """How many functions of time the motion in a mode is a sum of: what has so many derivatives zero at
        one instant is zero.
        """
        assert rows.modal is not None, "the mode has no closed form"
        return 2 * len(rows.modal.coordinates) + 2 * len(self.harmonics) + 1

    def _prepare(self, modal: Modal[N], rows: ModeRows[N]) -> ModalMotion[N]:
        constants = [Constants(self.kit, c, self.rates) for c in modal.coordinates]
        windows = [o.window for c in constants if not c.coordinate.free for o in c.oscillators]
        windows += [self.kit.number(3) / 2 / rate for rate in self.rates]
        window = min(windows, default=self.kit.number(UNHURRIED))
        pace = max((c.oscillators[0].w0 for c in constants), default=self.kit.number(0))
        of = EventReaches(self.kit, rows, modal, [reaches_of(self.kit, one) for one in constants])
        reaches = {event.key: of.of(event) for event in rows.events}
        return ModalMotion(modal.coordinates, modal.places, modal.pairs, constants, window, pace, reaches)

    def enter(self, state: State[N], rows: ModeRows[N], known: Known) -> None:
        """Anchor the flow at `state` in the mode of `rows`; known: {event key: order of its zero here}."""
        assert rows.modal is not None, "the mode has no closed form"
        self.rows, self.modal = rows, rows.modal
        self.t0, self.start = state.t, state
        self._anchor_harmonics(state.t)
        X, V = self._base(self.sin0, self.cos0)
        self.x0 = [*state.x, self.kit.number(0), X]
        self.v0 = [*state.v, self.kit.number(0), V]
        self.q0: list[N] = []
        self.u0: list[N] = []
        self.load: list[N] = []
        self.load_sine: list[list[N]] = []
        self.load_cosine: list[list[N]] = []
        for coordinate, constants in zip(self.modal.coordinates, self.modal.constants, strict=True):
            self._anchor_coordinate(coordinate, constants)
        self._evaluate_start()
        self.search.open(rows.events, known)

    def _anchor_harmonics(self, t: N) -> None:
        self.sin0: list[N] = []
        self.cos0: list[N] = []
        for _, cycles, cycles_lo, phase in self.harmonics:
            angle = self.kit.turn_angle(cycles, cycles_lo, t) + phase
            sine, cosine = self.kit.rounded_sine_cosine(angle)
            self.sin0.append(sine)
            self.cos0.append(cosine)

    def _anchor_coordinate(self, coordinate: Coordinate[N], constants: Constants[N]) -> None:
        q, u = self._weighted(coordinate.sources, self.x0), self._weighted(coordinate.sources, self.v0)
        load = coordinate.load
        for factor, plus, minus in coordinate.shifts:
            load = load + factor * self._fixed((*plus, *((-sign, c) for sign, c in minus)))
        self.q0.append(q)
        self.u0.append(u)
        self.load.append(load)
        s, c = coordinate.sines, coordinate.cosines
        self.load_sine.append([s[h] * self.sin0[h] + c[h] * self.cos0[h] for h in constants.driven])
        self.load_cosine.append([s[h] * self.cos0[h] - c[h] * self.sin0[h] for h in constants.driven])

    def _weighted(self, sources: Iterable[Source[N]], values: Sequence[N]) -> N:
        parts = [weight * (values[P] if Q is None else values[P] - values[Q]) for (P, Q), weight in sources]
        return total_of(self.kit, parts)

    def _fixed(self, places: Iterable[tuple[int, int]]) -> N:
        return total_of(self.kit, [sign * self.x0[c] for sign, c in places])

    def _base(self, sines: Sequence[N], cosines: Sequence[N]) -> tuple[N, N]:
        """Displacement and velocity of the base from sines and cosines of the harmonics."""
        X = V = self.kit.number(0)
        for term in nonzero_harmonics(self.scene.base):
            h = self.harmonics.index(harmonic_key(term))
            X = X + term.amplitude * sines[h]
            V = V + term.amplitude * term.omega * cosines[h]
        return X, V

    def _evaluate_start(self) -> None:
        """Result of `evaluate` at the anchor, where every response is 0 or 1."""
        zero = self.kit.number(0)
        self.tau = zero
        self.q, self.u = list(self.q0), list(self.u0)
        self.sines, self.cosines = list(self.sin0), list(self.cos0)
        count = len(self.q0)
        self.stiff, self.impulse, self.steady = [zero] * count, [zero] * count, [zero] * count
        self.responses: list[list[Responses[N]]] = [
            [(zero, zero, zero, zero) for _ in c.driven] for c in self.modal.constants
        ]

    def carry_on(self, state: State[N]) -> None:
        """Go on from an instant that was no event: nothing to do, the anchor holds."""

    def advance(self, limit: N) -> Advance[N]:
        """March to the first event or to `limit`; returns (time, event or None)."""
        return self.search.advance(limit)

    def evaluate(self, tau: N) -> None:
        """Set coordinates, rates and the phases of the harmonics a time tau after the anchor, and keep the
        responses they are made of.
        """
        if tau == self.tau:
            return
        self.evaluations += 1
        self.tau = tau
        cosines, sines = self._harmonics_after(tau)
        for m, constants in enumerate(self.modal.constants):
            self._evaluate_coordinate(m, constants, tau, cosines, sines)

    def _harmonics_after(self, tau: N) -> tuple[list[N], list[N]]:
        kit = self.kit
        cosines: list[N] = []
        sines: list[N] = []
        for h, (omega, cycles, cycles_lo, _) in enumerate(self.harmonics):
            angle = omega * tau
            if angle > 3:  # below, the product is as good as its reduction
                angle = kit.turn_angle(cycles, cycles_lo, tau)
            sine, cosine = kit.sine_cosine(angle)
            self.sines[h] = self.sin0[h] * cosine + self.cos0[h] * sine
            self.cosines[h] = self.cos0[h] * cosine - self.sin0[h] * sine
            cosines.append(cosine)
            sines.append(sine)
        return cosines, sines

    def _evaluate_coordinate(
        self, m: int, constants: Constants[N], tau: N, cosines: Sequence[N], sines: Sequence[N]
    ) -> None:
        q0, u0, load = self.q0[m], self.u0[m], self.load[m]
        osc = constants.oscillators[0]
        if constants.coordinate.free:
            q = q0 + u0 * tau + load * (tau * tau / 2)
            u = u0 + load * tau
        else:
            release, impulse = osc.release_and_impulse(tau)
            steady = osc.constant_response(tau, release)
            rate = release - 2 * osc.a * impulse
            stiff = osc.b * impulse
            q = q0 * release + u0 * impulse + load * steady
            u = u0 * rate - q0 * stiff + load * impulse
            self.stiff[m], self.impulse[m], self.steady[m] = stiff, impulse, steady
        for i, h in enumerate(constants.driven):
            osc, cosine, sine = constants.oscillators[i], cosines[h], sines[h]
            if constants.coordinate.free:
                hc, hs = free_harmonic_response(self.kit, osc.omega, tau, cosine, sine, osc)
                dc, ds = sine / osc.omega, osc.omega * hc
            else:
                hc, hs, dc, ds = osc.harmonic_response(tau, release, impulse, cosine, sine)
            self.responses[m][i] = (hc, hs, dc, ds)
            q = q + (self.load_sine[m][i] * hc + self.load_cosine[m][i] * hs)
            u = u + (self.load_sine[m][i] * dc + self.load_cosine[m][i] * ds)
        self.q[m], self.u[m] = q, u

    def longest_piece(self, tau: N) -> N:
        """Longest stretch [s] from tau after the anchor that one quadrature rule integrates to round-off.

        Behind an event the fast transient of strong damping wants short pieces, which may grow as it decays.
        """
        longest = 1.5 * self.modal.window
        for constants in self.modal.constants:
            a = constants.coordinate.a
            if a > 0:
                growing = 1.5 / (2 * a) + tau
                longest = growing if growing < longest else longest
        return longest

    def open_nodes(self, integrals: LedgerIntegrals[N]) -> None:
        """Prepare the nodes of a stretch: nothing to do."""

    def node(self, tau: N, integrals: LedgerIntegrals[N]) -> QuadratureNode[N]:
        """Values that the ledger integrals read a time tau after the anchor."""
        state = self.state_after(tau)
        v = [*state.v, self.kit.number(0), self._base(self.sines, self.cosines)[1]]
        forces = [self._force_here(force) for force in self.scene.forces] if integrals.forces else []
        of = self.search.functions_of
        if integrals.functions:
            of.here(2)
        return QuadratureNode(
            v, self.kit.number(0), forces, [of.derivative(one, 0) for one in integrals.functions]
        )

    def _force_here(self, force: Force[N]) -> N:
        total = force.constant
        for term in nonzero_harmonics(force.terms):
            total = total + term.amplitude * self.sines[self.harmonics.index(harmonic_key(term))]
        return total

    def jets(self, count: int) -> list[list[N]]:
        """Derivatives q, q', ..., of order 0 to `count` of each coordinate at the point evaluated last."""
        return [self._jet(m, constants, count) for m, constants in enumerate(self.modal.constants)]

    def _jet(self, m: int, constants: Constants[N], count: int) -> list[N]:
        coordinate, d = constants.coordinate, [self.q[m], self.u[m]]
        sines = [coordinate.sines[h] for h in constants.driven]
        cosines = [coordinate.cosines[h] for h in constants.driven]
        for n in range(count - 1):
            term = self.kit.number(0)
            for i, h in enumerate(constants.driven):
                turns = self.sines[h], self.cosines[h], -self.sines[h], -self.cosines[h]
                term = term + (sines[i] * turns[n % 4] + cosines[i] * turns[(n + 1) % 4])
                sines[i], cosines[i] = sines[i] * self.rates[h], cosines[i] * self.rates[h]
            term = term - 2 * coordinate.a * d[n + 1] - coordinate.b * d[n]
            d.append(term + self.load[m] if n == 0 else term)
        return d

    def base_jet(self, count: int) -> list[N]:
        """Derivatives of order 0 to `count` of the base's displacement at the point evaluated last."""
        d = [self.kit.number(0)] * (count + 1)
        for term in nonzero_harmonics(self.scene.base):
            self._add_jet(d, term)
        return d

    def load_jet(self, column: int, count: int) -> list[N]:
        """Derivatives of order 0 to `count` of the force on a column at the point evaluated last."""
        d = [self.kit.number(0)] * (count + 1)
        for force in self.scene.forces:
            if force.on == column:
                d[0] = d[0] + force.constant
                for term in nonzero_harmonics(force.terms):
                    self._add_jet(d, term)
        return d

    def _add_jet(self, d: list[N], term: Harmonic[N]) -> None:
        """Add the derivatives of a harmonic at the point evaluated last to those in d."""
        h, factor = self.harmonics.index(harmonic_key(term)), term.amplitude
        turns = self.sines[h], self.cosines[h], -self.sines[h], -self.cosines[h]
        for n in range(len(d)):
            d[n] = d[n] + factor * turns[n % 4]
            factor = factor * term.omega

    def value_and_slope(self, event: Event[N], tau: N) -> tuple[N, N]:
        """Value and slope of an event function a time tau after the anchor."""
        self.evaluate(tau)
        of = self.search.functions_of
        of.here(4)
        return of.derivative(event, 0), of.derivative(event, 1)

    def derivatives(self, event: Event[N], count: int) -> list[N]:
        """Derivatives of order 0 to `count` of an event function at the anchor."""
        self.evaluate(self.kit.number(0))
        of = self.search.functions_of
        of.here(count + 3)
        return [of.derivative(event, n) for n in range(count + 1)]

    def state_at(self, t: N) -> State[N]:
        """State at time t within the segment."""
        state = self.state_after(t - self.t0)
        state.t = t
        return state

    def state_after(self, tau: N) -> State[N]:
        """State a time tau after the anchor, which need not be on the time grid."""
        zero = self.kit.number(0)
        self.evaluate(tau)
        X, V = self._base(self.sines, self.cosines)
        x: list[N] = []
        v: list[N] = []
        for c in range(self.n):
            place = self.modal.places[c]
            position: N | None = None
            rate = zero
            for sign, column in place.fixed:
                part = sign * self.x0[column]
                position = part if position is None else position + part
            for m, share in place.shape.items():
                part = share * self.q[m]
                position = part if position is None else position + part
                rate = share * self.u[m] if rate is zero else rate + share * self.u[m]
            if place.base:
                position, rate = X if position is None else position + X, rate + V
            x.append(zero if position is None else position)
            v.append(rate)
        return State(self.t0 + tau, x, v, zero, zero, zero)

"""The closed-form flow: ideal source, one exact expression from event to event.

Inside a mode the relative displacement y = x1 - x2 is one damped oscillator under a constant and a harmonic
load, and while block 2 slides the centre of mass obeys X'' = (F - sigma N) / (m1 + m2), from Eqs.
(2.1)-(2.3). While it sticks (or is fixed) x2 rests. A trajectory costs a few evaluations per event, however
long the stretches between them.
"""

from vibsim.events.closed_form_search import ClosedFormSearch
from vibsim.events.watch import watched
from vibsim.flows.regime import Regime
from vibsim.flows.responses import Oscillator, free_harmonic_response
from vibsim.physics.state import State


class ClosedForm:
    """Flow of the ideal source between events; time is absolute, the anchor is the last event."""

    method = "closed_form"

    def __init__(self, scene, kit):
        self.scene, self.kit = scene, kit
        zero = kit.number(0)
        self.driven = scene.source == "harmonic" and scene.A != 0
        self.omega = scene.omega if self.driven else zero
        self.mass_point = Oscillator(kit, zero, zero, self.omega)
        self.share1 = scene.m2 / (scene.m1 + scene.m2) if scene.has_block2 else zero
        self.share2 = scene.m1 / (scene.m1 + scene.m2) if scene.has_block2 else zero
        self.regimes = {}
        self.evaluations = 0
        self.search = ClosedFormSearch(self)

    steps = property(lambda self: self.search.steps)
    certificate = property(lambda self: self.search.certificate)

    def enter(self, state, mode, known):
        """Anchor the flow at `state` in `mode`; known: {event function: order of its zero here}."""
        scene, kit = self.scene, self.kit
        self.mode = mode
        self.locked = not scene.has_block2 or (scene.has_friction and mode.friction == 0)
        key = (self.locked, mode.contact, mode.friction)
        if key not in self.regimes:
            self.regimes[key] = Regime(scene, kit, self.locked, mode.contact, mode.friction)
        self.regime = self.regimes[key]
        self.t0 = state.t
        self.x2 = state.x2
        self.y0, self.u0 = state.x1 - state.x2, state.v1 - state.v2
        if not self.locked:
            self.X0 = self.share2 * state.x1 + self.share1 * state.x2
            self.V0 = self.share2 * state.v1 + self.share1 * state.v2
        self.sin0, self.cos0 = kit.number(0), kit.number(1)
        if self.driven:
            angle = kit.turn_angle(scene.cycles, scene.cycles_lo, state.t)
            self.sin0, self.cos0 = kit.sin(angle), kit.cos(angle)
        self.load_sine = self.regime.amplitude * self.sin0
        self.load_cosine = self.regime.amplitude * self.cos0
        self.centre_sine = self.regime.centre_amplitude * self.sin0
        self.centre_cosine = self.regime.centre_amplitude * self.cos0
        self._evaluate_start()
        self.search.open(watched(scene, mode), known)

    def _evaluate_start(self):
        """What `evaluate` would give at the anchor, where every response is 0 or 1."""
        zero = self.kit.number(0)
        self.tau = zero
        self.y, self.u = self.y0, self.u0
        self.sine, self.cosine = self.sin0, self.cos0
        self.stiff = self.impulse = self.steady = zero
        self.hc = self.hs = self.dc = self.ds = self.centre_dc = self.centre_ds = zero
        if not self.locked:
            self.X, self.V = self.X0, self.V0

    def carry_on(self, state):
        """Go on from an instant that was no event: nothing to do, the anchor holds."""

    def advance(self, limit):
        """March to the first event or to `limit`; returns (time, event function or NOTHING)."""
        return self.search.advance(limit)

    def evaluate(self, tau):
        """Set y, u, the centre of mass and the phase of the force a time tau after the anchor, and keep the
        responses they are made of.
        """
        if tau == self.tau:
            return
        regime, osc, kit = self.regime, self.regime.oscillator, self.kit
        self.evaluations += 1
        release, impulse = osc.release_and_impulse(tau)
        steady = osc.constant_response(tau, release)
        y0, u0 = self.y0, self.u0
        rate = release - 2 * osc.a * impulse
        stiff = osc.b * impulse
        y = y0 * release + u0 * impulse + regime.load * steady
        u = u0 * rate - y0 * stiff + regime.load * impulse
        self.stiff, self.impulse, self.steady = stiff, impulse, steady
        if self.driven:
            angle = self.omega * tau
            if angle > 3:  # below, the product is as good as its reduction
                angle = kit.turn_angle(self.scene.cycles, self.scene.cycles_lo, tau)
            cosine, sine = kit.cos(angle), kit.sin(angle)
            hc, hs, dc, ds = osc.harmonic_response(tau, release, impulse, cosine, sine)
            y = y + (self.load_sine * hc + self.load_cosine * hs)
            u = u + (self.load_sine * dc + self.load_cosine * ds)
            self.hc, self.hs, self.dc, self.ds = hc, hs, dc, ds
            self.sine = self.sin0 * cosine + self.cos0 * sine
            self.cosine = self.cos0 * cosine - self.sin0 * sine
        self.y, self.u, self.tau = y, u, tau
        if not self.locked:
            self._centre(tau, sine if self.driven else None, cosine if self.driven else None)

    def _centre(self, tau, sine, cosine):
        """Centre of mass at tau after the anchor, X'' = (F - sigma N) / (m1 + m2)."""
        load = self.regime.centre_load
        self.X = self.X0 + self.V0 * tau + load * (tau * tau / 2)
        self.V = self.V0 + load * tau
        if self.driven:
            omega = self.omega
            hc, hs = free_harmonic_response(self.kit, omega, tau, cosine, sine, self.mass_point)
            self.centre_dc, self.centre_ds = sine / omega, omega * hc
            self.X = self.X + (self.centre_sine * hc + self.centre_cosine * hs)
            self.V = self.V + (self.centre_sine * self.centre_dc + self.centre_cosine * self.centre_ds)

    def measure(self):
        """Magnitudes of the terms of y, u and V at the point evaluated last: what their rounding is
        proportional to.
        """
        regime = self.regime
        amplitude, load = abs(regime.amplitude), regime.load
        self.scale_y = abs(self.y0) + abs(self.u0 * self.impulse) + abs(load * self.steady)
        self.scale_u = abs(self.u0) + abs(self.y0 * self.stiff) + abs(load * self.impulse)
        if self.driven:
            self.scale_y = self.scale_y + amplitude * (abs(self.hc) + abs(self.hs))
            self.scale_u = self.scale_u + amplitude * (abs(self.dc) + abs(self.ds))
        if not self.locked:
            self.scale_V = abs(self.V0) + abs(regime.centre_load * self.tau)
            if self.driven:
                size = abs(self.centre_dc) + abs(self.centre_ds)
                self.scale_V = self.scale_V + abs(regime.centre_amplitude) * size

    def longest_piece(self, tau):
        """Longest stretch [s] from tau after the anchor that one quadrature rule integrates to round-off.

        Behind an event the fast transient of strong damping wants short pieces, which may grow as it decays.
        """
        osc = self.regime.oscillator
        longest = 1.5 * osc.window
        growing = 1.5 / (2 * osc.a) + tau if osc.a > 0 else longest
        return growing if growing < longest else longest

    def state_at(self, t):
        """State at time t within the segment."""
        state = self.state_after(t - self.t0)
        state.t = t
        return state

    def state_after(self, tau):
        """State a time tau after the anchor, which need not be on the time grid."""
        zero = self.kit.number(0)
        self.evaluate(tau)
        t = self.t0 + tau
        if self.locked:
            return State(t, self.x2 + self.y, self.u, self.x2, zero, zero, zero, zero)
        x1, x2 = self.X + self.share1 * self.y, self.X - self.share2 * self.y
        v1, v2 = self.V + self.share1 * self.u, self.V - self.share2 * self.u
        return State(t, x1, v1, x2, v2, zero, zero, zero)

    def relative_jet(self, state, mode, count):
        """Derivatives of y = x1 - x2 of order 0 to `count` at `state` in `mode`."""
        self.enter(state, mode, {})
        return self.jet(count)

    def jet(self, count):
        """Derivatives y, y', ..., of order 0 to `count` at the point evaluated last, by differentiating the
        oscillator.
        """
        regime, osc = self.regime, self.regime.oscillator
        loads = (self.sine, self.cosine, -self.sine, -self.cosine)
        d = [self.y, self.u]
        amplitude = regime.amplitude
        for n in range(count - 1):
            term = amplitude * loads[n % 4] - 2 * osc.a * d[n + 1] - osc.b * d[n]
            d.append(term + regime.load if n == 0 else term)
            amplitude = amplitude * self.omega
        return d

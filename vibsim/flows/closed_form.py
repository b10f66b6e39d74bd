"""The closed-form flow: ideal source, one exact expression from event to event.

Inside a mode the relative displacement y = x1 - x2 is one damped oscillator under a constant and a harmonic
load, and while block 2 slides the centre of mass obeys X'' = (F - sigma N) / (m1 + m2), from Eqs.
(2.1)-(2.3). While it sticks (or is fixed) x2 rests. A trajectory costs a few evaluations per event, however
long the stretches between them.
"""

from math import inf

from vibsim.events.first_root import deflated_step, leading_order, safe_step
from vibsim.events.watch import CLEARANCE, GAP, HOLD_PLUS, NOTHING, SLIDE, watched
from vibsim.flows.regime import JET_ORDER, Regime
from vibsim.flows.responses import Oscillator, free_harmonic_response
from vibsim.physics.state import State

STEPS_PER_CALL = 4096
POLISHING = 10  # Halley's iteration triples the right digits
TURNING = 60


class ClosedForm:
    """Flow of the ideal source between events; time is absolute, the anchor is the last event."""

    method = "closed_form"

    def __init__(self, scene, kit):
        self.scene, self.kit = scene, kit
        zero = kit.number(0)
        self.limit = scene.N if scene.has_friction else zero
        self.driven = scene.source == "harmonic" and scene.A != 0
        self.omega = scene.omega if self.driven else zero
        self.mass_point = Oscillator(kit, zero, zero, self.omega)
        self.share1 = scene.m2 / (scene.m1 + scene.m2) if scene.has_block2 else zero
        self.share2 = scene.m1 / (scene.m1 + scene.m2) if scene.has_block2 else zero
        self.settled = kit.power_of_two(kit.exponent(kit.eps) / 3)  # the next error is this cubed
        self.regimes = {}
        self.evaluations = self.steps = self.uncertified = 0
        self.margin, self.margin_time = inf, kit.number(0)

    def enter(self, state, mode, known):
        """Anchor the flow at `state` in `mode`; known: {event function: order of its zero here}."""
        scene, kit = self.scene, self.kit
        self.mode, self.known, self.leading = mode, known, True
        self.locked = not scene.has_block2 or (scene.has_friction and mode.friction == 0)
        key = (self.locked, mode.contact, mode.friction)
        if key not in self.regimes:
            self.regimes[key] = Regime(scene, kit, self.locked, mode.contact, mode.friction)
        self.regime = self.regimes[key]
        self.functions = watched(scene, mode)
        self.t0 = self.t = state.t
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
        self.watched = (self.t0,) + (kit.number(0),) * 4
        self.stall = kit.number(1)
        self._evaluate_start()

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
            hc, hs = osc.harmonic_response(tau, release, impulse, cosine, sine)
            dc, ds = impulse - self.omega * hs, self.omega * hc
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

    def bound(self, d, n):
        """Bound of |y^(n)| over the window ahead, from the derivatives d at its start.

        y^(n) obeys the same oscillator: its free part stays below both the energy and the ballistic bound,
        the forced part below |R| omega^n h^2 / 2 because |S(t)| <= t.
        """
        osc = self.regime.oscillator
        value, rate = d[n], d[n + 1]
        size = abs(value) + abs(rate) * osc.window
        if osc.w0 > 0:
            ratio = rate / osc.w0
            energy = self.kit.sqrt(value * value + ratio * ratio)
            if energy < size:
                size = energy
        return size + self.regime.forced[n]

    def derivative(self, function, d, n):
        """n-th time derivative of an event function, n >= 0, from the derivatives d of y."""
        scene = self.scene
        if function == GAP:
            value = -(scene.stop_sign * d[n])
            value = value - scene.G if n == 0 else value
            return value if self.mode.contact else -value
        if function == CLEARANCE:
            value = scene.rest_distance - d[0] if n == 0 else -d[n]
            return -value if self.mode.violated else value
        if function == SLIDE:
            if n == 0:
                return self.mode.friction * (self.V - self.share2 * self.u)
            force = self._force_derivative(d, n - 1)
            force = force - self.mode.friction * self.limit if n == 1 else force
            return self.mode.friction * force / scene.m2
        value = self._force_derivative(d, n)
        value = -value if function == HOLD_PLUS else value
        return self.limit + value if n == 0 else value

    def _force_derivative(self, d, n):
        force = self.regime.k * d[n] + self.scene.c * d[n + 1]
        return force + self.regime.offset if n == 0 else force

    def derivative_bound(self, function, d, n):
        """Bound of the absolute n-th derivative of an event function over the window ahead, n >= 2."""
        if function in (GAP, CLEARANCE):
            return self.bound(d, n)
        if function == SLIDE:
            return (self.regime.k * self.bound(d, n - 1) + self.scene.c * self.bound(d, n)) / self.scene.m2
        return self.regime.k * self.bound(d, n) + self.scene.c * self.bound(d, n + 1)

    def noise(self, function):
        """Rounding bound of an event function at the point evaluated last."""
        scene, osc = self.scene, self.regime.oscillator
        unit = self.kit.eps * (16 + osc.w0 * self.tau)
        if function == GAP:
            return unit * (self.scale_y + abs(scene.G))
        if function == CLEARANCE:
            return unit * (self.scale_y + abs(scene.rest_distance))
        if function == SLIDE:
            return unit * (self.scale_V + self.share2 * self.scale_u)
        force = self.regime.k * self.scale_y + scene.c * self.scale_u
        return unit * (force + abs(self.regime.offset) + self.limit)

    def advance(self, limit):
        """March to the first event or to `limit`; returns (time, event function or NOTHING)."""
        if self.leading:
            found = self._lead()
            if found != NOTHING:
                return self.t, found
        if not self.functions:
            self.t = limit
        for _ in range(STEPS_PER_CALL):
            if self.t >= limit:
                return limit, NOTHING
            found = self._step()
            if found != NOTHING and self.t > limit:  # polished to a time behind the end
                return limit, NOTHING
            if found != NOTHING:
                self._turn_before_event(found)
                return self.t, found
        return (limit if self.t > limit else self.t), NOTHING

    def _lead(self):
        """The first stretch of a segment, known zeros divided out, from the derivatives at its start."""
        self.leading = False
        self.measure()
        step = self.regime.oscillator.window
        d = self.jet(JET_ORDER)
        for function in self.functions:
            known = self.known.get(function, 0)
            derivatives = [self.derivative(function, d, n) for n in range(JET_ORDER - 2)]
            order = leading_order(derivatives, known)
            if order == 0 and derivatives[0] <= self.noise(function) and derivatives[1] <= 0:
                return function
            if order >= JET_ORDER - 3:
                continue
            lead = derivatives[order]
            if order == 0:
                lead = lead - self.noise(function)
            lead = lead if lead > 0 else self.kit.number(0)
            bound = self.derivative_bound(function, d, order + 2)
            ahead = deflated_step(self.kit, order, lead, derivatives[order + 1], bound)
            step = ahead if ahead < step else step
            if function == GAP:
                limit = self.derivative_bound(GAP, d, 2)
                self.watched = (self.t0, *derivatives[:3], limit)
        self._move(step)
        return NOTHING

    def _step(self):
        """One certified step; returns the event function that reached zero here, or NOTHING."""
        self.steps += 1
        self.evaluate(self.t - self.t0)
        self.measure()
        step = rival = self.regime.oscillator.window
        nearest, alone = NOTHING, False
        d = self.jet(4)
        for function in self.functions:
            value, slope = self.derivative(function, d, 0), self.derivative(function, d, 1)
            noise = self.noise(function)
            if value < -noise or (value <= noise and slope <= 0):
                return function
            bound = self.derivative_bound(function, d, 2)
            if function == GAP:
                self._watch_turn(value, slope, self.derivative(GAP, d, 2), bound)
            room = value - noise
            ahead = safe_step(self.kit, room if room > 0 else self.kit.number(0), slope, bound)
            if ahead < step:
                step, rival, nearest = ahead, step, (function if slope < 0 else NOTHING)
                alone, reach = slope < 0 and 8 * value * bound < slope * slope, -2 * value / slope
            elif ahead < rival:
                rival = ahead
        if alone and reach <= rival:
            self._polish(nearest)
            return nearest
        before = self.t
        self._move(step)
        if self.t > before:
            self.stall = self.kit.number(1)
            return NOTHING
        if nearest == NOTHING:
            self.uncertified += 1
            self.t = before + (self.kit.next_after(before, inf) - before) * self.stall
            self.stall = self.stall * 2
        return nearest

    def _polish(self, function):
        """Go to the one zero of `function` ahead, by Halley's iteration.

        Called where 8 f |f''| < f'^2 and f' < 0: then f falls all the way to its zero, which lies within
        -2 f / f' and is the only one there (Kantorovich), and no other event function can vanish before.
        """
        start, window = self.t, self.regime.oscillator.window
        for _ in range(POLISHING):
            d = self.jet(4)
            value, slope = self.derivative(function, d, 0), self.derivative(function, d, 1)
            curvature, before = self.derivative(function, d, 2), self.t
            step = -(2 * value * slope) / (2 * slope * slope - value * curvature)
            self._move(step)
            self.t = self.t if self.t > start else start
            reach = window if abs(curvature) * window < abs(slope) else abs(slope / curvature)
            if self.t == before or abs(step) < self.settled * reach:
                return
            self.steps += 1
            self.evaluate(self.t - self.t0)

    def _move(self, step):
        """Go ahead by `step` on the time grid."""
        self.t = self.kit.exact(self.t0 + ((self.t - self.t0) + step))

    def _watch_turn(self, value, slope, curvature, bound):
        """Look for a minimum of the gap function since the point watched before; then watch from here on.

        bound: on its second derivative over the window ahead. A minimum that cannot undercut the grazing
        margin is not looked for. Between slopes of one sign there may be a maximum beside the minimum: then
        the slope itself has an extreme between, which the curvatures tell.
        """
        low, was, before, bend, limit = self.watched
        self.watched = (self.t, value, slope, curvature, bound)
        length = self.t - low
        least = was + before * length - limit * (length * length) / 2
        if (least if least < was else was) >= self.margin:
            return
        if before < 0 <= slope:
            self._turn_between(low, self.t)
        elif (before < 0) == (slope < 0) and (bend < 0 < curvature or (before < 0 and curvature < 0 < bend)):
            middle = low + length * (bend / (bend - curvature))
            here = self.t
            self.evaluate(middle - self.t0)
            between = self.derivative(GAP, self.jet(4), 1)
            self.evaluate(here - self.t0)
            if before >= 0 > between:
                self._turn_between(middle, here)
            elif before < 0 <= between:
                self._turn_between(low, middle)

    def _turn_between(self, low, high):
        """Keep the minimum of the gap function between two times, by safeguarded Newton steps on its
        slope.
        """
        here, t = self.t, low + (high - low) / 2
        settled = self.settled * self.regime.oscillator.window
        for _ in range(TURNING):
            self.evaluate(t - self.t0)
            d = self.jet(4)
            value, slope = self.derivative(GAP, d, 0), self.derivative(GAP, d, 1)
            curvature = self.derivative(GAP, d, 2)
            low, high = (t, high) if slope < 0 else (low, t)
            ahead = t - slope / curvature if curvature > 0 else low
            if curvature > 0 and abs(ahead - t) < settled:
                break
            if not low < ahead < high:
                ahead = low + (high - low) / 2
            t = ahead
        if curvature > 0:
            value = value - slope * slope / (2 * curvature)
        value = value if value > 0 else self.kit.number(0)
        if value < self.margin:
            self.margin, self.margin_time = value, ahead
        self.evaluate(here - self.t0)

    def _turn_before_event(self, function):
        """Look for a minimum of the gap function between the point watched last and an event of another
        kind.
        """
        if self.scene.has_stop and function != GAP:
            self.evaluate(self.t - self.t0)
            d = self.jet(4)
            value, slope, curvature = (self.derivative(GAP, d, n) for n in range(3))
            self._watch_turn(value, slope, curvature, self.kit.number(0))

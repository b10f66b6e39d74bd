"""The Taylor flow: any source, a polynomial of high order from step to step.

Inside a mode the motion is analytic and its Taylor coefficients follow by recurrence from Eqs. (2.1)-(2.3)
or (2.8)-(2.10). One step gives the state to round-off and a polynomial that is the dense output and carries
the event search. With s = sin phi, c = cos phi and w = dphi/dt the rotor needs three products of series
only, because
    s dw/dt + w^2 c = d(s w)/dt,      s' = c w,      c' = -s w.
"""

from math import inf

from vibsim.events.certificate import latest_zero, may_vanish_by
from vibsim.events.polynomial_root import PolynomialSearch
from vibsim.events.watch import CLEARANCE, GAP, HOLD_PLUS, NOTHING, SLIDE, watched
from vibsim.flows.regime import JET_ORDER
from vibsim.physics.numbers import horner
from vibsim.physics.state import State

LEADING = 4  # coefficients that set the scale of a series in the step control


class Taylor:
    """Flow by Taylor steps of the scene's order and tolerance."""

    method = "taylor"

    def __init__(self, scene, kit):
        self.scene, self.kit, self.order = scene, kit, kit.order(scene)
        self.tolerance_exponent = kit.tolerance_exponent(scene)
        self.limit = scene.N if scene.has_friction else kit.number(0)
        self.harmonic = scene.source == "harmonic"
        self.unbalance = scene.m3 * scene.e if scene.has_motor else kit.number(0)
        count = max(self.order, JET_ORDER) + 2
        self.inverse = [kit.number(0)] + [1 / kit.number(n) for n in range(1, count + 1)]
        self.per_m1 = 1 / scene.m1
        self.per_m2 = 1 / scene.m2 if scene.has_block2 else kit.number(0)
        self.search = PolynomialSearch(kit)
        self.evaluations = self.steps = 0

    certificate = property(lambda self: self.search.certificate)

    def enter(self, state, mode, known):
        """Expand the motion at `state` in `mode`; known: {event function: order of its zero here}."""
        scene = self.scene
        self.mode, self.known = mode, known
        self.locked = not scene.has_block2 or (scene.has_friction and mode.friction == 0)
        self.k = scene.k1 + scene.k2 if mode.contact else scene.k1
        self.offset = scene.k2 * (scene.stop_sign * scene.G) if mode.contact else self.kit.number(0)
        self.functions = watched(scene, mode)
        self.t0, self.start = state.t, state
        self._expand(state)
        self.steps += 1
        self.h = self._step_length()

    def carry_on(self, state):
        """Go on from an instant that was no event: the next step."""
        self.enter(state, self.mode, {})

    def _expand(self, state):
        """Coefficients of x1, v1, x2, v2 (and phi, w, sin phi, cos phi) at `state`."""
        zero = self.kit.number(0)
        p = self.order
        self.x1, self.v1 = [state.x1] + [zero] * (p + 1), [state.v1] + [zero] * (p + 1)
        self.x2, self.v2 = [state.x2] + [zero] * (p + 1), [state.v2] + [zero] * (p + 1)
        if self.locked:
            self.v2[0] = zero
        if self.scene.has_motor:
            self._expand_motor(state)
        else:
            self._expand_ideal(state)

    def _force(self, n):
        """Coefficient n of S, Eqs. (2.4)-(2.6)."""
        force = self.k * (self.x1[n] - self.x2[n]) + self.scene.c * (self.v1[n] - self.v2[n])
        return force + self.offset if n == 0 else force

    def _advance_series(self, n, a1, force):
        """Coefficients n + 1 of displacements and velocities from coefficient n of a1 and S."""
        inverse = self.inverse[n + 1]
        self.x1[n + 1] = self.v1[n] * inverse
        self.v1[n + 1] = a1 * inverse
        if not self.locked:
            if n == 0 and self.scene.has_friction:
                force = force - self.mode.friction * self.limit
            self.x2[n + 1] = self.v2[n] * inverse
            self.v2[n + 1] = force * self.per_m2 * inverse

    def _finish_series(self):
        p = self.order
        self.x1[p + 1] = self.v1[p] * self.inverse[p + 1]
        if not self.locked:
            self.x2[p + 1] = self.v2[p] * self.inverse[p + 1]

    def _expand_ideal(self, state):
        """Eqs. (2.1)-(2.3): m1 a1 = A sin(omega t) + F0 - S, m2 a2 = S - sigma N."""
        scene, kit = self.scene, self.kit
        loads = (kit.number(0),) * 4
        factor = kit.number(0)
        if self.harmonic:
            angle = kit.turn_angle(scene.cycles, scene.cycles_lo, state.t)
            sine, cosine = kit.sin(angle), kit.cos(angle)
            loads, factor = (sine, cosine, -sine, -cosine), scene.A
        for n in range(self.order):
            force = self._force(n)
            load = factor * loads[n % 4]
            if n == 0 and self.harmonic:
                load = load + scene.F0
            self._advance_series(n, (load - force) * self.per_m1, force)
            if self.harmonic:
                factor = factor * scene.omega * self.inverse[n + 1]
        self._finish_series()

    def _expand_motor(self, state):
        """Eqs. (2.8)-(2.10): one 2x2 division per order, by the mass matrix at the expansion point."""
        scene, kit, p = self.scene, self.kit, self.order
        zero = kit.number(0)
        w, phi = [state.w] + [zero] * (p + 1), [state.phase] + [zero] * (p + 1)
        s, c = [kit.sin(state.phase)] + [zero] * p, [kit.cos(state.phase)] + [zero] * p
        a1 = [zero] * p
        mass, inertia = scene.m1 + scene.m3, scene.J + self.unbalance * scene.e
        coupling = self.unbalance * s[0]
        inverse_det = 1 / (mass * inertia - coupling * coupling)
        drag = scene.M0 / scene.Omega0
        to_a1, to_w = inertia * inverse_det, mass * inverse_det
        cross = coupling * inverse_det
        sw, previous = s[0] * w[0], zero
        for n in range(p):
            inverse = self.inverse[n + 1]
            cw, tail, back = self._products(s, c, w, a1, n)
            c[n + 1] = -(sw * inverse)
            if n > 0:
                cw = cw + (c[0] * w[n] + c[n] * w[0])
                tail = tail + s[1] * w[n]
                back = back + s[1] * previous
            else:
                cw = c[0] * w[0]
            s[n + 1] = cw * inverse
            tail = tail + s[n + 1] * w[0]
            force = self._force(n)
            thrust = self.unbalance * ((n + 1) * tail) - force
            torque = self.unbalance * back - drag * w[n]
            if n == 0:
                torque = torque + scene.M0
            previous = a1[n] = to_a1 * thrust + cross * torque
            w[n + 1] = (to_w * torque + cross * thrust) * inverse
            phi[n + 1] = w[n] * inverse
            sw = tail + s[0] * w[n + 1]
            self._advance_series(n, previous, force)
        phi[p + 1] = w[p] * self.inverse[p + 1]
        self.w, self.phi, self.s, self.c = w, phi, s, c
        self._finish_series()

    def _products(self, s, c, w, a1, n):
        """The inner terms of (c w)_n, (s w)_(n+1) and (s a1)_n, those that do not wait for the newest
        coefficients.

        Odd and even terms are summed apart: two chains that a processor takes side by side.
        """
        zero = self.kit.number(0)
        sums = [[zero, zero, zero], [zero, zero, zero]]
        for i in range(1, n):
            part = sums[(i + 1) % 2]
            part[0] = part[0] + c[i] * w[n - i]
            part[1] = part[1] + s[i + 1] * w[n - i]
            part[2] = part[2] + s[i + 1] * a1[n - 1 - i]
        return [odd + even for odd, even in zip(*sums, strict=True)]

    def _step_length(self):
        """Longest step whose last two terms stay below tol times the largest leading one (after Jorba & Zou
        2005).
        """
        blocks = [[self.v1, self.v2]]
        if self.scene.has_motor:
            blocks.append([self.w])
        longest = 1000.0
        for block in blocks:
            sizes = {n: self._size(block, n) for n in (*range(LEADING), self.order - 1, self.order)}
            for last in (self.order - 1, self.order):
                if sizes[last] > self.kit.no_exponent:
                    candidates = [
                        (self.tolerance_exponent + (sizes[m] - sizes[last])) / (last - m)
                        for m in range(min(LEADING, last))
                        if sizes[m] > self.kit.no_exponent
                    ]
                    longest = min(longest, max(candidates, default=longest))
        return self.kit.power_of_two(longest) if longest < 1000.0 else inf

    def _size(self, block, n):
        """Binary exponent of the summed coefficients n of a block of series."""
        total = abs(block[0][n])
        for series in block[1:]:
            total = total + abs(series[n])
        return self.kit.exponent(total)

    def polynomial(self, function):
        """Coefficients of an event function over the step, without the known zeros' rounding."""
        scene = self.scene
        if function in (GAP, CLEARANCE):
            return self._relative_polynomial(function)
        if function == SLIDE:
            return [self.mode.friction * value for value in self.v2[:-1]]
        series = [self._force(n) for n in range(self.order + 1)]
        if function == HOLD_PLUS:
            series = [-value for value in series]
        return [scene.N + series[0]] + series[1:]

    def _relative_polynomial(self, function):
        scene = self.scene
        if function == GAP:
            factor, constant = scene.stop_sign, scene.G
            if self.mode.contact:
                factor, constant = -factor, -constant
        else:
            factor, constant = (1, -scene.rest_distance) if self.mode.violated else (-1, scene.rest_distance)
        series = [factor * (a - b) for a, b in zip(self.x1, self.x2, strict=True)]
        return [series[0] + constant] + series[1:]

    def advance(self, limit):
        """One step to its end, to the first event within it or to `limit`; returns (time, event function or
        NOTHING).
        """
        length = limit - self.t0
        h = self.h if self.h < length else length
        end = limit if self.h >= length else self.kit.exact(self.t0 + h)
        if end <= self.t0:
            self.certificate.doubt(self.t0)
            return self.kit.next_after(self.t0, inf), NOTHING
        found = NOTHING
        for function in self.functions:
            coefficients = self.polynomial(function)
            known = self.known.get(function, 0)
            t, zero = self.search.first_root(coefficients, known, self.t0, h, function == GAP)
            if t is not None and (t < end or (zero and found == NOTHING)):
                end, found = t, function if zero else NOTHING
                h = end - self.t0
            if h == 0:  # an event at the start: no other can come before it
                break
        if found != NOTHING:
            self._certify_order(found, end)
        return end, found

    def _certify_order(self, first, end):
        """Doubt that the zero of `first`, at time `end`, is the first, where another event function may be
        zero as soon. Two names of one function vanish together.
        """
        near = {function: self._near_zero(function, end - self.t0) for function in self.functions}
        value, slope, noise = near[first]
        if slope >= 0:  # a touch is in doubt by itself
            return
        latest = latest_zero(self.kit, value, slope, noise, end)
        for function, there in near.items():
            if function == first or there is None:
                continue
            other, fall, blur = there
            if (other, fall) != (value, slope) and may_vanish_by(other, fall, blur, latest):
                self.certificate.doubt(self.t0)

    def _near_zero(self, function, tau):
        known = self.known.get(function, 0)
        return self.search.near_zero(self.polynomial(function), known, tau, self._magnitude(function))

    def _magnitude(self, function):
        """Sum of the magnitudes that an event function is made of at the expansion point."""
        scene, places = self.scene, abs(self.x1[0]) + abs(self.x2[0])
        if function == GAP:
            return places + abs(scene.G)
        if function == CLEARANCE:
            return places + abs(scene.rest_distance)
        speeds = abs(self.v1[0]) + abs(self.v2[0])
        if function == SLIDE:
            return speeds
        return self.k * places + scene.c * speeds + abs(self.offset) + scene.N

    def longest_piece(self, _tau):
        """Longest stretch [s] that one quadrature rule integrates to round-off: a whole step."""
        return inf

    def state_at(self, t):
        """State at time t within the step."""
        state = self.state_after(t - self.t0)
        state.t = t
        return state

    def state_after(self, tau):
        """State a time tau after the expansion point, which need not be on the time grid."""
        kit = self.kit
        zero, t = kit.number(0), self.t0 + tau
        x1, v1 = horner(self.x1, tau), horner(self.v1, tau)
        x2, v2 = (self.x2[0], zero) if self.locked else (horner(self.x2, tau), horner(self.v2, tau))
        if not self.scene.has_motor:
            return State(t, x1, v1, x2, v2, zero, zero, zero)
        phase, turns = kit.reduce_angle(horner(self.phi, tau))
        return State(t, x1, v1, x2, v2, phase, self.start.turns + turns, horner(self.w, tau))

    def relative_jet(self, state, mode, count):
        """Derivatives of y = x1 - x2 of order 0 to `count` at `state` in `mode`, whatever the order of the
        steps.
        """
        order, self.order = self.order, max(self.order, count)
        self.enter(state, mode, {})
        self.order = order
        factorial, jet = 1, []
        for n in range(count + 1):
            factorial = factorial * n if n > 0 else 1
            jet.append((self.x1[n] - self.x2[n]) * factorial)
        return jet

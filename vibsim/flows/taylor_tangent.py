"""How small disturbances move along one step of the Taylor flow.

The recurrences of the flow, linearised. With s = sin phi, c = cos phi, a1 = dv1/dt and A1 = d(dv1)/dt, Eqs.
(2.8)-(2.10) give for a disturbance (dy, dv1, dv2, dphi, dw), y = x1 - x2,
    (m1 + m3) A1 - m3 e s dw' = m3 e (q' - s dw') - dS,            q = c w dphi + s dw
    (J + m3 e^2) dw' - m3 e s A1 = m3 e c a1 dphi - (M0 / Omega0) dw
with s dw' on the left at the expansion point. The series of a disturbance end one order below the flow's,
whose steps keep its last two orders below the tolerance. A flow at rest, or on a slow path of strong damping,
may take steps that are too long for its disturbances: then these go in pieces.
"""

from math import log

from vibsim.flows.taylor_volume import log_volume
from vibsim.physics.disturbance import DV2
from vibsim.physics.numbers import horner

REACH = 1.25  # how much further than exp(-t) of the same order the steps of ordinary vibrations go, at most


class TaylorTangent:
    """Moves disturbances along the step that `flow` has just done."""

    def __init__(self, scene, kit, flow):
        self.scene, self.kit, self.flow, self.base = scene, kit, flow, flow
        self.motor = scene.has_motor
        self.dragging = kit.number(0)  # rate at which the motor's drag damps it, at most [1/s]
        if self.motor:
            mass, inertia = scene.m1 + scene.m3, scene.J + flow.unbalance * scene.e
            self.drag = scene.M0 / scene.Omega0
            self.dragging = self.drag * mass / (mass * inertia - flow.unbalance * flow.unbalance)
        spread = 0.0
        for n in range(2, flow.order + 1):
            spread = spread + log(n)
        self.reach = kit.power_of_two((flow.tolerance_exponent + spread / log(2.0)) / flow.order)

    def piece_end(self, t, end, _mark):
        """End [s] of the piece from t that is moved at once: as a rule the whole step."""
        flow = self.flow
        mobility = flow.per_m1 if flow.locked else flow.per_m1 + flow.per_m2
        rate, damping = self.kit.sqrt(flow.k * mobility) / REACH, self.scene.c * mobility
        rate = damping if damping > rate else rate
        if self.motor:
            rate = self.dragging if self.dragging > rate else rate
            turning = abs(flow.w[0]) / REACH
            rate = turning if turning > rate else rate
        ahead = t + self.reach / rate if rate > 0 else end
        return ahead if t < ahead < end else end

    def prepare(self, t, end):
        """What the recurrences of all disturbances share over the piece from t to `end` [s]."""
        self.tau = end - t
        if self.motor:
            self.base = self.flow if t == self.flow.t0 else self._expanded_at(t)
            self._prepare_motor()

    def _expanded_at(self, t):
        """The flow expanded anew at t [s], within its step."""
        base = type(self.flow)(self.scene, self.kit)
        base.enter(self.flow.state_at(t), self.flow.mode, {})
        return base

    def _prepare_motor(self):
        """Series c w = s' and c a1, and the mass matrix at the expansion point."""
        scene, flow = self.scene, self.base
        p, s, c = flow.order, flow.s, flow.c
        a1 = [(n + 1) * flow.v1[n + 1] for n in range(p - 1)]
        self.turning = [(n + 1) * s[n + 1] for n in range(p)]
        self.pull = [chained(self.kit.number(0), c, a1, n) for n in range(p - 1)]
        mass, inertia = scene.m1 + scene.m3, scene.J + flow.unbalance * scene.e
        coupling = flow.unbalance * s[0]
        inverse_det = 1 / (mass * inertia - coupling * coupling)
        self.to_a1, self.to_w, self.cross = inertia * inverse_det, mass * inverse_det, coupling * inverse_det

    def moved(self, vector):
        """The disturbance that `vector` becomes over the piece prepared last; while block 2 rests its dv2
        stays, without effect on the others.
        """
        resting = vector[DV2]
        self.y, self.u1, self.u2, self.phi, self.w = ([value] for value in vector)
        self.a1 = []
        if self.flow.locked:
            self.u2 = [self.kit.number(0)]
        for n in range(self.flow.order - 1):
            if self.motor:
                self._accelerate_motor(n)
            else:
                self._accelerate_ideal(n)
        series = (self.y, self.u1, self.u2, self.phi, self.w)
        y, v1, v2, phi, w = (horner(coefficients, self.tau) for coefficients in series)
        return [y, v1, resting if self.flow.locked else v2, phi, w]

    def _force(self, n):
        """Coefficient n of dS."""
        return self.flow.k * self.y[n] + self.scene.c * (self.u1[n] - self.u2[n])

    def _accelerate_ideal(self, n):
        """Coefficients n + 1 from those of order n: m1 A1 = -dS, m2 A2 = dS."""
        force, zero = self._force(n), self.kit.number(0)
        self._advance(n, -(force * self.flow.per_m1), force)
        self.phi.append(zero)
        self.w.append(zero)

    def _accelerate_motor(self, n):
        """Coefficients n + 1 from those of order n and below: one 2x2 division."""
        flow, phi, w = self.flow, self.phi, self.w
        inverse = flow.inverse[n + 1]
        phi.append(w[n] * inverse)
        tail, back = self._products(n)
        force = self._force(n)
        thrust = flow.unbalance * ((n + 1) * tail) - force
        torque = flow.unbalance * back - self.drag * w[n]
        a1 = self.to_a1 * thrust + self.cross * torque
        w.append((self.to_w * torque + self.cross * thrust) * inverse)
        self.a1.append(a1)
        self._advance(n, a1, force)

    def _advance(self, n, a1, force):
        flow = self.flow
        inverse = flow.inverse[n + 1]
        self.y.append((self.u1[n] - self.u2[n]) * inverse)
        self.u1.append(a1 * inverse)
        self.u2.append(self.kit.number(0) if flow.locked else force * flow.per_m2 * inverse)

    def _products(self, n):
        """Coefficient n + 1 of q without s_0 dw_(n+1), and n of c a1 dphi + s A1 without s_0 A1_n.

        The newest terms come last; the others are summed in an odd and an even chain, those with dphi apart
        from those with s: four chains that a processor takes side by side.
        """
        s, turning, pull, phi, w, a1 = self.base.s, self.turning, self.pull, self.phi, self.w, self.a1
        zero = self.kit.number(0)
        turned, driven = [[zero, zero], [zero, zero]], [[zero, zero], [zero, zero]]
        for i in range(2, n + 1):
            one, other = turned[i % 2], driven[i % 2]
            one[0] = one[0] + turning[i + 1] * phi[n - i]
            one[1] = one[1] + pull[i] * phi[n - i]
            other[0] = other[0] + s[i] * w[n + 1 - i]
            other[1] = other[1] + s[i] * a1[n - i]
        tail, back = ((turned[0][k] + turned[1][k]) + (driven[0][k] + driven[1][k]) for k in (0, 1))
        if n > 0:
            tail = tail + turning[2] * phi[n - 1]
            back = back + pull[1] * phi[n - 1]
            tail = tail + s[1] * w[n]
            back = back + s[1] * a1[n - 1]
        tail = tail + turning[1] * phi[n]
        back = back + pull[0] * phi[n]
        tail = tail + turning[0] * phi[n + 1]
        tail = tail + s[n + 1] * w[0]
        return tail, back

    def log_volume(self, _t, _end):
        """Logarithm of the growth of a volume of disturbances over the piece prepared last (Liouville)."""
        return log_volume(self.scene, self.kit, self.base, self.tau)


def chained(zero, c, a, n):
    """Coefficient n of the product of two series, its even and odd terms summed apart."""
    sums = [zero, zero]
    for i in range(n + 1):
        sums[i % 2] = sums[i % 2] + c[i] * a[n - i]
    return sums[0] + sums[1]

"""Taylor series of the rotor of a motor, beside those of its body.

With s = sin phi, c = cos phi and w = dphi/dt three products of series are all, because
    s dw/dt + w^2 c = d(s w)/dt,      s' = c w,      c' = -s w      (Eqs. 2.9, 2.10 of the paper).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.modes.rows import ModeRows
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import Motor


class RotorSeries(Generic[N]):
    """Series of angle, speed, sine, cosine and the acceleration a1 of the motor's group.

    inverse : 1 / k of each order k
    """

    def __init__(self, kit: Kit[N], motor: Motor[N], order: int, inverse: Sequence[N]) -> None:
        self.kit, self.motor, self.order, self.inverse = kit, motor, order, inverse
        self.unbalance, self.drag, self.inertia = motor.unbalance, motor.drag, motor.inertia

    def expand(self, state: State[N], rows: ModeRows[N]) -> None:
        """Start of the series at `state`, and the mass matrix there."""
        kit, motor, p = self.kit, self.motor, self.order
        zero = kit.number(0)
        self.w, self.phi = [state.w] + [zero] * (p + 1), [state.phase] + [zero] * (p + 1)
        sine, cosine = kit.sine_cosine(state.phase)
        self.s, self.c = [sine] + [zero] * p, [cosine] + [zero] * p
        self.a1 = [zero] * p
        self.coupling = self.unbalance * self.s[0]
        self.leader = rows.leader[motor.on]
        self.carried = rows.mass[self.leader]
        if self.carried is not None:
            mass = self.carried + motor.m3
            inverse_det = 1 / (mass * self.inertia - self.coupling * self.coupling)
            self.to_a1, self.to_w = self.inertia * inverse_det, mass * inverse_det
            self.cross = self.coupling * inverse_det
        self.sw = self.s[0] * self.w[0]

    def rotate(self, n: int, F: list[N]) -> None:
        """Order n of the series as far as it is known before the accelerations are; its thrust onto F.

        All that does not wait for w[n] and a1[n - 1] comes first: few operations are then left between one
        order and the next.
        """
        thrust = self._rotate_on(n) if n > 0 else self._start_rotation()
        F[self.leader] = F[self.leader] + thrust

    def _start_rotation(self) -> N:
        w0 = self.w[0]
        self.c[1] = -self.sw
        self.s[1] = self.c[0] * w0
        self.pull = self.unbalance * self.s[1]
        self.tail = self.s[1] * w0
        self.torque = self.motor.torque(w0)
        return self.unbalance * self.tail

    def _rotate_on(self, n: int) -> N:
        s, c, w, inverse = self.s, self.c, self.w, self.inverse[n + 1]
        scale, lean = self.unbalance * (n + 1), c[0] * inverse
        cw, tail, back = self._products(n)
        ahead = (cw + c[n] * w[0]) * inverse
        known, slope = tail + ahead * w[0], s[1] + lean * w[0]
        c[n + 1] = -(self.sw * inverse)
        s[n + 1] = ahead + lean * w[n]
        self.tail = known + slope * w[n]
        self.torque = (self.unbalance * back - self.drag * w[n]) + self.pull * self.a1[n - 1]
        return scale * known + scale * slope * w[n]

    def turn(self, n: int, thrust: N, base: N | None) -> N:
        """Acceleration of the motor's group, which the force `thrust` acts on, and of the rotor: one 2x2
        division by the mass matrix.

        base : coefficient n + 1 of the velocity of the base where the group is tied to it
        """
        inverse = self.inverse[n + 1]
        if self.carried is not None:
            a1 = self.to_a1 * thrust + self.cross * self.torque
            self.w[n + 1] = self.to_w * inverse * self.torque + self.cross * inverse * thrust
        else:  # tied to the ground or the base: its acceleration is given
            a1 = self.kit.number(0) if base is None else (n + 1) * base
            self.w[n + 1] = (self.torque + self.coupling * a1) / self.inertia * inverse
        self.a1[n] = a1
        self.phi[n + 1] = self.w[n] * inverse
        self.sw = self.tail + self.s[0] * self.w[n + 1]
        return a1

    def close(self) -> None:
        """The last coefficient of the angle."""
        p = self.order
        self.phi[p + 1] = self.w[p] * self.inverse[p + 1]

    def _products(self, n: int) -> list[N]:
        """The inner terms of (c w)_n, (s w)_(n+1) and (s a1)_n, those that do not wait for the newest
        coefficients.

        Odd and even terms are summed apart: two chains that a processor takes side by side.
        """
        s, c, w, a1, zero = self.s, self.c, self.w, self.a1, self.kit.number(0)
        sums = [[zero, zero, zero], [zero, zero, zero]]
        for i in range(1, n):
            part = sums[(i + 1) % 2]
            part[0] = part[0] + c[i] * w[n - i]
            part[1] = part[1] + s[i + 1] * w[n - i]
            part[2] = part[2] + s[i + 1] * a1[n - 1 - i]
        return [odd + even for odd, even in zip(*sums, strict=True)]

    def thrust(self) -> list[N]:
        """Series of the force on the motor's body, d(s w)/dt times its unbalance less the inertia of m3."""
        sw = [self.kit.number(0)] * (self.order + 1)
        for n in range(self.order + 1):
            for i in range(n + 1):
                sw[n] = sw[n] + self.s[i] * self.w[n - i]
        return [
            self.unbalance * ((n + 1) * sw[n + 1]) - self.motor.m3 * self.a1[n] for n in range(self.order)
        ]

    def spin_rate(self, tau: N) -> N:
        """Rate of the speed of the rotor [rad/s^2] a time tau after the expansion point."""
        rate = self.order * self.w[self.order]
        for n in range(self.order - 1, 0, -1):
            rate = rate * tau + n * self.w[n]
        return rate

"""Unbalanced rotors on bodies: Taylor series of their pull on the bodies, and the mass matrix.

A rotor i with the angle phi, the speed w, the unbalance u = m e and the inertia I = J + m e^2 on a body of a
group of mass M, its own mass among it:

    M a = F + sum u_i (s w)',       I_i w_i' = T_i + u_i s_i a,       s = sin phi, c = cos phi

with (s w)' = s w' + w^2 c (Eqs. 2.9, 2.10 of the paper). Rotors meet in their bodies alone, so that the mass
matrix is inverted by one division at the expansion point: by M - sum (u_i s_i)^2 / I_i. Of each sum the
newest terms come last: little then waits for them (`tape.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from vibsim.engine.flows.tape import middle
from vibsim.engine.modes.rows import ModeRows, RotorOn
from vibsim.physics.numbers import Kit, N
from vibsim.physics.parts import Scene


class Rotors(Generic[N]):
    """Series of sine and cosine of the rotors, and of the accelerations of the groups that they are on.

    inverse : 1 / k of each order k
    """

    def __init__(self, scene: Scene[N], kit: Kit[N], order: int, inverse: Sequence[N]) -> None:
        self.kit, self.order, self.inverse, self.n = kit, order, inverse, len(scene.bodies)

    def expand(self, x: list[list[N]], v: list[list[N]], rows: ModeRows[N]) -> None:
        """Begin at the state that the series x, v of the columns begin with."""
        self.x, self.v, self.rows, kit = x, v, rows, self.kit
        self.s: list[list[N]] = []
        self.c: list[list[N]] = []
        for one in rows.rotors:
            sine, cosine = kit.rounded_sine_cosine(kit.reduce_angle(x[one.column][0])[0])
            self.s.append([sine])
            self.c.append([cosine])
        self.pulled = [kit.number(0) for _ in rows.rotors]  # coefficient of s w without the newest speed
        self.lean = [one.unbalance * s[0] / one.inertia for one, s in zip(rows.rotors, self.s, strict=True)]
        self.groups = sorted({rows.leader[one.on] for one in rows.rotors})
        self.a: dict[int, list[N]] = {leader: [] for leader in self.groups}
        self.mass = {leader: self._mass(leader) for leader in self.groups}
        self.mobility = {leader: None if mass is None else 1 / mass for leader, mass in self.mass.items()}

    def _on(self, leader: int) -> list[tuple[int, RotorOn[N]]]:
        return [(i, one) for i, one in enumerate(self.rows.rotors) if self.rows.leader[one.on] == leader]

    def _mass(self, leader: int) -> N | None:
        """Mass of a group less what its rotors take part of it with; None where it does not move on its
        own.
        """
        mass = self.rows.mass[leader]
        if mass is None:
            return None
        for i, one in self._on(leader):
            coupling = one.unbalance * self.s[i][0]
            mass = mass - coupling * coupling / one.inertia
        return mass

    def turn(self, n: int, F: list[N], acceleration: list[N]) -> None:
        """Accelerations of order n of rotors and of the groups that they are on, where F are the forces and
        torques on all groups.
        """
        for i, one in enumerate(self.rows.rotors):
            self._rotate(i, n, self.v[one.column])
        for leader in self.groups:
            rotors = self._on(leader)
            torques = [F[one.column] + one.unbalance * self._back(i, n, leader) for i, one in rotors]
            mobility = self.mobility[leader]
            if mobility is None:
                a = self._given(n, leader)
            else:
                force = F[leader]
                for (i, one), torque in zip(rotors, torques, strict=True):
                    pull = one.unbalance * (n + 1) * self.pulled[i]
                    force = force + (pull + self.lean[i] * torque)
                a = force * mobility
            self.a[leader].append(a)
            acceleration[leader] = a
            for (i, one), torque in zip(rotors, torques, strict=True):
                acceleration[one.column] = torque * (1 / one.inertia) + self.lean[i] * a

    def _given(self, n: int, leader: int) -> N:
        """Coefficient n of the acceleration of ground or base."""
        return (n + 1) * self.v[leader][n + 1] if leader == self.n + 1 else self.kit.number(0)

    def _rotate(self, i: int, n: int, w: Sequence[N]) -> None:
        """Coefficient n + 1 of sine and cosine, and the pull."""
        s, c = self.s[i], self.c[i]
        cosines = c[0] * w[n]
        if n > 0:
            cosines = middle(self.kit, c, w, n - 1, n) + (cosines + c[n] * w[0])
        sines = self.pulled[i] + s[0] * w[n]
        s.append(cosines * self.inverse[n + 1])
        c.append(-(sines * self.inverse[n + 1]))
        self.pulled[i] = self._pull(i, n, w)

    def _pull(self, i: int, n: int, w: Sequence[N]) -> N:
        """Coefficient n + 1 of s w without the term of the speed that is not known yet."""
        s = self.s[i]
        if n == 0:
            return s[1] * w[0]
        return middle(self.kit, s, w, n - 1, n, ahead=1) + (s[1] * w[n] + s[n + 1] * w[0])

    def _back(self, i: int, n: int, leader: int) -> N:
        """Coefficient n of s a without the term of the acceleration that is not known yet."""
        s, a = self.s[i], self.a[leader]
        if n == 0:
            return self.kit.number(0)
        return middle(self.kit, s, a, n - 1, n - 1, ahead=1) + s[1] * a[n - 1]

    def turning_alone(self) -> list[list[N]]:
        """Series of the sines of the rotors on what does not move on its own: nothing else tells how they
        turn.
        """
        rotors = zip(self.s, self.rows.rotors, strict=True)
        return [sine for sine, one in rotors if self.mobility[self.rows.leader[one.on]] is None]

    def thrust(self, column: int) -> list[N]:
        """Series of the force of the rotors on a column, as far as those of the rotors are known."""
        total = [self.kit.number(0)] * self.order
        for i, one in enumerate(self.rows.rotors):
            if one.on == column:
                w = self.v[one.column]
                for n in range(min(self.order, len(self.s[i]) - 1)):
                    last = self._pull(i, n, w) + self.s[i][0] * w[n + 1]
                    total[n] = total[n] + one.unbalance * ((n + 1) * last)
        return total

"""Rounding bounds of the Taylor coefficients at a state, which is exact, or rounded itself.

A derivative whose terms cancel is what their rounding left of it: on its sign nothing may rest. So the
recurrences of the `Taylor` flow are gone through once more, and each operation adds the rounding of its
result to that of what it is made of. There is none where every term is zero, nor in a sum of exact terms that
is zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from vibsim.engine.flows.base_motion import base_rounding
from vibsim.engine.flows.motion import ROUNDING, series_rounding
from vibsim.engine.flows.tape import Inputs, TapeRounding
from vibsim.engine.flows.taylor import Taylor
from vibsim.engine.modes.rows import (
    ACCELERATION,
    COUPLING,
    DIFFERENCE,
    FORMULA,
    HOLD,
    PUSH,
    RATE,
    Coupling,
    Event,
    Term,
)
from vibsim.physics.numbers import N, abs

ROTATION = 64  # of a coefficient of what a rotor does, some ten products of series one behind the other


class TaylorRounding(Generic[N]):
    """Bounds for all columns up to order `highest`, of what `flow` has expanded last; exact: whether its
    state is a start, and not what a motion led to.

    span : time [s] before that state for which its series are taken to tell how large displacements and
        velocities were, whose rounding it has, however small it is itself; 0 for its own
    """

    def __init__(self, flow: Taylor[N], highest: int, exact: bool, span: N | int = 0) -> None:
        self.flow, self.kit, self.rows = flow, flow.kit, flow.rows
        zero, columns = flow.kit.number(0), range(flow.n + 2)
        self.once, self.product = flow.kit.eps, ROUNDING * flow.kit.eps
        self.x = [[zero] * (highest + 1) for _ in columns]
        self.v = [[zero] * (highest + 1) for _ in columns]
        self.w = [zero] * (highest + 1)
        self.load = [[zero] * highest for _ in columns]
        self.angle = zero  # of the rotor [rad]
        flow.reach(highest if span == 0 else flow.order)
        self._start(highest, exact, span)
        for n in range(highest):
            self._advance(n)

    def _start(self, highest: int, exact: bool, span: N | int) -> None:
        """The state, and base and loads, of all orders."""
        flow, base, t = self.flow, self.flow.n + 1, self.flow.t0
        moved = base_rounding(flow.scene, self.kit, t, highest + 2)
        self.x[base], self.v[base] = moved[:-1], [(n + 1) * e for n, e in enumerate(moved[1:])]
        for c in range(flow.n):
            if not exact:
                self.x[c][0] = self.product * largest_term(flow.x[c], span)
                self.v[c][0] = self.product * largest_term(flow.v[c], span)
            if self.rows.leader[c] == base:
                self.v[c] = list(self.v[base])
        if flow.rotor:
            self.angle = self.once * abs(flow.rotor.phi[0])  # pi / 2 is none of the numbers
            if not exact:
                self.w[0] = self.product * abs(flow.rotor.w[0])
                self.angle = self.product + self.product * abs(flow.rotor.phi[0])
        if flow.tape:
            zero = self.kit.number(0)
            late = zero if exact else self.once * abs(t)
            self.tape = TapeRounding(flow.tape, self.product, Inputs(late, (), (), self.angle, self.w[0]))
        for force in flow.scene.forces:
            errors = series_rounding(self.kit, force.terms, t, highest)
            total = self.flow.load[force.on]
            assert total is not None  # there is this force
            self.load[force.on] = [
                old + e + self.once * abs(value)
                for old, e, value in zip(self.load[force.on], errors, total, strict=False)
            ]

    def _advance(self, n: int) -> None:
        """Coefficients n + 1 from those of order n."""
        flow, rows = self.flow, self.rows
        leader, inverse = rows.leader, flow.inverse[n + 1]
        self.force = [self.kit.number(0)] * (flow.n + 2)
        self.lost = list(self.force)
        for c in range(flow.n):
            load = flow.load[c]
            if load is not None:
                self._push(leader[c], load[n], self.load[c][n])
        for one in rows.couplings:
            value, lost = flow.coupling_force(one, n), self._of_coupling(one, n)
            self._push(leader[one.P], -value, lost)
            self._push(leader[one.Q], value, lost)
        for column, value in rows.constants if n == 0 else ():
            self._push(leader[column], value, self.kit.number(0))
        if flow.tape:
            self.tape.advance(n, self.x, self.v, self.w)
            for law in rows.formulas:
                value, lost = law.sign * flow.tape.output(law.output)[n], self.tape.output(law.output)[n]
                self._push(leader[law.P], value, lost)
                if law.Q >= 0:
                    self._push(leader[law.Q], -value, lost)
        lost_by_speed = [lost * mobility for lost, mobility in zip(self.lost, rows.mobility, strict=True)]
        if flow.rotor:
            self._turn(n, lost_by_speed)
        if flow.rotors:
            self._turn_all(n, lost_by_speed)
        for c in range(flow.n):
            self.x[c][n + 1] = self.v[c][n] * inverse + self.once * abs(flow.x[c][n + 1])
            if leader[c] < flow.n:
                own = self.product * abs(flow.v[c][n + 1])
                self.v[c][n + 1] = lost_by_speed[leader[c]] * inverse + own
            if c in rows.follow:
                self.v[c][n + 1] = self.v[c][n + 1] + self.tape.output(rows.follow[c])[n] * inverse

    def _push(self, column: int, value: N, lost: N) -> None:
        """Add a force and its rounding to those on a group."""
        self.force[column] = self.force[column] + value
        self.lost[column] = self.lost[column] + lost + self.once * abs(self.force[column])

    def _turn(self, n: int, lost_by_speed: list[N]) -> None:
        """Rounding of the accelerations that the rotor takes part in: of its body's group, and its own."""
        rotor, motor = self.flow.rotor, self.flow.scene.motor
        assert rotor is not None and motor is not None
        on, inverse, each = rotor.leader, self.flow.inverse[n + 1], ROTATION * self.kit.eps
        thrust = torque = self.kit.number(0)
        for i in range(n + 2):
            sine = abs(rotor.s[i])
            speed = abs(rotor.w[n + 1 - i])
            thrust = thrust + sine * (each * speed + self.w[n + 1 - i]) + self.angle * abs(rotor.c[i]) * speed
            torque = torque + (sine * abs(rotor.a1[n - i]) if i <= n else 0)
        lost = self.lost[on] + rotor.unbalance * (n + 1) * thrust + each * abs(self.force[on])
        spun = rotor.drag * (abs(rotor.w[n]) + self.w[n] / each) + rotor.unbalance * torque
        spun = each * (spun + motor.M0 if n == 0 else spun)
        if rotor.carried is not None:
            lost_by_speed[on] = rotor.to_a1 * lost + abs(rotor.cross) * spun
            self.w[n + 1] = (rotor.to_w * spun + abs(rotor.cross) * lost) * inverse
        else:
            self.w[n + 1] = spun / rotor.inertia * inverse

    def _turn_all(self, n: int, lost_by_speed: list[N]) -> None:
        """The same of the rotors on bodies."""
        flow, rotors, each = self.flow, self.flow.rotors, ROTATION * self.kit.eps
        assert rotors is not None
        lost = dict.fromkeys(rotors.groups, self.kit.number(0))
        twisted: list[N] = []
        for i, one in enumerate(self.rows.rotors):
            group, w, bounds = self.rows.leader[one.on], flow.v[one.column], self.v[one.column]
            thrust = torque = self.kit.number(0)
            angle = self.x[one.column][0] + self.once * abs(flow.x[one.column][0])
            for k in range(n + 2):
                sine, speed = abs(rotors.s[i][k]), abs(w[n + 1 - k])
                slow = bounds[n + 1 - k] if n + 1 - k <= n else self.kit.number(0)
                thrust = thrust + sine * (each * speed + slow) + angle * abs(rotors.c[i][k]) * speed
                torque = torque + (sine * abs(rotors.a[group][n - k]) if k <= n else 0)
            twist = self.lost[one.column] + each * one.unbalance * torque
            twisted.append(twist)
            lost[group] = lost[group] + one.unbalance * ((n + 1) * thrust + twist / one.inertia)
        for group in rotors.groups:
            mass = rotors.mass[group]
            if mass is not None:
                lost_by_speed[group] = (self.lost[group] + lost[group] + each * abs(self.force[group])) / abs(
                    mass
                )
        for one, twist in zip(self.rows.rotors, twisted, strict=True):
            pulled = one.unbalance * lost_by_speed[self.rows.leader[one.on]]
            lost_by_speed[one.column] = (twist + pulled) / one.inertia

    def _of_difference(self, P: int, Q: int, n: int, rates: bool) -> N:
        """Of x_P - x_Q, or of its rate."""
        of, values = (self.v, self.flow.v) if rates else (self.x, self.flow.x)
        if n > 0 and self.rows.leader[P] == self.rows.leader[Q]:  # one motion
            return self.kit.number(0)
        return of[P][n] + of[Q][n] + self.once * abs(values[P][n] - values[Q][n])

    def _of_coupling(self, one: Coupling[N], n: int) -> N:
        x, v, P, Q = self.flow.x, self.flow.v, one.P, one.Q
        lost = one.k * self._of_difference(P, Q, n, False) + one.c * self._of_difference(P, Q, n, True)
        size = one.k * abs(x[P][n] - x[Q][n]) + one.c * abs(v[P][n] - v[Q][n])
        return lost + self.product * (size + abs(one.offset) if n == 0 else size)

    def derivatives(self, event: Event[N], count: int) -> list[N]:
        """Bounds of the rounding of `Taylor.derivatives`."""
        series = [self.flow._term(term) for term in event.terms]
        factorial = self.kit.number(1)
        bounds: list[N] = []
        for n in range(count + 1):
            factorial = factorial * n if n > 0 else factorial
            bounds.append(factorial * self._of_event(event, [one[n] for one in series], n))
        return bounds

    def _of_event(self, event: Event[N], values: Sequence[N], n: int) -> N:
        lost = total = self.kit.number(0)
        for term, value in zip(event.terms, values, strict=True):
            total = total + value
            lost = lost + self._of_term(term, value, n) + self.once * abs(total)
        if n > 0:
            return lost
        lost = lost + self.once * abs(total + event.constant)
        return lost + self.once * event.size if self._is_sum(event) else lost

    def _is_sum(self, event: Event[N]) -> bool:
        """Whether the constant of an event function is rounded, and no number of the scene itself."""
        if event.kind == HOLD:
            return bool(self.rows.constants) or len(self.rows.cuts[event.part].ties) > 1
        return event.kind == PUSH

    def _of_term(self, term: Term[N], value: N, n: int) -> N:
        size, P, Q = abs(term.coefficient), term.P, term.Q
        if term.kind == DIFFERENCE:
            return size * self._of_difference(P, Q, n, False) + (self.once * abs(value) if size != 1 else 0)
        if term.kind == RATE:
            return size * self._of_difference(P, Q, n, True) + (self.once * abs(value) if size != 1 else 0)
        if term.kind == COUPLING:
            return size * self._of_coupling(self.rows.couplings[P], n)
        if term.kind == ACCELERATION:
            return size * (n + 1) * self.v[P][n + 1] + self.product * abs(value)
        if term.kind == FORMULA:
            return size * self.tape.output(P)[n] + self.product * abs(value)
        return size * self.load[P][n] + self._of_thrust(P, n)

    def _of_thrust(self, column: int, n: int) -> N:
        """Of what a motor exerts on a column while that is tied to the ground or the base."""
        rotor, motor = self.flow.rotor, self.flow.scene.motor
        if rotor is None or motor is None or motor.on != column:
            return self.kit.number(0)
        size = motor.m3 * abs(rotor.a1[n])
        turned = self.kit.number(0)
        for i in range(n + 2):
            size = size + rotor.unbalance * (n + 1) * abs(rotor.s[i] * rotor.w[n + 1 - i])
            turned = turned + rotor.unbalance * (n + 1) * abs(rotor.c[i] * rotor.w[n + 1 - i])
        return ROTATION * self.kit.eps * size + self.angle * turned


def largest_term(series: Sequence[N], span: N | int) -> N:
    """The largest size of the terms of a series in time, after `span` [s]."""
    largest, power = abs(series[0]), 1 + 0 * span
    for coefficient in series[1:]:
        power = power * span
        size = abs(coefficient * power)
        largest = size if size > largest else largest
    return largest


class PythonExpansion(Taylor[N]):
    """What `Expansion` is to the engine in C."""

    def bounds(self, event: Event[N], count: int, exact: bool, span: N | int = 0) -> list[N]:
        """Bounds of the rounding of derivatives."""
        return TaylorRounding(self, count + 1, exact, span).derivatives(event, count)

    def formulas(self) -> list[N]:
        """Values of the outputs of the tape of the mode."""
        values = self.tape_values(self.kit.number(0))
        return [values.output(k)[0] for k in range(len(values.tape.outputs))]

"""Taylor coefficients of the motion inside a mode, by recurrence from the balance of forces of each group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.flows.base_motion import series_in_time
from vibsim.engine.flows.motion import quarter_turns, sine_and_cosine
from vibsim.engine.flows.rotor_series import RotorSeries
from vibsim.engine.flows.rotors_on_bodies import Rotors
from vibsim.engine.flows.tape import TapeSeries
from vibsim.engine.modes.rows import Coupling, ModeRows
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import BODY, Scene

LEADING = 4  # coefficients that set the scale of a series in the step control


class TaylorExpansion(Generic[N]):
    """Series of all columns about a state, to an order of displacements that is one more than `order`.

    x, v : coefficients of displacement and velocity by column, then order; load : of the forces on each
    """

    def __init__(self, scene: Scene[N], kit: Kit[N], order: int) -> None:
        self.scene, self.kit, self.order = scene, kit, order
        self.tolerance_exponent = kit.tolerance_exponent(scene)
        self.n = len(scene.bodies)
        self.inverse = [kit.number(0)] + [1 / kit.number(k) for k in range(1, self.order + 4)]
        self.rotor = RotorSeries(kit, scene.motor, self.order, self.inverse) if scene.motor else None
        self.rotors = Rotors(scene, kit, self.order, self.inverse) if scene.rotors else None
        self.alone = [
            c for c, body in enumerate(scene.bodies) if body.kind != BODY or body.turns
        ]  # of units of their own
        self.tape: TapeSeries[N] | None = None
        self.reached = 0  # order of the coefficients so far
        self.nearest: N | int = 0  # time [s] within which zeros of bases of powers are zeros in any case

    def expand(self, state: State[N], rows: ModeRows[N]) -> None:
        """Coefficients of order 0 of all columns at `state` in a mode, and what they are driven by."""
        self.rows, self.reached = rows, 0
        zero, p = self.kit.number(0), self.order
        self.x = [[value] + [zero] * (p + 1) for value in (*state.x, zero, zero)]
        self.v = [[value] + [zero] * (p + 1) for value in (*state.v, zero, zero)]
        if self.scene.has_base:
            self._expand_base(state.t)
        for c in range(self.n):
            leader = self.rows.leader[c]
            # moves as the ground or the base, and its belts, say; belts by formulas are in its velocity
            if leader >= self.n and c not in self.rows.follow:
                self.v[c][0] = self.v[leader][0] + self.rows.drift[c]
        self._expand_loads(state.t)
        if self.rotor:
            self.rotor.expand(state, self.rows)
        if self.rotors:
            self.rotors.expand(self.x, self.v, self.rows)
        self.tape = None
        if rows.tape:
            self.tape = TapeSeries(self.kit, rows.tape, self.inverse)
            turning = (self.rotor.phi, self.rotor.w) if self.rotor else None
            self.tape.start(state.t, p, self.x, self.v, turning, self.nearest)

    def reach(self, order: int) -> None:
        """Coefficients up to `order`, of those expanded last."""
        for n in range(self.reached, min(order, self.order)):
            self._advance(n)
            self.reached = n + 1
            if self.reached == self.order:
                self._close()

    def _close(self) -> None:
        """The last coefficients, of displacements alone."""
        inverse = self.inverse[self.order + 1]
        for c in range(self.n):
            self.x[c][self.order + 1] = self.v[c][self.order] * inverse
        if self.rotor:
            self.rotor.close()

    def _expand_base(self, t: N) -> None:
        """Series of the base, X = sum of harmonics."""
        x, v = self.x[self.n + 1], self.v[self.n + 1]
        if self.rows.base_tape:
            series = series_in_time(self.kit, self.rows.base_tape, t, self.order + 3, self.inverse)
            x[:], v[:] = series[:-1], [n * value for n, value in enumerate(series)][1:]
            if self.scene.base_is_rate:
                integral = [value * inverse for value, inverse in zip(series, self.inverse[1:], strict=False)]
                x[:], v[:] = [self.kit.number(0), *integral][: len(x)], series[: len(v)]
            return
        for term in self.scene.base:
            turns = quarter_turns(*sine_and_cosine(self.kit, term, t))
            factor = term.amplitude
            for k in range(self.order + 2):
                x[k] = x[k] + factor * turns[k % 4]
                factor = factor * term.omega
                v[k] = v[k] + factor * turns[(k + 1) % 4]
                factor = factor * self.inverse[min(k + 1, self.order + 2)]

    def _expand_loads(self, t: N) -> None:
        """Series of the forces on the bodies; None where there is none."""
        self.load: list[list[N] | None] = [None] * (self.n + 2)
        for force in self.scene.forces:
            series = self.load[force.on] or [self.kit.number(0)] * self.order
            for term in force.terms:
                turns = quarter_turns(*sine_and_cosine(self.kit, term, t))
                factor = term.amplitude
                for k in range(self.order):
                    series[k] = series[k] + factor * turns[k % 4]
                    factor = factor * term.omega * self.inverse[k + 1]
            series[0] = series[0] + force.constant
            self.load[force.on] = series

    def coupling_force(self, coupling: Coupling[N], n: int) -> N:
        """Coefficient n of the force S of a coupling."""
        P, Q = coupling.P, coupling.Q
        force = coupling.k * (self.x[P][n] - self.x[Q][n]) + coupling.c * (self.v[P][n] - self.v[Q][n])
        return force + coupling.offset if n == 0 else force

    def _advance(self, n: int) -> None:
        """Coefficients n + 1 of displacements and velocities from those of order n."""
        rows, zero, inverse = self.rows, self.kit.number(0), self.inverse[n + 1]
        leader = rows.leader
        F = [zero] * (self.n + 2)
        for c in range(self.n):
            load = self.load[c]
            if load is not None:
                F[leader[c]] = F[leader[c]] + load[n]
        for coupling in rows.couplings:
            force = self.coupling_force(coupling, n)
            P, Q = leader[coupling.P], leader[coupling.Q]
            F[P] = F[P] - force
            F[Q] = F[Q] + force
        if n == 0:
            for column, value in rows.constants:
                F[leader[column]] = F[leader[column]] + value
        if self.tape:
            self._apply_formulas(self.tape, n, F)
        acceleration = [force * mobility for force, mobility in zip(F, rows.mobility, strict=True)]
        if self.rotors:
            self.rotors.turn(n, F, acceleration)
        if self.rotor:
            self.rotor.rotate(n, F)
            on = self.rotor.leader
            base = self.v[on][n + 1] if on == self.n + 1 else None
            acceleration[on] = self.rotor.turn(n, F[on], base)
        for c in range(self.n):
            self.x[c][n + 1] = self.v[c][n] * inverse
            if leader[c] == self.n + 1:
                self.v[c][n + 1] = self.v[self.n + 1][n + 1]
            elif leader[c] < self.n:
                self.v[c][n + 1] = acceleration[leader[c]] * inverse
        if self.tape:
            for c, output in rows.follow.items():
                self.v[c][n + 1] = self.v[c][n + 1] + self.tape.output(output)[n] * inverse

    def _apply_formulas(self, tape: TapeSeries[N], n: int, F: list[N]) -> None:
        """Add coefficient n of the forces by formulas to those on the groups."""
        tape.advance(n)
        leader = self.rows.leader
        for one in self.rows.formulas:
            force = one.sign * tape.output(one.output)[n]
            F[leader[one.P]] = F[leader[one.P]] + force
            if one.Q >= 0:
                F[leader[one.Q]] = F[leader[one.Q]] - force

    def step_length(self) -> N:
        """Longest step whose last two terms stay below tol times the largest leading one (after Jorba &
        Zou 2005), of velocities, rotor, and what ties must carry, which moves nothing.
        """
        self.reach(self.order)
        blocks: list[tuple[list[list[N]], int]] = [(self.v[: self.n], self.order)]
        if self.alone:
            bodies = [self.v[c] for c in range(self.n) if c not in self.alone]
            blocks = [(bodies, self.order)] if bodies else []
            blocks += [([self.v[c]], self.order) for c in self.alone]
        if self.scene.has_base:
            blocks[0][0].append(self.v[self.n + 1])
        if self.rotors:
            blocks += [([sine], self.order) for sine in self.rotors.turning_alone()]
        if self.rotor:
            blocks.append(([self.rotor.w], self.order))
            if self.rotor.carried is None:
                blocks.append(([self.rotor.s], self.order))
        loads = (self.load[c] for c in self.rows.tied)
        blocks += [([load], self.order - 1) for load in loads if load is not None]
        longest = 1000.0
        for block, highest in blocks:
            sizes = {n: self._size(block, n) for n in (*range(LEADING), highest - 1, highest)}
            for last in (highest - 1, highest):
                if sizes[last] > self.kit.no_exponent:
                    candidates = [
                        (self.tolerance_exponent + (sizes[m] - sizes[last])) / (last - m)
                        for m in range(min(LEADING, last))
                        if sizes[m] > self.kit.no_exponent
                    ]
                    longest = min(longest, max(candidates, default=longest))
        return self.kit.power_of_two(longest) if longest < 1000.0 else self.kit.inf

    def _size(self, block: Sequence[Sequence[N]], n: int) -> int:
        """Binary exponent of the summed coefficients n of a block of series."""
        total = abs(block[0][n])
        for series in block[1:]:
            total = total + abs(series[n])
        return self.kit.exponent(total)

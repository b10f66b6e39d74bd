"""How small disturbances move along one step of the Taylor flow.

The recurrences of the flow, linearised: loads and constants drop out, couplings pass dS = k dd + c dd',
formulas enter by their partial derivatives. With s = sin phi, c = cos phi, a1 the acceleration of the
motor's group, b = m3 e and dS the sum of these forces on the group,
    (m + m3) A1 - b s dw' = b (q' - s dw') - dS,            q = c w dphi + s dw
    (J + m3 e^2) dw' - b s A1 = b c a1 dphi - (M0 / Omega0) dw
with s dw' on the left at the expansion point. The series of a disturbance end one order below the flow's,
whose steps keep its last two orders below the tolerance. A flow at rest, or on a slow path of strong damping,
may take steps that are too long for its disturbances: then these go in pieces.
"""

from collections.abc import Callable, Sequence
from functools import cache, cached_property
from typing import Generic

from vibsim.engine.flows.rotor_series import RotorSeries
from vibsim.engine.flows.taylor import Taylor
from vibsim.engine.modes.rows import (
    ACCELERATION,
    COUPLING,
    DIFFERENCE,
    FORMULA,
    LOAD,
    Coupling,
    Event,
    Term,
)
from vibsim.engine.tangent.formula_tangent import LEAST_SHARE, TOGETHER, FormulaTangent, RotorTangent, Zero
from vibsim.engine.tangent.tangent_space import natural_rate
from vibsim.physics import elementary
from vibsim.physics.numbers import Kit, N, abs, horner, total_of
from vibsim.physics.parts import Scene

LEFT_OUT = 2.0**-47  # of a disturbance: the most that the last terms of its series may be
REACH = 1.25  # how much further than exp(-t) of the same order the steps of ordinary vibrations go, at most


def reach(kit: Kit[N], order: int, tolerance_exponent: float) -> N:
    """Longest step of exp(-t), by the tolerance on its last term."""
    return kit.power_of_two((tolerance_exponent + _spread(order) * elementary.PER_LN_2) / order)


@cache
def _spread(order: int) -> float:
    """ln order!, summed in its order."""
    spread = 0.0
    for n in range(2, order + 1):
        spread = spread + elementary.log(n)
    return spread


class TaylorTangent(Generic[N]):
    """Moves disturbances along the step that `flow` has just done."""

    def __init__(self, scene: Scene[N], kit: Kit[N], flow: Taylor[N]) -> None:
        self.scene, self.kit, self.flow, self.base = scene, kit, flow, flow
        self.n = len(scene.bodies)
        self.reach = reach(kit, flow.order, flow.tolerance_exponent)
        self.event_at: N | None = None  # time of the event that ends the stretch [s]

    def piece_end(self, t: N, end: N, _mark: N) -> N:
        """End [s] of the piece from t that is moved at once: as a rule the whole step."""
        rates = [self.kit.sqrt(self._fastest(lambda q: q.k)) / REACH, self._fastest(lambda q: q.c)]
        if self.flow.tape:
            own = FormulaTangent(self.kit, self._base_at(t))
            at_zero = self._piece_at_zero(own, t, end)
            if at_zero is not None:
                return at_zero
            tau = own.sound_step(end - t)
            sound = self.kit.exact(t + tau) if tau < end - t else end
            end = sound if t < sound else end
            stiff, damping = own.rates(tau)
            rates[0] = rates[0] + self.kit.sqrt(stiff) / REACH
            rates[1] = rates[1] + damping
        if self.flow.rotor:
            rates += [self._dragging(self.flow.rotor), abs(self.flow.rotor.w[0]) / REACH]
        rate = max(rates)
        ahead = t + self.reach / rate if rate > 0 else end
        return ahead if t < ahead < end else end

    def _piece_at_zero(self, own: FormulaTangent[N], t: N, end: N) -> N | None:
        """End [s] of a piece from t at whose start or end the base of a power is zero, and over which the
        derivatives have means; None where there is none. Where a derivative is infinite at the start and has
        no integral, the whole stretch: nothing is known behind it.
        """
        last, shortest, zeros = end, (end - t) * LEAST_SHARE, []
        while end - t > shortest:
            zeros = own.zeros(end - t, self._is_behind_event(t), self._is_event(end))
            if not zeros:
                return None
            if self._meets(own, zeros, end - t):
                return end
            if not any(one.first < one.last for one in zeros):
                return None
            end = self.kit.exact(t + (end - t) / 4)
        return None if all(one.mild for one in zeros) else last

    def _meets(self, own: FormulaTangent[N], zeros: list[Zero[N]], tau: N) -> bool:
        """Whether disturbances feel nothing but means over the stretch tau [s]."""
        series = own.series.series
        if not own.take_means(zeros, tau):
            return False
        stiff, damping = own.rates(0 * tau)
        own.series.series = series
        return stiff * tau * tau <= TOGETHER and damping * tau * (tau * self.rate) <= TOGETHER

    @cached_property
    def rate(self) -> N:
        """Rate [rad/s] at which displacements become velocities."""
        return natural_rate(self.scene, self.kit)

    def _is_behind_event(self, t: N) -> bool:
        return t == self.flow.t0 and any(self.flow.known.values())

    def _is_event(self, end: N) -> bool:
        return self.event_at is not None and end == self.event_at

    def _fastest(self, strength_of: Callable[[Coupling[N]], N]) -> N:
        """Bound of the largest eigenvalue of the couplings' differences, of stiffness [1/s^2] or of damping
        [1/s] by `strength_of`: the largest sum over a row (Gershgorin).
        """
        rows, zero = self.flow.rows, self.kit.number(0)
        leader, strength = rows.leader, [zero] * (self.n + 2)
        couplings = [q for q in rows.couplings if leader[q.P] != leader[q.Q]]
        for q in couplings:
            for end in (q.P, q.Q):
                strength[leader[end]] = strength[leader[end]] + strength_of(q)
        largest = zero
        for q in couplings:
            if strength_of(q) > 0:
                P, Q = leader[q.P], leader[q.Q]
                row = strength[P] * rows.mobility[P] + strength[Q] * rows.mobility[Q]
                largest = row if row > largest else largest
        return largest

    def _dragging(self, rotor: RotorSeries[N]) -> N:
        """Rate at which the motor's drag damps the rotor, at most [1/s]."""
        if rotor.carried is None:
            return rotor.drag / rotor.inertia
        mass = rotor.carried + rotor.motor.m3
        return rotor.drag * mass / (mass * rotor.inertia - rotor.unbalance * rotor.unbalance)

    def prepare(self, t: N, end: N, late: N | int = 0) -> None:
        """Prepares what the recurrences of all disturbances share over the piece from t to `late` behind
        `end` [s].
        """
        self.tau, self.base = (end - t) + late, self._base_at(t)
        self.is_too_long = self.is_undefined = False
        if self.base.rotor:
            self._prepare_motor(self.base.rotor)
        self.formulas = FormulaTangent(self.kit, self.base) if self.base.tape else None
        if self.formulas and t < end:
            zeros = self.formulas.zeros(end - t, self._is_behind_event(t), self._is_event(end))
            if zeros and not self.formulas.take_means(zeros, end - t):
                self.is_undefined = not all(one.mild for one in zeros)
        self.rotors = RotorTangent(self.kit, self.base) if self.base.rotors else None

    def _base_at(self, t: N) -> Taylor[N]:
        """The flow expanded at t [s], where that matters."""
        varies = self.flow.rotor or self.flow.tape or self.flow.rotors
        return self._expanded_at(t) if t != self.flow.t0 and varies else self.flow

    def _expanded_at(self, t: N) -> Taylor[N]:
        """The flow expanded anew at t [s], within its step."""
        base = Taylor(self.scene, self.kit, self.flow.certificate)
        base.look(self.flow.state_at(t), self.flow.rows)
        base.reach(base.order)
        return base

    def _prepare_motor(self, rotor: RotorSeries[N]) -> None:
        """Series c w = s' and c a1 of the flow."""
        zero = self.kit.number(0)
        self.turning = [(n + 1) * rotor.s[n + 1] for n in range(rotor.order)]
        self.pull = [chained(zero, rotor.c, rotor.a1, n) for n in range(rotor.order - 1)]

    def moved(self, vector: Sequence[N]) -> list[N]:
        """The disturbance that `vector`, of the tangent space of the mode, becomes over the piece prepared
        last.
        """
        n, zero = self.n, self.kit.number(0)
        self.x = [[value] for value in (*vector[:n], zero, zero)]
        self.v = [[value] for value in (*vector[n : 2 * n], zero, zero)]
        self.a1: list[N] = []
        self.phi, self.w = [zero], [zero]
        if self.base.rotor:
            self.phi, self.w = [vector[-2]], [vector[-1]]
        if self.rotors:
            self.rotors.begin()
        for order in range(self.flow.order - 1):
            self._advance(order)
        series = [*self.x[:n], *self.v[:n], *([self.phi, self.w] if self.base.rotor else [])]
        if self.formulas:
            self.is_too_long = self.is_too_long or self._misses_terms(series)
        return [horner(coefficients, self.tau) for coefficients in series]

    def _misses_terms(self, series: Sequence[Sequence[N]]) -> bool:
        """Whether the last terms of a disturbance tell that those left out matter: where formulas vary with
        time its series goes on longer than the rates at the ends of a stretch tell.
        """
        total = last = self.kit.number(0)
        for coefficients in series:
            power = self.kit.number(1)
            for n, coefficient in enumerate(coefficients):
                size = abs(coefficient) * power
                total = total + size
                last = last + size if n > len(coefficients) - 3 else last
                power = power * self.tau
        return bool(last > LEFT_OUT * total)

    def value(self, event: Event[N], vector: Sequence[N]) -> N:
        """How much `vector`, a disturbance at the expansion point, changes an event function there [N]."""
        self.prepare(self.flow.t0, self.flow.t0)
        self.moved(vector)
        return total_of(self.kit, (term.coefficient * self._term(term) for term in event.terms))

    def _term(self, term: Term[N]) -> N:
        P, Q = term.P, term.Q
        if term.kind == ACCELERATION:
            return self.v[P][1]
        if term.kind == FORMULA:
            assert self.formulas is not None
            return self.formulas.disturbed(P, 0, self._read())
        if term.kind == LOAD and self.rotors:
            return self.rotors.thrust(P, self.x, self.v)
        if term.kind == LOAD:
            rotor = self.base.rotor
            return self._thrust(rotor) if rotor and rotor.motor.on == P else self.kit.number(0)
        if term.kind == COUPLING:
            one = self.flow.rows.couplings[P]
            P, Q, k, c = one.P, one.Q, one.k, one.c
            return k * (self.x[P][0] - self.x[Q][0]) + c * (self.v[P][0] - self.v[Q][0])
        series = self.x if term.kind == DIFFERENCE else self.v
        return series[P][0] - series[Q][0]

    def _thrust(self, rotor: RotorSeries[N]) -> N:
        """Disturbed force of the motor on its body, m3 e d(s w)/dt - m3 a1."""
        phi, w = self.phi[0], self.w[0]
        s, c, speed, turn = rotor.s[0], rotor.c[0], rotor.w[0], rotor.w[1]
        pulled = (c * turn - s * speed * speed) * phi + 2 * c * speed * w + s * self.w[1]
        return rotor.unbalance * pulled - rotor.motor.m3 * self.a1[0]

    def _read(self) -> dict[str, Sequence[Sequence[N]]]:
        """Series of the disturbances of what formulas read."""
        return {"x": self.x, "v": self.v, "phi": [self.phi], "w": [self.w]}

    def _advance(self, n: int) -> None:
        """Coefficients n + 1 from those of order n and below."""
        rows, zero, inverse = self.flow.rows, self.kit.number(0), self.flow.inverse[n + 1]
        leader, F = rows.leader, [zero] * (self.n + 2)
        for q in rows.couplings:
            force = q.k * (self.x[q.P][n] - self.x[q.Q][n]) + q.c * (self.v[q.P][n] - self.v[q.Q][n])
            F[leader[q.P]] = F[leader[q.P]] - force
            F[leader[q.Q]] = F[leader[q.Q]] + force
        if self.formulas:
            read = self._read()
            for law in rows.formulas:
                force = law.sign * self.formulas.disturbed(law.output, n, read)
                F[leader[law.P]] = F[leader[law.P]] + force
                if law.Q >= 0:
                    F[leader[law.Q]] = F[leader[law.Q]] - force
        acceleration = [force * mobility for force, mobility in zip(F, rows.mobility, strict=True)]
        if self.rotors:
            self.rotors.turn(n, F, acceleration, self.x, self.v)
        if self.base.rotor:
            on = self.base.rotor.leader
            acceleration[on] = self._turn(self.base.rotor, n, F[on])
        for c in range(self.n + 2):
            self.x[c].append(self.v[c][n] * inverse)
            self.v[c].append(acceleration[leader[c]] * inverse)

    def _turn(self, rotor: RotorSeries[N], n: int, force: N) -> N:
        """Disturbed acceleration of the motor's group; advances the rotor."""
        inverse = self.flow.inverse[n + 1]
        self.phi.append(self.w[n] * inverse)
        tail, back = self._products(rotor.s, n)
        torque = rotor.unbalance * back - rotor.drag * self.w[n]
        if rotor.carried is None:  # its motion is given
            a1, turned = self.kit.number(0), torque / rotor.inertia
        else:
            thrust = force + rotor.unbalance * ((n + 1) * tail)
            a1 = rotor.to_a1 * thrust + rotor.cross * torque
            turned = rotor.to_w * torque + rotor.cross * thrust
        self.w.append(turned * inverse)
        self.a1.append(a1)
        return a1

    def _products(self, s: Sequence[N], n: int) -> tuple[N, N]:
        """Coefficient n + 1 of q without s_0 dw_(n+1), and n of c a1 dphi + s A1 without s_0 A1_n.

        The newest terms come last; the others are summed in an odd and an even chain, those with dphi apart
        from those with s: four chains that a processor takes side by side.
        """
        turning, pull, phi, w, a1 = self.turning, self.pull, self.phi, self.w, self.a1
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


def chained(zero: N, c: Sequence[N], a: Sequence[N], n: int) -> N:
    """Coefficient n of the product of two series, its even and odd terms summed apart."""
    sums = [zero, zero]
    for i in range(n + 1):
        sums[i % 2] = sums[i % 2] + c[i] * a[n - i]
    return sums[0] + sums[1]

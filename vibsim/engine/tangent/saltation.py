"""Saltation matrix: the effect of an event on a small disturbance.

A disturbed motion meets the event function h a little earlier or later, and moves by the other vector field
for so long: S = I + (f+ - f-) n^T / (n^T f- + dh/dt), with n = grad h and f-, f+ the vector fields before and
after (Aizerman & Gantmakher 1958; Mueller 1995). Displacements, velocities and the rotor's angle and speed go
on without a jump, so f+ - f- consists of accelerations; for impacts see `impact_saltation.py`. C knows S
where no formula has a say (`events/saltation.c`). Here are
    contact, reversal of stops and frictions by formulas: by the vector fields on both sides
    sticking          f+ - f- is what a force between the two bodies makes, n^T f+ + dh/dt = 0: whatever the
                      forces, S gives the bodies their common velocity and keeps momentum, as C has it
    switch            that makes a formula jump
    release           where a tie at its limit begins to slip with less force than that, f+ - f- is what
                      the drop makes and n the gradient of the force that the tie passes
    rest              that begins or ends where a force jumps: by the vector fields on both sides
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Protocol

from vibsim.engine.errors import State
from vibsim.engine.events.impacts.simultaneous import SimultaneousImpacts
from vibsim.engine.flows.accelerations import accelerations, left_open, response
from vibsim.engine.flows.base_motion import base_motion, course_acceleration
from vibsim.engine.flows.expansion import Expansion
from vibsim.engine.flows.tape import Inputs, TapeValues
from vibsim.engine.modes.rows import (
    ACCELERATION,
    COUPLING,
    DIFFERENCE,
    FORMULA,
    GAP,
    HOLD,
    SLIDE,
    STRIKE,
    SWITCH,
    Event,
    ModeRows,
    Term,
)
from vibsim.engine.modes.status import RESTING, STICK, Status
from vibsim.engine.tangent.impact_saltation import JOINED, UNDEFINED, NoMatrix, impact_saltation
from vibsim.engine.tangent.packing_tangent import slopes_of
from vibsim.physics.formulas import is_continuous
from vibsim.physics.numbers import Kit, N, total_of
from vibsim.physics.parts import Scene, Stop

Accelerations = tuple[list[N], N]  # of bodies [m/s^2] and rotor [rad/s^2]


class Jump(Protocol[N]):
    """A saltation matrix S; `determinant` where the ties are the same on both sides."""

    @property
    def determinant(self) -> N: ...
    def applied(self, vector: Sequence[N], /) -> list[N]: ...


@dataclass
class Saltation(Generic[N]):
    """S = I + jump n^T.

    event : event function, whose gradient is n
    jump : (f+ - f-) / (n^T f- + dh/dt)
    determinant : of S, where the ties are the same on both sides
    """

    event: Event[N]
    jump: list[N]
    bodies: int
    kit: Kit[N]

    def applied(self, vector: Sequence[N]) -> list[N]:
        """S times a disturbance."""
        moved = self._along(vector)
        return [a + moved * b for a, b in zip(vector, self.jump, strict=True)]

    @property
    def determinant(self) -> N:
        return 1 + self._along(self.jump)

    def _along(self, vector: Sequence[N]) -> N:
        return gradient(self.kit, self.event, vector, self.bodies)


@dataclass
class Release(Saltation[N]):
    """S where ties begin to slip with less force; at `state`, in the mode of `rows` before."""

    scene: Scene[N]
    rows: ModeRows[N]
    state: State[N]

    def _along(self, vector: Sequence[N]) -> N:
        return DisturbedForces(self.scene, self.kit, self.rows, self.state, vector).of(self.event)


class DisturbedForces(Generic[N]):
    """Effect of a disturbance on the forces and accelerations of a mode at a state, to first order.

    With s = sin phi, c = cos phi, w = phi' and u the unbalance of a rotor, its pull u d(s w)/dt on what it is
    on changes by u ((c w' - s w^2) dphi + 2 c w dw + s dw'), its torque u s a by u (c a dphi + s da).
    """

    def __init__(
        self, scene: Scene[N], kit: Kit[N], rows: ModeRows[N], state: State[N], vector: Sequence[N]
    ) -> None:
        self.scene, self.kit, self.rows, self.state, self.n = scene, kit, rows, state, len(scene.bodies)
        zero = kit.number(0)
        self.x = (*vector[: self.n], zero, zero)
        self.v = (*vector[self.n : 2 * self.n], zero, zero)
        self.phi, self.w = vector[-2:] if scene.motor else (zero, zero)
        self.formulas = self._formulas()
        turning = bool(scene.motor or rows.rotors)
        self.steady, self.spin_rate = accelerations(scene, kit, rows, state) if turning else ([], zero)
        self.a, self.turned = self._accelerations()

    def _formulas(self) -> dict[int, N]:
        """Changes of the outputs of the tape, by their partial derivatives."""
        if self.rows.tape is None:
            return {}
        kit, state, zero, slopes = self.kit, self.state, self.kit.number(0), slopes_of(self.kit, self.rows)
        X, V = base_motion(self.scene, kit, state.t, self.rows)
        at = Inputs(state.t, (*state.x, zero, X), (*state.v, zero, V), state.phase, state.w)
        values = TapeValues(kit, slopes.tape, at)
        moved = {"x": self.x, "v": self.v, "phi": (self.phi,), "w": (self.w,)}
        return {
            k: total_of(kit, (values.output(one.output)[0] * moved[one.kind][one.column] for one in each))
            for k, each in slopes.of.items()
        }

    def _coupling(self, i: int) -> N:
        one = self.rows.couplings[i]
        return one.k * (self.x[one.P] - self.x[one.Q]) + one.c * (self.v[one.P] - self.v[one.Q])

    def _accelerations(self) -> Accelerations[N]:
        """Changes of the accelerations of columns and motor's rotor."""
        rows, motor, zero, leader = self.rows, self.scene.motor, self.kit.number(0), self.rows.leader
        F, torque = [zero] * (self.n + 2), zero
        for i, coupling in enumerate(rows.couplings):
            force = self._coupling(i)
            F[leader[coupling.P]] = F[leader[coupling.P]] - force
            F[leader[coupling.Q]] = F[leader[coupling.Q]] + force
        for law in rows.formulas:
            force = law.sign * self.formulas[law.output]
            F[leader[law.P]] = F[leader[law.P]] + force
            if law.Q >= 0:
                F[leader[law.Q]] = F[leader[law.Q]] - force
        for one in rows.rotors:
            c, on = self.kit.cos(self.state.x[one.column]), leader[one.on]
            F[on] = F[on] + one.unbalance * self._pull(one.column)
            twist = c * self.steady[on] * self.x[one.column]
            F[one.column] = F[one.column] + one.unbalance * twist
        if motor is not None:
            c, on = self.kit.cos(self.state.phase), leader[motor.on]
            F[on] = F[on] + motor.unbalance * self._pull(None)
            torque = motor.unbalance * (c * self.steady[on] * self.phi) - motor.drag * self.w
        return response(self.scene, self.kit, rows, self.state, F, torque, zero)

    def _pull(self, column: int | None) -> N:
        """Change of d(s w)/dt without that of w', of the rotor in a column or of the motor's."""
        at, phi, w, speed, rate = self.state.phase, self.phi, self.w, self.state.w, self.spin_rate
        if column is not None:
            at, phi, w = self.state.x[column], self.x[column], self.v[column]
            speed, rate = self.state.v[column], self.steady[column]
        s, c = self.kit.sine_cosine(at)
        return (c * rate - s * speed * speed) * phi + 2 * c * speed * w

    def of(self, event: Event[N]) -> N:
        """The change of the event function of a tie or a switch."""
        return total_of(self.kit, (term.coefficient * self._term(term) for term in event.terms))

    def _term(self, term: Term[N]) -> N:
        P = term.P
        if term.kind == ACCELERATION:
            return self.a[P]
        if term.kind == FORMULA:
            return self.formulas[P]
        return self._coupling(P) if term.kind == COUPLING else self._thrust(P)

    def _thrust(self, column: int) -> N:
        """Change of the force of the rotors on a column."""
        motor, total = self.scene.motor, self.kit.number(0)
        for one in self.rows.rotors:
            if one.on == column:
                turned = self.kit.sin(self.state.x[one.column]) * self.a[one.column]
                total = total + one.unbalance * (self._pull(one.column) + turned)
        if motor is not None and motor.on == column:
            pulled = self._pull(None) + self.kit.sin(self.state.phase) * self.turned
            total = total + (motor.unbalance * pulled - motor.m3 * self.a[column])
        return total


def gradient(kit: Kit[N], event: Event[N], vector: Sequence[N], bodies: int) -> N:
    """n^T times a disturbance: the change of a function made of differences or of their rates. Ground and
    base are not disturbed.
    """

    def part(term: Term[N]) -> N:
        if term.kind == FORMULA:  # of the time alone, the velocity of a belt
            return kit.number(0)
        shift = 0 if term.kind == DIFFERENCE else bodies
        P, Q = (vector[shift + c] if c < bodies else kit.number(0) for c in (term.P, term.Q))
        return term.coefficient * (P - Q)

    return total_of(kit, map(part, event.terms))


@dataclass(frozen=True)
class ModeChange(Generic[N]):
    """An event and the rows of the modes before and after it."""

    scene: Scene[N]
    before: ModeRows[N]
    after: ModeRows[N]
    event: Event[N]

    @property
    def turned(self) -> list[int]:
        """Frictions that are in another state behind the event."""
        pairs = zip(self.before.status.frictions, self.after.status.frictions, strict=True)
        return [i for i, (one, other) in enumerate(pairs) if one != other]

    @property
    def tied(self) -> bool:
        """Whether ties change."""
        return self.before.leader != self.after.leader

    @property
    def released(self) -> list[int]:
        """Frictions that begin to slip with less force than they held."""
        old, new = self.before.status.frictions, self.after.status.frictions
        return [i for i in self.turned if old[i] == STICK and self.scene.frictions[i].drops(new[i])]

    @property
    def by_formulas(self) -> bool:
        """Whether a formula has to tell the force of a stop or friction that begins or ends to act."""
        i = self.event.part
        if self.event.kind == GAP:
            stop = self.scene.stops[i]
            return isinstance(stop, Stop) and stop.force is not None
        frictions = self.scene.frictions
        return self.event.kind == SLIDE and any(frictions[k].holds is not None for k in (i, *self.turned))

    @property
    def turns_forces(self) -> bool:
        """Whether a switch that turns makes a formula jump."""
        sides = self.after.sides
        turned = [node for node, side in self.before.sides.items() if sides.get(node) != side]
        return not all(is_continuous(node) for node in turned)


@dataclass(frozen=True)
class EventCrossing(ModeChange[N]):
    """A change at a state.

    expansion : of motions in a mode; touch : what rigid stops did, where they took part
    """

    expansion: Expansion[N]
    state: State[N]
    touch: SimultaneousImpacts[N] | None = None

    @property
    def kit(self) -> Kit[N]:
        return self.expansion.kit

    def saltation(self) -> Jump[N] | NoMatrix | None:
        """S of the event; None where it changes nothing, UNDEFINED where there is none, JOINED where C has
        it.
        """
        kind, touch, scene = self.event.kind, self.touch, self.scene
        if kind == STRIKE:
            assert touch is not None
            return impact_saltation(scene, self.kit, self.state, self.before, self.after, self.event, touch)
        if kind == SWITCH and touch is not None:
            return UNDEFINED  # a kink of the base that strikes what rests on it
        if (kind == SWITCH and self.turns_forces) or (kind == HOLD and self.released):
            change = self._change(self.jump(kind == SWITCH), self.tie_rate)
            if change is None:
                return None
            n = len(scene.bodies)
            return Release(self.event, change, n, self.kit, scene, self.before, self.state)
        return self._of_contact() if kind in (SLIDE, GAP) else None

    def _of_contact(self) -> Jump[N] | NoMatrix | None:
        """S where a gap or a sliding velocity comes to zero."""
        old, new, turned = self.before.status, self.after.status, self.turned
        if old == new:
            return None
        sticks = self.event.kind == SLIDE and turned and self.tied
        if sticks and all(new.frictions[i] == STICK for i in turned):
            if resting(old) == resting(new):
                return JOINED
            return self._by_fields(self.jump())
        return self._by_fields(self.jump(True))

    def _by_fields(self, jump: Accelerations[N]) -> Jump[N] | None:
        """S from the jump of accelerations; None at a tangency, where first order says nothing."""
        change = self._change(jump, self.rate)
        return None if change is None else Saltation(self.event, change, len(self.scene.bodies), self.kit)

    def _change(self, jump: Accelerations[N], rate: N) -> list[N] | None:
        """(f+ - f-) / rate as a disturbance; None at a tangency."""
        if rate == 0:
            return None
        n, zero = len(self.scene.bodies), self.kit.number(0)
        change = [zero] * n + [a / rate for a in jump[0][:n]]
        return change + [zero, jump[1] / rate] if self.scene.motor else change

    @property
    def rate(self) -> N:
        """Rate of the event function along the motion before, n^T f- + dh/dt."""
        scene, kit, state, event = self.scene, self.kit, self.state, self.event
        if event.terms[0].kind == DIFFERENCE:
            values = [*state.v, kit.number(0), base_motion(scene, kit, state.t, self.before)[1]]
        else:
            values, _ = accelerations(scene, kit, self.before, state)
        terms = (term for term in event.terms if term.kind != FORMULA)
        rate = total_of(kit, (term.coefficient * (values[term.P] - values[term.Q]) for term in terms))
        course = scene.frictions[event.part].course if event.kind == SLIDE else None
        return rate if course is None else rate - event.direction * course_acceleration(course, kit, state.t)

    @property
    def tie_rate(self) -> N:
        """Rate of the event function of a tie or a switch along the motion before [N/s]."""
        self.expansion.look(self.state, self.before)
        return self.expansion.derivatives(self.event, 1)[1]

    def jump(self, by_formulas: bool = False) -> Accelerations[N]:
        """Jump of the accelerations (bodies, rotor); by_formulas: at the zero of a switch or of a stop or
        friction by a formula, which rounding has moved off: a power of what is zero there is one of zero.
        """
        blur = self._left_open() if by_formulas else None
        (one, rotor), (other, turned) = (
            accelerations(self.scene, self.kit, rows, self.state, blur) for rows in (self.before, self.after)
        )
        return [b - a for a, b in zip(one, other, strict=True)], turned - rotor

    def _left_open(self) -> Inputs[N]:
        """Uncertainty of the state by rounding, that of its time among it."""
        scene, kit, state, zero = self.scene, self.kit, self.state, self.kit.number(0)
        X, V = base_motion(scene, kit, state.t, self.before)
        a, alpha = accelerations(scene, kit, self.before, state)
        return left_open(kit, state, (*state.x, zero, X), (*state.v, zero, V), a, state.w, alpha)


def resting(status: Status) -> list[int]:
    """Numbers of the rigid stops at rest."""
    return [i for i, one in enumerate(status.stops) if one == RESTING]

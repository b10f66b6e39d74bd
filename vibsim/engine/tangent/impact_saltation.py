"""Saltation matrix of an impact: its effect on a small disturbance.

A disturbed motion meets the stop dt = -n^T d / h' later, with h' the rate of the event function h and n its
gradient. It moves by the field f- in front of the impact for so long, is struck by the law of impacts R, and
would have moved by the field f+ behind it (Aizerman & Gantmakher 1958; Mueller 1995):

    S d = R' (d + f- dt) - f+ dt

with the base at its velocity of that moment. R' is the law linearised about its impulses L,
G dL = (1 + e) dg' - dG L on the stops that passed one; G depends on the angles of rotors. Stops at rest take
part: their rates are 0, disturbed or not. S is unbounded as the approach becomes slow, and there is none

    at a grazing touch, without an approach
    where the motion strikes several stops of one body at one instant that did not rest on each other: which
    of them a disturbed motion strikes first makes a difference that does not vanish with the disturbance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Generic

from vibsim.engine.errors import State
from vibsim.engine.events.impacts.newton_moreau import Contact, Impulse, Masses, coupling, masses, solved
from vibsim.engine.events.impacts.simultaneous import SimultaneousImpacts
from vibsim.engine.flows.accelerations import accelerations
from vibsim.engine.modes.rows import Event, ModeRows
from vibsim.engine.modes.status import OPEN, RESTING
from vibsim.physics.numbers import Kit, N, total_of
from vibsim.physics.parts import Rotor, Scene

ImpactGeometry = Sequence[tuple[Contact[N], Impulse[N]]]  # the stops that passed an impulse, and these


class NoMatrix(Enum):
    """In place of a saltation matrix: there is no first derivative at an event, or C gives tied bodies their
    common velocity.
    """

    UNDEFINED = auto()
    JOINED = auto()


UNDEFINED, JOINED = NoMatrix.UNDEFINED, NoMatrix.JOINED


@dataclass
class ImpactMotion(Generic[N]):
    """Velocities of all columns and of the rotor, and their rates, on one side of an impact."""

    v: list[N]
    w: N
    a: list[N]
    alpha: N


@dataclass
class ImpactSaltation(Generic[N]):
    """S of an impact.

    event : STRIKE function that ended the mode, with h' = -approach [m/s]
    passed : (contact, impulse) of the stops that passed one; law : the impact, linearised
    """

    event: Event[N]
    approach: N
    before: ImpactMotion[N]
    after: ImpactMotion[N]
    law: LinearImpact[N]
    bodies: int

    def applied(self, vector: Sequence[N]) -> list[N]:
        """S times a disturbance."""
        n, one, other = self.bodies, self.before, self.after
        late = self._distance(vector) / self.approach
        dv = [*vector[n : 2 * n], 0 * late, 0 * late]
        dv = [d + late * a for d, a in zip(dv, one.a, strict=True)]
        rotor = vector[2 * n :]
        dphi, dw = (rotor[0] + late * one.w, rotor[1] + late * one.alpha) if rotor else (0 * late, 0 * late)
        there = [d + late * v for d, v in zip(vector[:n], one.v, strict=True)] if self.law.turned else ()
        dv, dw = self.law.applied(dv, dw, dphi, there)
        dx = [d - late * (b - a) for d, a, b in zip(vector[:n], one.v, other.v, strict=True)]
        dv = [d - late * a for d, a in zip(dv[:n], other.a[:n], strict=True)]
        return [*dx, *dv, *([rotor[0] - late * (other.w - one.w), dw - late * other.alpha] if rotor else [])]

    def _distance(self, vector: Sequence[N]) -> N:
        """n^T times a disturbance: the change of the distance to the stop."""
        (term,), zero = self.event.terms, self.law.kit.number(0)
        P, Q = (vector[c] if c < self.bodies else zero for c in (term.P, term.Q))
        return term.coefficient * (P - Q)

    @property
    def drive(self) -> N:
        """Acceleration that drives the ends of the stop together in front of the impact [m/s^2]."""
        (term,) = self.event.terms
        return -(term.coefficient * (self.before.a[term.P] - self.before.a[term.Q]))

    @property
    def determinant(self) -> N:
        """Of S on disturbances that stops at rest allow: e of the law, e again as time passes slower behind
        the impact.
        """
        e = self.law.restitution(self.event.part)
        return e * e


class LinearImpact(Generic[N]):
    """The law of impacts about one impact.

    passed : (contact, impulse) of each stop that passed one; phase: angle of the rotor [rad]; x:
        displacements of all bodies, angles of rotors on them
    """

    def __init__(
        self, scene: Scene[N], kit: Kit[N], passed: ImpactGeometry[N], phase: N, x: Sequence[N]
    ) -> None:
        self.kit, self.passed, self.impulses = kit, passed, [one.impulse for _, one in passed]
        self.bodies = masses(scene, kit, phase, x)
        self.turned = [_TurnedRotor.at(scene, kit, self.bodies, one, x[one.column]) for one in scene.rotors]
        self.couplings = [[coupling(self.bodies, a, b) for b, _ in passed] for a, _ in passed]
        self.on = self.bodies.on
        if self.on >= 0:
            self._turn(scene, kit, phase)

    def _turn(self, scene: Scene[N], kit: Kit[N], phase: N) -> None:
        """How mobilities change with the angle of the rotor."""
        motor = scene.motor
        assert motor is not None
        inertia = motor.inertia
        sine, cosine = kit.sine_cosine(phase)
        s, c = motor.unbalance * sine, motor.unbalance * cosine
        determinant = (scene.bodies[motor.on].m + motor.m3) * inertia - s * s
        change = 2 * s * c / determinant  # of 1 / determinant, in units of that
        self.mobility_slope = self.bodies.mobility[self.on] * change
        self.turning_slope = c / determinant + self.bodies.turning * change

    def applied(self, dv: Sequence[N], dw: N, dphi: N, dx: Sequence[N] = ()) -> tuple[list[N], N]:
        """Velocities of all columns and of the rotor behind the impact, from those in front of it, the angle
        of the rotor, and with rotors on bodies all displacements: their disturbances.
        """
        demands = [-(c.sense * (dv[c.P] - dv[c.Q])) * (1 + c.e) for c, _ in self.passed]
        if self.on >= 0:
            pushed = self._on_body(self.on, self.impulses) * (self.mobility_slope * dphi)
            demands = [
                demand - c.push_on(self.on) * pushed
                for demand, (c, _) in zip(demands, self.passed, strict=True)
            ]
        shifts = self._shifts(dx)
        if shifts:
            demands = [
                demand - c.sense * (shifts.get(c.P, 0 * demand) - shifts.get(c.Q, 0 * demand))
                for demand, (c, _) in zip(demands, self.passed, strict=True)
            ]
        impulses = solved(self.kit, self.couplings, demands, list(range(len(demands))))
        assert impulses is not None  # as when the impact itself was solved for
        after = list(dv)
        for (c, _), impulse in zip(self.passed, impulses, strict=True):
            for column, sign in ((c.P, c.sense), (c.Q, -c.sense)):
                after[column] = after[column] + sign * impulse * self.bodies.mobility[column]
        if self.on >= 0:
            after[self.on] = after[self.on] + pushed
            dw = dw + self.bodies.turning * self._on_body(self.on, impulses)
            dw = dw + self.turning_slope * dphi * self._on_body(self.on, self.impulses)
        for column, shift in shifts.items():
            after[column] = after[column] + shift
        for one in self.turned:
            gained = self.bodies.mobility[one.on] * self._on_body(one.on, self.impulses)
            turn = one.turning * (after[one.on] - dv[one.on]) + one.turning_slope * dx[one.column] * gained
            after[one.column] = after[one.column] + turn
        return after, dw

    def _shifts(self, dx: Sequence[N]) -> dict[int, N]:
        """Changes of the velocities of bodies by the undisturbed impact where the angles of their rotors are
        disturbed, which changes the masses that impulses meet there.
        """
        shifts: dict[int, N] = {}
        for one in self.turned:
            shift = self._on_body(one.on, self.impulses) * (one.mobility_slope * dx[one.column])
            shifts[one.on] = shifts.get(one.on, 0 * shift) + shift
        return shifts

    def _on_body(self, column: int, impulses: Sequence[N]) -> N:
        """Sum of impulses at the stops on a body [N s]."""
        pushed = zip(self.passed, impulses, strict=True)
        return total_of(self.kit, (c.push_on(column) * impulse for (c, _), impulse in pushed))

    def restitution(self, stop: int) -> N:
        return next(c.e for c, _ in self.passed if c.stop == stop)


@dataclass(slots=True)
class _TurnedRotor(Generic[N]):
    """How a rotor on a body takes part in impacts: its column, that of its body, the speed that it gains per
    speed of the body [1/m], and the slopes of that and of the mobility of the body with its angle.
    """

    column: int
    on: int
    turning: N
    turning_slope: N
    mobility_slope: N

    @staticmethod
    def at(scene: Scene[N], kit: Kit[N], bodies: Masses[N], one: Rotor, phi: N) -> _TurnedRotor[N]:
        """Of c = u sin(phi), I = J + m e^2: w gains c / I, 1 / mobility is M - sum c^2 / I."""
        sine, cosine = kit.sine_cosine(phi)
        c, slope, inertia = one.unbalance * sine, one.unbalance * cosine, scene.bodies[one.column].m
        mobility = bodies.mobility[one.on]
        softer = mobility * mobility * (2 * c * slope / inertia)
        return _TurnedRotor(one.column, one.on, c / inertia, slope / inertia, softer)


def impact_saltation(
    scene: Scene[N],
    kit: Kit[N],
    state: State[N],
    before: ModeRows[N],
    after: ModeRows[N],
    event: Event[N],
    touch: SimultaneousImpacts[N],
) -> ImpactSaltation[N] | NoMatrix | None:
    """The saltation of a STRIKE `event` at `state`, which `touch` led to, between the modes of the rows
    `before` and `after`. None where nothing is struck, UNDEFINED where there is none.
    """
    i, passed, more = event.part, touch.impacts[0] if touch.impacts else [], touch.impacts[1:]
    if not passed:
        grazes = touch.before[i] == 0 and after.status.stops[i] == OPEN
        return UNDEFINED if grazes else None
    others = {c.stop for c, _ in passed} - {i}
    alone = len(passed) > len(others) and all(before.status.stops[j] == RESTING for j in others)
    if more or not alone or touch.together:
        return UNDEFINED
    n, start = len(scene.bodies), State(state.t, state.x, touch.v[:-2], state.phase, state.turns, touch.w)
    one, other = (
        ImpactMotion(list(where.v[:n]), where.w, *accelerations(scene, kit, rows, where))
        for where, rows in ((start, before), (state, after))
    )
    law = LinearImpact(scene, kit, passed, state.phase, state.x)
    return ImpactSaltation(event, touch.before[i], one, other, law, n)

"""Saltation matrix: the effect of an event on a small disturbance.

A disturbed motion meets the event function h a little earlier or later, and moves by the other vector field
for so long: S = I + (f+ - f-) n^T / (n^T f- + dh/dt), with n = grad h and f-, f+ the vector fields before and
after (Aizerman & Gantmakher 1958; Mueller 1995). Displacements, velocities and the rotor's angle and speed go
on without a jump, so f+ - f- consists of accelerations; for impacts see `impact_saltation.py`.
    clearance; ties at a limit that slip holds too; damper that would have to pull; stop without damper
                      f+ = f-, so S = I
    stop with damper  its force is c g' on one side and 0 on the other, dh/dt = +-g': their ratio is c,
                      however slow the contact
    sticking          f+ - f- is what a force between the two bodies makes, n^T f+ + dh/dt = 0: whatever the
                      forces, S gives the bodies their common velocity and keeps momentum
    reversal          friction jumps by its sum in both directions
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
from vibsim.engine.events.records import Certificate
from vibsim.engine.flows.accelerations import accelerations, joined, response
from vibsim.engine.flows.base_motion import base_motion, course_acceleration
from vibsim.engine.flows.tape import Inputs
from vibsim.engine.flows.taylor import Taylor
from vibsim.engine.modes.rows import (
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
from vibsim.engine.modes.status import CONTACT, FORWARD, RESTING, STICK, Status
from vibsim.engine.tangent.impact_saltation import UNDEFINED, Undefined, impact_saltation
from vibsim.engine.tangent.tangent_taylor import TaylorTangent
from vibsim.physics.formulas import is_continuous
from vibsim.physics.numbers import Kit, N, abs, total_of
from vibsim.physics.parts import Friction, Scene, Stop

ROUNDING = 8  # of displacements and velocities at an event, in units of eps

Forces = list[tuple[int, int, N | int]]  # of parts between P and Q: on P, the opposite on Q [N]
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
    """S where ties begin to slip with less force; flow: Taylor's, at the event in the mode before."""

    flow: Taylor[N]

    def _along(self, vector: Sequence[N]) -> N:
        tangent = TaylorTangent(self.flow.scene, self.flow.kit, self.flow)
        return tangent.value(self.event, vector)


@dataclass
class Sticking(Generic[N]):
    """S that joins velocities."""

    scene: Scene[N]
    kit: Kit[N]
    rows: ModeRows[N]
    state: State[N]

    def applied(self, vector: Sequence[N]) -> list[N]:
        """S times a disturbance."""
        return joined(self.scene, self.kit, self.rows, self.state, vector)

    @property
    def determinant(self) -> N:
        """Of S, which takes a direction from the velocities."""
        return self.kit.number(0)


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


def saltation(
    scene: Scene[N],
    kit: Kit[N],
    state: State[N],
    before: ModeRows[N],
    after: ModeRows[N],
    event: Event[N],
    touch: SimultaneousImpacts[N] | None = None,
) -> Jump[N] | Undefined | None:
    """The saltation of `event` at `state` between the modes of the rows `before` and `after`; None where it
    changes nothing, UNDEFINED where there is none. touch: of rigid stops, where the event was one.
    """
    if event.kind == STRIKE:
        assert touch is not None
        return impact_saltation(scene, kit, state, before, after, event, touch)
    if event.kind == SWITCH and touch is not None:
        return UNDEFINED  # a kink of the base that strikes what rests on it
    if event.kind == SWITCH:
        return _released(scene, kit, state, before, after, event) if turns_forces(before, after) else None
    old, new = before.status, after.status
    pairs = zip(old.frictions, new.frictions, strict=True)
    turned = [i for i, (one, other) in enumerate(pairs) if one != other]
    damped = _damper(scene, old, new, event)
    sticks = before.leader != after.leader and all(new.frictions[i] == STICK for i in turned)
    if not (event.kind == SLIDE and sticks) and _by_formulas(scene, event, turned, old != new):
        return _general(scene, kit, state, before, after, event, by_formulas=True)
    if event.kind in (SLIDE, GAP) and resting(old) != resting(new):
        return _general(scene, kit, state, before, after, event)
    if not turned:
        return _rank_one(scene, kit, state, before, event, *damped) if damped else None
    tied = before.leader != after.leader
    if event.kind == SLIDE and tied and all(new.frictions[i] == STICK for i in turned):
        return Sticking(scene, kit, after, state)
    if event.kind == SLIDE and not tied:
        forces: Forces[N] = [
            (f.P, f.Q, _friction(f, new.frictions[i]) - _friction(f, old.frictions[i]))
            for i in turned
            for f in [scene.frictions[i]]
        ]
        return _rank_one(scene, kit, state, before, event, forces, None)
    if event.kind in (SLIDE, GAP):
        return _general(scene, kit, state, before, after, event)
    if event.kind == HOLD and released_frictions(scene, before, after):
        return _released(scene, kit, state, before, after, event)
    return None


def turns_forces(before: ModeRows[N], after: ModeRows[N]) -> bool:
    """Whether a switch that turns between two modes makes a formula jump."""
    turned = [node for node, side in before.sides.items() if after.sides.get(node) != side]
    return not all(is_continuous(node) for node in turned)


def _by_formulas(scene: Scene[N], event: Event[N], turned: Sequence[int], changed: bool) -> bool:
    """Whether the force that jumps at an event is one of a stop or a friction that a formula has to tell."""
    if event.kind == GAP and changed:
        stop = scene.stops[event.part]
        return isinstance(stop, Stop) and stop.force is not None
    return event.kind == SLIDE and any(scene.frictions[i].holds is not None for i in turned)


def resting(status: Status) -> list[int]:
    """Numbers of the rigid stops at rest."""
    return [i for i, one in enumerate(status.stops) if one == RESTING]


def released_frictions(scene: Scene[N], before: ModeRows[N], after: ModeRows[N]) -> list[int]:
    """Frictions that begin to slip between two modes with less force than they held."""
    pairs = zip(before.status.frictions, after.status.frictions, strict=True)
    changed = [(i, new) for i, (old, new) in enumerate(pairs) if old == STICK and new != STICK]
    return [i for i, sense in changed if scene.frictions[i].drops(sense)]


def _damper(scene: Scene[N], old: Status, new: Status, event: Event[N]) -> tuple[Forces[N], N | int] | None:
    """Force on P that a damped stop gains per unit of the rate x_P' - x_Q', as ([(P, Q, force)], rate of h);
    None without any.
    """
    if event.kind != GAP:
        return None
    stop = scene.stops[event.part]
    assert isinstance(stop, Stop)
    gained = (new.stops[event.part] == CONTACT) - (old.stops[event.part] == CONTACT)
    if stop.c == 0 or gained == 0:
        return None
    return [(stop.P, stop.Q, -(gained * stop.c))], event.terms[0].coefficient


def _friction(friction: Friction[N], status: int) -> N | int:
    """Force of a slipping friction on P at v_rel = 0; one that sticks acts within a group, where it does not
    count.
    """
    return 0 if status == STICK else -friction.forward if status == FORWARD else friction.backward


def reversal(friction: Friction[N], status: int) -> Forces[N]:
    """Forces [(P, Q, force)] that a friction gains where it turns round from `status`."""
    total = friction.forward + friction.backward
    return [(friction.P, friction.Q, total if status == FORWARD else -total)]


def _rank_one(
    scene: Scene[N],
    kit: Kit[N],
    state: State[N],
    rows: ModeRows[N],
    event: Event[N],
    forces: Forces[N],
    rate: N | int | None,
) -> Jump[N] | None:
    """S where the ties stay and the parts' `forces` on P, less on Q, jump; rate: that of h, None to take it
    from the motion.
    """
    rate = event_rate(scene, kit, state, rows, event) if rate is None else rate
    return _saltation(scene, kit, event, forced(scene, kit, rows, state, forces), rate)


def forced(
    scene: Scene[N], kit: Kit[N], rows: ModeRows[N], state: State[N], forces: Forces[N]
) -> Accelerations[N]:
    """Accelerations (bodies, rotor) by forces [(P, Q, force)] on P, less on Q."""
    n, zero = len(scene.bodies), kit.number(0)
    F = [zero] * (n + 2)
    for P, Q, force in forces:
        for end, value in ((P, force), (Q, -force)):
            if end >= 0:
                leader = rows.leader[end]
                F[leader] = F[leader] + value
    return response(scene, kit, rows, state, F, zero, zero)


def event_rate(scene: Scene[N], kit: Kit[N], state: State[N], rows: ModeRows[N], event: Event[N]) -> N:
    """Rate of an event function along the motion in the mode of `rows`, n^T f- + dh/dt."""
    if event.terms[0].kind == DIFFERENCE:
        values = [*state.v, kit.number(0), base_motion(scene, kit, state.t, rows)[1]]
    else:
        values, _ = accelerations(scene, kit, rows, state)
    rate = total_of(
        kit,
        (
            term.coefficient * (values[term.P] - values[term.Q])
            for term in event.terms
            if term.kind != FORMULA
        ),
    )
    course = scene.frictions[event.part].course if event.kind == SLIDE else None
    if course is None:
        return rate
    return rate - event.direction * course_acceleration(course, kit, state.t)


def _general(
    scene: Scene[N],
    kit: Kit[N],
    state: State[N],
    before: ModeRows[N],
    after: ModeRows[N],
    event: Event[N],
    by_formulas: bool = False,
) -> Jump[N] | None:
    """S by the vector fields on both sides."""
    jump = jump_of(scene, kit, state, before, after, by_formulas)
    return _saltation(scene, kit, event, jump, event_rate(scene, kit, state, before, event))


def jump_of(
    scene: Scene[N],
    kit: Kit[N],
    state: State[N],
    before: ModeRows[N],
    after: ModeRows[N],
    by_formulas: bool = False,
) -> Accelerations[N]:
    """Jump of the accelerations (bodies, rotor) between two modes; by_formulas: at the zero of a switch or of
    a stop or friction by a formula, which rounding has moved off: a power of what is zero there is one of
    zero.
    """
    blur = _left_open(scene, kit, state, before) if by_formulas else None
    (one, rotor), (other, turned) = (accelerations(scene, kit, rows, state, blur) for rows in (before, after))
    return [b - a for a, b in zip(one, other, strict=True)], turned - rotor


def _left_open(scene: Scene[N], kit: Kit[N], state: State[N], before: ModeRows[N]) -> Inputs[N]:
    """What rounding leaves open of a state at an event, the time of which is rounded too."""
    lost, zero = ROUNDING * kit.eps, kit.number(0)
    X, V = base_motion(scene, kit, state.t, before)
    x, v, late = (*state.x, zero, X), (*state.v, zero, V), lost * abs(state.t)
    a, alpha = accelerations(scene, kit, before, state)
    return Inputs(
        late,
        [lost * abs(p) + late * abs(q) for p, q in zip(x, v, strict=True)],
        [lost * abs(p) + late * abs(q) for p, q in zip(v, a, strict=True)],
        lost * abs(kit.unwind(state.phase, state.turns)) + late * abs(state.w),
        lost * abs(state.w) + late * abs(alpha),
    )


def _released(
    scene: Scene[N], kit: Kit[N], state: State[N], before: ModeRows[N], after: ModeRows[N], event: Event[N]
) -> Jump[N] | None:
    """S where ties begin to slip with less force than they held, or a formula jumps."""
    flow, rate = expanded(scene, kit, state, before), tie_rate(scene, kit, state, before, event)
    jump = jump_of(scene, kit, state, before, after, event.kind == SWITCH)
    change = _change(scene, kit, jump, rate)
    return None if change is None else Release(event, change, len(scene.bodies), kit, flow)


def expanded(scene: Scene[N], kit: Kit[N], state: State[N], rows: ModeRows[N]) -> Taylor[N]:
    """The Taylor flow at `state` in the mode of `rows`."""
    flow = Taylor(scene, kit, Certificate(kit))
    flow.enter(state, rows, {})
    return flow


def tie_rate(scene: Scene[N], kit: Kit[N], state: State[N], rows: ModeRows[N], event: Event[N]) -> N:
    """Rate of the event function of a tie along the motion in the mode of `rows` [N/s]."""
    return expanded(scene, kit, state, rows).derivatives(event, 1)[1]


def _saltation(
    scene: Scene[N], kit: Kit[N], event: Event[N], jump: Accelerations[N], rate: N | int
) -> Jump[N] | None:
    """S from the jump of accelerations; None at a tangency, where first order says nothing."""
    change = _change(scene, kit, jump, rate)
    return None if change is None else Saltation(event, change, len(scene.bodies), kit)


def _change(scene: Scene[N], kit: Kit[N], jump: Accelerations[N], rate: N | int) -> list[N] | None:
    """(f+ - f-) / rate as a disturbance; None at a tangency."""
    if rate == 0:
        return None
    n, zero = len(scene.bodies), kit.number(0)
    change = [zero] * n + [a / rate for a in jump[0][:n]]
    if scene.motor is not None:
        change += [zero, jump[1] / rate]
    return change

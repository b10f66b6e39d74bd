"""The vector field of a mode at a state: accelerations of all columns and of the rotor.

It is written from the equations of motion and uses no flow.
"""

from collections.abc import Sequence

from vibsim.engine.errors import State
from vibsim.engine.flows.base_motion import base_acceleration, base_motion, value_and_rate
from vibsim.engine.flows.tape import Inputs, TapeValues
from vibsim.engine.modes.rows import ModeRows
from vibsim.physics.numbers import Kit, N, abs
from vibsim.physics.parts import Scene

ROUNDING = 8  # of displacements and velocities at an event, in units of eps


def accelerations(
    scene: Scene[N], kit: Kit[N], rows: ModeRows[N], state: State[N], blur: Inputs[N] | None = None
) -> tuple[list[N], N]:
    """Accelerations [m/s^2] of bodies, ground and base, and that of the rotor [rad/s^2], in the mode of
    `rows`.

    blur : what rounding leaves open of the state; bases of powers in formulas that are zero within it are
    zero
    """
    n, zero, leader = len(scene.bodies), kit.number(0), rows.leader
    X, V = base_motion(scene, kit, state.t, rows)
    x, v = (*state.x, zero, X), (*state.v, zero, V)
    F, torque, own = [zero] * (n + 2), zero, dict[int, N]()
    for force in scene.forces:
        value, _ = value_and_rate(kit, force.terms, state.t)
        F[leader[force.on]] = F[leader[force.on]] + (value + force.constant)
    for q in rows.couplings:
        value = q.k * (x[q.P] - x[q.Q]) + q.c * (v[q.P] - v[q.Q]) + q.offset
        F[leader[q.P]] = F[leader[q.P]] - value
        F[leader[q.Q]] = F[leader[q.Q]] + value
    for column, value in rows.constants:
        F[leader[column]] = F[leader[column]] + value
    if rows.tape:
        at = Inputs(state.t, x, v, kit.unwind(state.phase, state.turns), state.w)
        values = TapeValues(kit, rows.tape, at, blur, blur is not None)
        for law in rows.formulas:
            value = law.sign * values.output(law.output)[0]
            F[leader[law.P]] = F[leader[law.P]] + value
            if law.Q >= 0:
                F[leader[law.Q]] = F[leader[law.Q]] - value
        for column, output in rows.follow.items():
            own[column] = values.output(output)[0]
    for one in rows.rotors:
        w, on = v[one.column], leader[one.on]
        F[on] = F[on] + one.unbalance * (w * w * kit.cos(x[one.column]))
    motor = scene.motor
    if motor is not None:
        on = leader[motor.on]
        F[on] = F[on] + motor.unbalance * (state.w * state.w * kit.cos(state.phase))
        torque = motor.torque(state.w)
    a, rotor = response(scene, kit, rows, state, F, torque, base_acceleration(scene, kit, state.t, rows))
    return [a[c] + own[c] if c in own else a[c] for c in range(n + 2)], rotor


def response(
    scene: Scene[N], kit: Kit[N], rows: ModeRows[N], state: State[N], F: list[N], torque: N, base: N
) -> tuple[list[N], N]:
    """Accelerations that forces F [N] on the leading columns, a torque [N m] on the rotor and the
    acceleration of the base make: F and the torque over the mass matrix at `state`.
    """
    zero, motor, leader = kit.number(0), scene.motor, rows.leader
    own = [force * mobility for force, mobility in zip(F, rows.mobility, strict=True)]
    own[-1] = base
    rotor = zero
    _turn_rotors(kit, rows, state, F, own)
    if motor is not None:
        on = leader[motor.on]
        inertia, coupling = motor.inertia, motor.unbalance * kit.sin(state.phase)
        carried = rows.mass[on]
        if carried is None:
            rotor = (torque + coupling * own[on]) / inertia
        else:
            mass = carried + motor.m3
            determinant = mass * inertia - coupling * coupling
            own[on] = (inertia * F[on] + coupling * torque) / determinant
            rotor = (mass * torque + coupling * F[on]) / determinant
    return [own[leader[c]] for c in range(len(leader))], rotor


def _turn_rotors(kit: Kit[N], rows: ModeRows[N], state: State[N], F: list[N], own: list[N]) -> None:
    """Accelerations of rotors on bodies and of the groups that they are on."""
    couplings = [one.unbalance * kit.sin(state.x[one.column]) for one in rows.rotors]
    for leader in {rows.leader[one.on] for one in rows.rotors}:
        force, mass = F[leader], rows.mass[leader]
        if mass is None:
            continue
        for one, coupling in zip(rows.rotors, couplings, strict=True):
            if rows.leader[one.on] == leader:
                force = force + coupling * F[one.column] / one.inertia
                mass = mass - coupling * coupling / one.inertia
        own[leader] = force / mass
    for one, coupling in zip(rows.rotors, couplings, strict=True):
        own[one.column] = (F[one.column] + coupling * own[rows.leader[one.on]]) / one.inertia


def left_open(
    kit: Kit[N], state: State[N], x: Sequence[N], v: Sequence[N], a: Sequence[N], w: N, alpha: N
) -> Inputs[N]:
    """Uncertainty of a state by its rounding, and by that of the time at which it is taken.

    x, v, a : displacements, velocities and accelerations of all columns; w, alpha : speed and acceleration
    with which the rotor goes on in the meantime
    """
    lost = ROUNDING * kit.eps
    late = lost * abs(state.t)
    phi = kit.unwind(state.phase, state.turns)
    return Inputs(
        late,
        [lost * abs(p) + late * abs(q) for p, q in zip(x, v, strict=True)],
        [lost * abs(p) + late * abs(q) for p, q in zip(v, a, strict=True)],
        lost * abs(phi) + late * abs(w),
        lost * abs(state.w) + late * abs(alpha),
    )

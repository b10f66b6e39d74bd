"""How a volume of small disturbances grows within a mode: what Liouville's theorem says, for a check.

With momenta p = M v only damping changes a volume of (x, p), by exp(-int tr(C M^-1) dt); one of (x, v)
differs from it by det M, which depends on the angle of a rotor. The disturbances themselves are not used.
"""

from vibsim.physics.gauss_nodes import NODES, WEIGHTS


def log_volume(scene, kit, flow, t, end):
    """Logarithm of the growth from t to `end` [s], within the stretch that `flow` has just done, of a volume
    that fills the tangent space of its mode.
    """
    rows, motor, tau = flow.rows, scene.motor, end - t
    on = None if motor is None else rows.leader[motor.on]
    rate = damping = kit.number(0)
    for q in rows.couplings:
        P, Q = rows.leader[q.P], rows.leader[q.Q]
        for end_column in (P, Q) if P != Q else ():
            if end_column == on:
                damping = damping + q.c
            else:
                rate = rate + q.c * rows.mobility[end_column]
    fixed = -(rate * tau)
    if motor is None:
        return fixed
    drag, inertia = motor.M0 / motor.Omega0, motor.J + motor.m3 * motor.e * motor.e
    if rows.mass[on] is None:
        return fixed - drag / inertia * tau
    return fixed + _with_rotor(kit, flow, motor, (rows.mass[on] + motor.m3, inertia, damping, drag), t, tau)


def _with_rotor(kit, flow, motor, numbers, t, tau):
    """The share of the motor's group and its rotor; numbers: mass, inertia, damping, drag."""
    mass, inertia, damping, drag = numbers

    def determinant(at):
        """det M = (m + m3)(J + m3 e^2) - (m3 e sin phi)^2."""
        coupling = motor.m3 * motor.e * kit.sin(flow.state_after((t - flow.t0) + at).phase)
        return mass * inertia - coupling * coupling

    share = kit.number(0)
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        share = share + weight / determinant(node * tau)
    damped = (damping * inertia + drag * mass) * (tau * share)
    return -damped - kit.log(determinant(tau) / determinant(kit.number(0)))

"""The forces of the paper, equation by equation, and the accelerations they give.

The engine has them as rows of a mode; here they stand as printed, for what the engine is judged by.
Relative displacement y = x1 - x2, its rate u = v1 - v2.
"""

from vibsim.physics.arithmetic.numbers import N
from vibsim.physics.two_blocks import TwoBlocks


def gap_function(scene: TwoBlocks, y: N) -> N:
    """g [m] of the relative displacement y [m]: contact while g >= 0 (Eq. 2.2, or its mirror image)."""
    depth: N = -(scene.stop_sign * y) - scene.G
    return depth


def transmitted_force(scene: TwoBlocks, y: N, u: N, contact: bool) -> N:
    """S = F_s1 + F_d (+ F_s2 in contact) [N], Eqs. (2.4)-(2.6): what block 1 passes to block 2.

    Arguments: y [m], u [m/s], contact (bool). Eq. (2.5) is k2 (y + G) with the paper's stop, k2 (y - G) with
    its mirror image.
    """
    force: N = scene.k1 * y + scene.c * u
    if contact:
        force = force + scene.k2 * (y + scene.stop_sign * scene.G)
    return force


def source_force(scene: TwoBlocks, sine: N) -> N | float:
    """Force of the ideal source on block 1 [N], A sin(omega t) + F0, Eq. (2.3), with sine = sin(omega t)."""
    if scene.source != "harmonic":
        return 0.0
    force: N = scene.A * sine + scene.F0
    return force


def motor_torque(scene: TwoBlocks, w: N) -> N:
    """Torque of the motor [N m] at the speed w [rad/s], Eq. (2.8): M0 (1 - w / Omega0)."""
    torque: N = scene.M0 * (1.0 - w / scene.Omega0)
    return torque


def motor_accelerations(scene: TwoBlocks, force: N, phi_sine: N, phi_cosine: N, w: N) -> tuple[N, N]:
    """a1 [m/s^2] and dw/dt [rad/s^2] from Eqs. (2.9), (2.10), where block 1 passes on the force
    S = `force` [N].

    The 2x2 mass matrix is never singular: its determinant is at least m1 m3 e^2 + (m1 + m3) J.
    """
    coupling = scene.m3 * scene.e * phi_sine
    mass = scene.m1 + scene.m3
    inertia = scene.J + scene.m3 * scene.e * scene.e
    thrust = scene.m3 * scene.e * (w * w) * phi_cosine - force
    torque = motor_torque(scene, w)
    determinant = mass * inertia - coupling * coupling
    a1 = (thrust * inertia + coupling * torque) / determinant
    return a1, (mass * torque + coupling * thrust) / determinant

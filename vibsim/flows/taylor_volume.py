"""How a volume of small disturbances grows along a Taylor step: what Liouville's theorem says, for a check.

With the momenta p = M(phi) v of Eqs. (2.8)-(2.10) only damping changes a volume of (x, p), by
exp(-int tr(C M^-1) dt); one of (x, v) differs from it by det M. The disturbances themselves are not used.
"""

from vibsim.physics.gauss_nodes import NODES, WEIGHTS
from vibsim.physics.numbers import horner


def log_volume(scene, kit, flow, tau):
    """Logarithm of the growth of a volume of (y, v1, v2, phi, w) within tau [s] of the expansion point of
    `flow`; while block 2 rests, of (y, v1, phi, w).
    """
    rate = kit.number(0) if scene.has_motor else scene.c * flow.per_m1
    if not flow.locked:
        rate = rate + scene.c * flow.per_m2
    fixed = -(rate * tau)
    if not scene.has_motor:
        return fixed
    mass, inertia, share = scene.m1 + scene.m3, scene.J + flow.unbalance * scene.e, kit.number(0)
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        share = share + weight / determinant(scene, kit, flow, node * tau)
    damped = (scene.c * inertia + scene.M0 / scene.Omega0 * mass) * (tau * share)
    before, after = (determinant(scene, kit, flow, at) for at in (kit.number(0), tau))
    return fixed - damped - kit.log(after / before)


def determinant(scene, kit, flow, tau):
    """det M = (m1 + m3)(J + m3 e^2) - (m3 e sin phi)^2 at tau after the expansion point."""
    coupling = flow.unbalance * kit.sin(horner(flow.phi, tau))
    return (scene.m1 + scene.m3) * (scene.J + flow.unbalance * scene.e) - coupling * coupling

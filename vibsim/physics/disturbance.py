"""A small disturbance of the state: (dy, dv1, dv2, dphi, dw) with y = x1 - x2, a list of numbers.

Two directions are left out, in which a disturbance neither grows nor shrinks: that of a shift of both blocks,
which no force feels, and with an ideal source that of time.
"""

DY, DV1, DV2, DPHI, DW = range(5)
COMPONENTS = 5


def components(scene):
    """Components of a disturbance that the scene has: DV2 with two blocks only, DPHI and DW with a motor."""
    return (DY, DV1) + ((DV2,) if scene.has_block2 else ()) + ((DPHI, DW) if scene.has_motor else ())


def dimension(scene):
    """Number of Lyapunov exponents of the scene."""
    return len(components(scene))


def natural_rate(scene, kit):
    """Rate [rad/s] that compares displacements with velocities: that of y on its spring k1; 1 without it."""
    mobility = 1 / scene.m1 + 1 / scene.m2 if scene.has_block2 else 1 / scene.m1
    return kit.sqrt(scene.k1 * mobility) if scene.k1 > 0 else kit.number(1)

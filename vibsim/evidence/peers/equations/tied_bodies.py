"""Accelerations of bodies some of which are tied, and the forces in the ties, from forces: linear algebra.

Bodies with masses M under forces F, tied by rows W of relative displacements, move by

    M a = F + W' T,     W a = -w0 X''

with T the forces in the ties, w0 the share of the base in the rows and X'' its acceleration. All ties are
solved for at once; no body is merged with another.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vibsim.evidence.peers.equations.switches import Switch
from vibsim.physics.parts import BASE, Scene

DEPENDENT = 1e-10  # of the largest singular value, below which rows of ties are dependent


@dataclass(frozen=True)
class TiedBodies:
    """a = mobility F + base X'' (n) and T = force F + base_force X'' (ties)."""

    mobility: np.ndarray
    base: np.ndarray
    force: np.ndarray
    base_force: np.ndarray


def masses(scene: Scene) -> np.ndarray:
    """Masses of the bodies [kg], the unbalanced mass of a motor with its body (n)."""
    m = np.array([float(body.m) for body in scene.bodies])
    if scene.motor is not None:
        m[scene.motor.on] += scene.motor.m3
    return m


def rows_of(scene: Scene, switches: Sequence[Switch]) -> tuple[np.ndarray, np.ndarray]:
    """Share of each body (ties, n), and of the base (ties), in the displacement of each part's ends, P
    counted in the direction of the part's positive force.
    """
    rows, base = np.zeros((len(switches), len(scene.bodies))), np.zeros(len(switches))
    for i, switch in enumerate(switches):
        for end, sign in ((switch.part.P, switch.direction), (switch.part.Q, -switch.direction)):
            if end >= 0:
                rows[i, end] = sign
            elif end == BASE:
                base[i] = sign
    return rows, base


def tied_bodies(scene: Scene, tied: Sequence[Switch]) -> TiedBodies:
    """The motion of the bodies of `scene` while the parts `tied` hold their ends together.

    Raises ArithmeticError where more parts tie the same bodies than need be: then the forces are not unique.
    """
    W, w0 = rows_of(scene, tied)
    mobility = np.diag(1 / masses(scene))
    compliance = W @ mobility @ W.T
    spread = np.linalg.svd(compliance, compute_uv=False)
    if len(tied) and spread[-1] < DEPENDENT * spread[0]:
        names = " and ".join(switch.part.name for switch in tied)
        raise ArithmeticError(f"{names} hold the same bodies at once: their forces are not unique")
    inverse = np.linalg.inv(compliance)
    force, base_force = -inverse @ W @ mobility, -inverse @ w0
    through = mobility @ W.T
    return TiedBodies(mobility + through @ force, through @ base_force, force, base_force)

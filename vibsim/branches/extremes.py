"""Extremes of the motion of an orbit over one period."""

from typing import Any

import numpy as np

from vibsim.branches.tracing.records import OrbitRecord
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.returns.start import placed
from vibsim.physics.parts import GROUND


def half_range(return_map: Any, orbit: OrbitRecord) -> float:
    """Half of greatest less least of the first displacement among the unknowns [m]."""
    at = return_map.coordinates
    row = at.take[0]
    ends = int(np.argmax(row)), int(np.argmin(row)) if row.min() < 0 else GROUND
    scene = placed(return_map.scene, at.state(np.array(orbit.state)), orbit.period)
    trajectory = open_trajectory(scene.without_samples(), extremes=([ends], 0.0))
    for _ in trajectory.blocks():
        pass
    least, greatest, _ = trajectory.extremes
    return float(greatest[0] - least[0]) / 2

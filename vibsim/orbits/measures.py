"""What an orbit does in one period, from a run of that length: energies, and its points on the section."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibsim.engine.trajectories.blocks import Trajectory
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.returns.start import placed
from vibsim.orbits.returns.turning import returns

if TYPE_CHECKING:
    from vibsim.orbits.orbit import Orbit

WORKS = ("work_source", "work_base", "work_belt")
LOSSES = ("loss_viscous", "loss_stops", "loss_friction")
ENERGIES = (*WORKS, *LOSSES, "energy_residual")


def energy_of(orbit: Orbit) -> dict[str, float]:
    """Sums of the energy ledger over one period [J], by name."""
    trajectory = _run(orbit, ledger=True)
    for _ in trajectory.blocks():
        pass
    totals = trajectory.totals
    return {name: float(totals[name]) for name in ENERGIES}


def points_of(orbit: Orbit) -> np.ndarray:
    """The unknowns at each return to the section, (n, m); the first is the start."""
    at = orbit.end.coordinates
    rows = [orbit.X]
    if at.section.turning:
        if orbit.n > 1:
            scene = placed(orbit.scene, orbit.state, orbit.period)
            rows += list(at.of(returns(scene, at, orbit.return_map.carrier.engine)[1]))
        return np.array(rows[: orbit.n])
    for block in _run(orbit, section=True).blocks():
        rows += list(at.of(np.stack([block.section[name] for name in at.columns], axis=1)))
    return np.array(rows[: orbit.n])


def _run(orbit: Orbit, section: bool = False, ledger: bool = False) -> Trajectory:
    scene = placed(orbit.scene, orbit.state, orbit.period)
    engine = orbit.return_map.carrier.engine
    return open_trajectory(scene.without_samples(), engine, section=section, ledger=ledger)

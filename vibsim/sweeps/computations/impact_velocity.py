"""The spectrum of impact velocities: how fast the blocks approach each other when contact begins.

As quantiles, which need no bins that suit all points of a sweep: the inverse of the distribution function.
"""

from typing import Any

import numpy as np

from vibsim.engine.trajectory import Block
from vibsim.physics.sums import mean
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.sweeps.computations.contacts import Contacts
from vibsim.sweeps.statistics.columns import Column
from vibsim.sweeps.statistics.measured_run import MeasuredRun

TITLE = "spectrum of impact velocities"
QUANTILES = np.arange(21) / 20
_OF = "relative velocity at the beginnings of contact in the whole periods after the transient"
COLUMNS = {
    "impact_velocity_mean": Column("m s-1", f"mean {_OF}", "stop"),
    "impact_velocity": Column("m s-1", f"quantiles of the {_OF}; 0: least, 1: greatest", "stop", "quantile"),
}


class ImpactVelocity:
    """Impact velocities |v1 - v2| [m/s] of one run."""

    def __init__(self, scene: TwoBlocks, begin: float, section: int):
        self._contacts = Contacts(scene, begin)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._contacts.update(block)

    def values(self, window: tuple[float, float], run: MeasuredRun, found: dict[str, Any]) -> dict[str, Any]:
        """Mean and quantiles; nothing where there was no impact."""
        contacts = self._contacts.table()
        inside = (contacts["t"] >= window[0]) & (contacts["t"] < window[1])
        speeds = np.abs(contacts["velocity"][inside])
        if not len(speeds):
            return {}
        spectrum = np.quantile(speeds, QUANTILES)
        return {"impact_velocity_mean": float(mean(speeds)), "impact_velocity": spectrum}

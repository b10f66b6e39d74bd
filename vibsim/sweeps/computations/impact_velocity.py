"""The spectrum of impact velocities: how fast the ends of a stop approach each other when contact begins.

As quantiles, which need no bins that suit all points of a sweep: the inverse of the distribution function. In
a scene of named parts of all stops together, and of each.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.physics.arithmetic.sums import mean
from vibsim.sweeps.computations.contacts import Contacts
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns, distinct
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

TITLE = "spectrum of impact velocities"
QUANTILES = np.arange(21) / 20


def columns(of: Quantities) -> Columns:
    """Mean and quantiles; none without a stop."""
    return distinct(*(_columns_of(stop) for stop in ("", *of.stops))) if of.has_stop else {}


def _columns_of(stop: str) -> Iterator[tuple[str, Column]]:
    contacts = f"contact with {stop}" if stop else "contact"
    words = f"relative velocity at the beginnings of {contacts} in the whole periods after the transient"
    mean_name, spectrum = _names(stop)
    yield mean_name, Column("m s-1", f"mean {words}")
    yield spectrum, Column("m s-1", f"quantiles of the {words}; 0: least, 1: greatest", dimension="quantile")


def _names(stop: str) -> tuple[str, str]:
    """Columns of mean and quantiles, of one stop or of all."""
    behind = f"_{stop}" if stop else ""
    return f"impact_velocity_mean{behind}", f"impact_velocity{behind}"


class ImpactVelocity:
    """Impact velocities |v_P - v_Q| [m/s] of one run."""

    def __init__(self, task: Task):
        self._contacts, self._stops = Contacts(task), ("", *task.of.stops)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._contacts.update(block)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """Mean and quantiles; nothing where there was no impact."""
        spectra: dict[str, Any] = {}
        for stop in self._stops:
            contacts = self._contacts.table(stop)
            inside = (contacts["t"] >= window[0]) & (contacts["t"] < window[1])
            speeds = np.abs(contacts["velocity"][inside])
            if len(speeds):
                values = float(mean(speeds)), np.quantile(speeds, QUANTILES)
                spectra |= zip(_names(stop), values, strict=True)
        return spectra

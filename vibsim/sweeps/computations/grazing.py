"""How near to grazing the steady motion is: the smallest gap at which the ends of a stop turn back."""

import math
from typing import Any

from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

TITLE = "grazing margin after the transient"
NAME = "grazing_margin_late"


def columns(of: Quantities) -> Columns:
    """The margin of all stops, and of each; none without a stop."""
    words = "smallest gap at a turn without contact{} after the transient"
    names = ("", *of.stops) if of.has_stop else ()
    return {
        f"{NAME}_{stop}" if stop else NAME: Column("m", words.format(f" with {stop}" if stop else ""))
        for stop in names
    }


class Grazing:
    """Grazing margins of one run after its transient; the engine's total is that of the whole run."""

    def __init__(self, task: Task):
        self._stops = task.of.stops

    def update(self, block: Block) -> None:
        """The engine keeps them."""

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The margins; nothing where no turn was seen."""
        margins = run.extremes[2]
        by_stop = dict(zip((f"{NAME}_{name}" for name in self._stops), margins, strict=False))
        return {name: one for name, one in {NAME: min(margins), **by_stop}.items() if math.isfinite(one)}

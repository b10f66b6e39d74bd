"""Whether it is proved that no event of the run was missed."""

from typing import Any

from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

TITLE = "stretches in which an event may have been missed"


def columns(of: Quantities) -> Columns:
    """The number of doubtful stretches."""
    stretches = "stretches of the whole run in which an event may have been missed; 0: all are certified"
    return {"uncertified": Column("1", stretches)}


class Certificate:
    """Certificate of one run."""

    def __init__(self, task: Task):
        pass

    def update(self, block: Block) -> None:
        """The engine counts them."""

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The engine's total, of transient and rest."""
        return {"uncertified": run.totals["uncertified"]}

"""Whether it is proved that no event of the run was missed."""

from typing import Any

from vibsim.engine.trajectory import Block
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.sweeps.statistics.columns import Column
from vibsim.sweeps.statistics.measured_run import MeasuredRun

TITLE = "stretches without proof that no event was missed"
COLUMNS = {
    "uncertified": Column(
        "1", "stretches of the whole run without proof that no event was missed; 0: all are certified"
    )
}


class Certificate:
    """Certificate of one run."""

    def __init__(self, scene: TwoBlocks, begin: float, section: int):
        pass

    def update(self, block: Block) -> None:
        """The engine counts them."""

    def values(
        self, window: tuple[float, float], run: MeasuredRun, found: dict[str, Any]
    ) -> dict[str, float]:
        """The engine's total, of transient and rest."""
        return {"uncertified": run.totals["uncertified"]}

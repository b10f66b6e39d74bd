"""Whether every search for an event was certified: no root overlooked."""

from typing import Any

from vibsim.kernel import Block
from vibsim.physics.scene import Scene
from vibsim.sweeps.columns import Column
from vibsim.sweeps.measured_run import MeasuredRun

TITLE = "searches for events that could not be certified"
COLUMNS = {
    "uncertified": Column(
        "1", "steps of the whole run whose search for events could not be certified; 0: no event was missed"
    )
}


class Certificate:
    """Certificate of one run."""

    def __init__(self, scene: Scene, begin: float, section: int):
        pass

    def update(self, block: Block) -> None:
        """The engine counts them."""

    def values(
        self, window: tuple[float, float], run: MeasuredRun, found: dict[str, Any]
    ) -> dict[str, float]:
        """The engine's total, of transient and rest."""
        return {"uncertified": run.totals["uncertified"]}

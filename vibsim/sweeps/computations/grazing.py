"""How near to grazing the steady motion is: the smallest gap at which the blocks turn back."""

from typing import Any

import numpy as np

from vibsim.engine.trajectory import Block
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.sweeps.statistics.columns import Column
from vibsim.sweeps.statistics.extremes import displacement_extremes, rates
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.rows import Merger, Rows

TITLE = "grazing margin after the transient"
COLUMNS = {
    "grazing_margin_late": Column("m", "smallest gap at a turn without contact after the transient", "stop")
}


class Grazing:
    """Grazing margin of one run after its transient; the engine's is that of the whole run."""

    def __init__(self, scene: TwoBlocks, begin: float, section: int):
        self._scene, self._begin = scene, begin
        self._merger = Merger(scene)
        self._last: Rows | None = None
        self._margin = np.inf

    def update(self, block: Block) -> None:
        """Take the next block."""
        rows = self._merger.merge(block).since(self._begin)
        if not len(rows):
            return
        if self._last is not None:
            rows = self._last.followed_by(rows)
        self._margin = min(self._margin, self._smallest(rows))
        self._last = rows.last()

    def _smallest(self, rows: Rows) -> float:
        """Smallest gap [m] at the turns between two rows out of contact; inf where there is none."""
        side = self._scene.stop_sign  # +1: contact where x1 - x2 is least
        _, low, high = displacement_extremes(self._scene, rows)
        approach = -side * rates(self._scene, rows.states)[-1]
        turns = (approach[:-1] > 0) & (approach[1:] < 0) & (rows.contact[:-1] == 0)
        gaps = self._scene.G + (low[-1] if side > 0 else -high[-1])[:-1]
        return float(gaps[turns].min(initial=np.inf))

    def values(
        self, window: tuple[float, float], run: MeasuredRun, found: dict[str, Any]
    ) -> dict[str, float]:
        """The margin; nothing where no turn was seen."""
        return {"grazing_margin_late": self._margin} if np.isfinite(self._margin) else {}

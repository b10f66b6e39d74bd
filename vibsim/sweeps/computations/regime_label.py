"""What kind of motion it is after the transient: the verdict of `vibsim.analysis` on its section."""

import math
from typing import TYPE_CHECKING, Any

from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.sweeps.computations.lyapunov import HALF_WIDTH, LARGEST
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

if TYPE_CHECKING:
    from vibsim.analysis.regime.points import Exponent

TITLE = "kind of motion (periodic, quasi-periodic, chaotic)"
VERDICTS = {"undecided": 0, "periodic": 1, "transient": 2, "quasi-periodic": 3, "chaotic": 4}


def columns(of: Quantities) -> Columns:
    """Verdict and period; none without a source."""
    if not of.has_source:
        return {}
    chaos = "K of the 0-1 test, 0: regular, 1: chaotic; NaN where not needed"
    return {
        "regime": Column("1", "kind of motion after the transient", flags=VERDICTS),
        "regime_period": Column("1", "excitation periods after which it repeats itself"),
        "chaos_number": Column("1", chaos),
    }


class RegimeLabel:
    """Kind of motion of one run."""

    def __init__(self, task: Task):
        from vibsim.analysis.streaming import StreamedVerdicts

        self._verdicts = StreamedVerdicts(task.scene, task.begin)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._verdicts.update(block)

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, float]:
        """The verdict; a largest Lyapunov exponent that was computed too has its say."""
        judged = self._verdicts.regime(_exponent(measured))
        numbers = {"regime_period": judged.period, "chaos_number": judged.chaos_number}
        known = {name: float(value) for name, value in numbers.items() if value is not None}
        return {"regime": float(VERDICTS[judged.verdict]), **known}


def _exponent(measured: dict[str, Any]) -> "Exponent | None":
    from vibsim.analysis.regime.points import Exponent

    value, half_width = (measured.get(name, math.nan) for name in (LARGEST, HALF_WIDTH))
    return Exponent(value, half_width) if math.isfinite(value) and math.isfinite(half_width) else None

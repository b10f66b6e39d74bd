"""Lyapunov exponents of a point, by `vibsim.analysis.exponents`: one more run, with a tangent bundle."""

from typing import Any

import numpy as np

from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectories.blocks import Block
from vibsim.files.declarations import Column
from vibsim.sweeps.computations.task import Task
from vibsim.sweeps.statistics.columns import Columns
from vibsim.sweeps.statistics.measured_run import MeasuredRun
from vibsim.sweeps.statistics.quantities import Quantities

LARGEST, HALF_WIDTH = "lyapunov", "lyapunov_half_width"
TITLE = "largest Lyapunov exponent"
SPECTRUM_TITLE = "all Lyapunov exponents"


def columns(of: Quantities) -> Columns:
    """The largest exponent."""
    return {
        LARGEST: Column("s-1", "largest Lyapunov exponent after the transient"),
        HALF_WIDTH: Column("s-1", "half width of its 95 % interval; NaN where unknown"),
        "lyapunov_warnings": Column("1", "number of reasons not to trust it, see vibsim.lyapunov"),
    }


def spectrum_columns(of: Quantities) -> Columns:
    """All exponents."""
    half_widths = "half widths of their 95 % intervals; NaN where unknown"
    return {
        "lyapunov_spectrum": Column("s-1", "Lyapunov exponents after the transient", dimension="exponent"),
        "lyapunov_spectrum_half_width": Column("s-1", half_widths, dimension="exponent"),
        "rank_losses": Column("1", "stickings after the transient that took a direction"),
        "volume_residual": Column("1", "what is missing in the identity of Liouville over the whole run"),
    }


class Lyapunov:
    """Lyapunov exponents of one run: the largest, or `everything`."""

    def __init__(self, task: Task, everything: bool = False):
        self._scene, self._begin, self._everything = task.scene, task.begin, everything

    def update(self, block: Block) -> None:
        """The exponents come from a run of their own."""

    def values(
        self, window: tuple[float, float], run: MeasuredRun, measured: dict[str, Any]
    ) -> dict[str, Any]:
        """The exponents and how well they are known."""
        from vibsim.analysis.exponents import judged
        from vibsim.engine.tangent.lyapunov import lyapunov_exponents

        count = dimension(self._scene) if self._everything else 1
        computed = lyapunov_exponents(self._scene, count, self._begin, run.engine, run.ask)
        known = judged(computed, self._scene.tol)
        if not self._everything:
            return {
                LARGEST: float(known.exponents[0]),
                HALF_WIDTH: float(known.half_widths[0]),
                "lyapunov_warnings": float(len(known.warnings)),
            }
        return {
            "lyapunov_spectrum": np.asarray(known.exponents, dtype="f8"),
            "lyapunov_spectrum_half_width": known.half_widths,
            "rank_losses": float(known.rank_losses),
            "volume_residual": known.volume_residual,
        }


class Spectrum(Lyapunov):
    """All Lyapunov exponents of one run."""

    def __init__(self, task: Task):
        super().__init__(task, everything=True)

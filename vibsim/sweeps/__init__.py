"""Sweeps: a case at every point of a grid, in parallel, restartable, the same bit for bit in any order.

    result = sweep("II-B", {"excitation.Omega0": "3:7:0.05 Hz"}, out="sommerfeld.h5")
    result["mean_speed"]

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy import lazy_names

if TYPE_CHECKING:
    from vibsim.sweeps.sweep_plan import PlanError as PlanError
    from vibsim.sweeps.sweep_result import SweepResult as SweepResult
    from vibsim.sweeps.sweep_result import describe as describe
    from vibsim.sweeps.sweep_result import join as join
    from vibsim.sweeps.sweep_result import open_sweep as open_sweep
    from vibsim.sweeps.sweeping import sweep as sweep

__getattr__, __dir__, __all__ = lazy_names(__name__)

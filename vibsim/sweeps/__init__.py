"""Sweeps: a case at every point of a grid, in parallel, restartable, the same bit for bit in any order.

    result = sweep("II-B", {"excitation.Omega0": "3:7:0.05 Hz"}, out="sommerfeld.h5")
    result["mean_speed"]

Names are imported when they are used.
"""

from typing import TYPE_CHECKING

from vibsim.lazy_names import lazy_names

if TYPE_CHECKING:
    from vibsim.sweeps.description import describe as describe
    from vibsim.sweeps.joining import join as join
    from vibsim.sweeps.plan.sweep_plan import PlanError as PlanError
    from vibsim.sweeps.sweep_result import SweepResult as SweepResult
    from vibsim.sweeps.sweep_result import open_sweep as open_sweep
    from vibsim.sweeps.sweeping import sweep as sweep

__getattr__, __dir__, __all__ = lazy_names(
    __name__,
    {
        "vibsim.sweeps.description": ["describe"],
        "vibsim.sweeps.joining": ["join"],
        "vibsim.sweeps.plan.sweep_plan": ["PlanError"],
        "vibsim.sweeps.sweep_result": ["SweepResult", "open_sweep"],
        "vibsim.sweeps.sweeping": ["sweep"],
    },
)

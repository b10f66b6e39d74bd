"""Sweeps: a case at every point of a grid, in parallel, restartable, the same bit for bit in any order.

    result = sweep("II-B", {"excitation.Omega0": "3:7:0.05 Hz"}, out="sommerfeld.h5")
    result["mean_speed"]

Names are imported when they are used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibsim.sweeps.description import describe
    from vibsim.sweeps.joining import join
    from vibsim.sweeps.plan.sweep_plan import PlanError
    from vibsim.sweeps.sweep_result import SweepResult, open_sweep
    from vibsim.sweeps.sweeping import sweep

_HOMES = {
    "PlanError": "vibsim.sweeps.plan.sweep_plan",
    "SweepResult": "vibsim.sweeps.sweep_result",
    "describe": "vibsim.sweeps.description",
    "join": "vibsim.sweeps.joining",
    "open_sweep": "vibsim.sweeps.sweep_result",
    "sweep": "vibsim.sweeps.sweeping",
}

__all__ = ["PlanError", "SweepResult", "describe", "join", "open_sweep", "sweep"]


def __getattr__(name: str):
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value

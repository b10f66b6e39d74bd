"""How much memory a sweep takes: all its points are held at one time."""

import os

import numpy as np

from vibsim.sweeps.plan.sweep_plan import Plan, PlanError

TEXTS = 150  # bytes per point: fingerprint, status, references
SHARE = 0.7  # of the memory of this machine


def bytes_per_point(plan: Plan) -> int:
    """Memory of one point [bytes]."""
    lengths = [plan.shape_of(name)[len(plan.shape) :] for name in plan.columns]
    return 8 * sum(int(np.prod(length)) for length in lengths) + TEXTS


def check_memory(plan: Plan) -> None:
    """Raise PlanError where the points of a plan do not fit into memory."""
    each, there = bytes_per_point(plan), _memory()
    needed = plan.count * each
    if there and needed > SHARE * there:
        raise PlanError(
            f"{plan.count:,} points of {each} bytes take {needed / 1e9:.3g} GB of memory, and this machine"
            f" has {there / 1e9:.3g} GB; share them out among files (--shard K/N), or keep fewer"
            " stroboscopic points (--section)"
        )


def _memory() -> int:
    """Memory of this machine [bytes]; 0 where that is not known."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return 0

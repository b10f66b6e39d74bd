"""Lyapunov exponents of a run as attributes of its file."""

from collections.abc import Mapping
from typing import Any

import numpy as np


def exponent_attributes(totals: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes from the totals of a run; empty where it carried no tangent bundle, or ended too early.

    lyapunov_exponents [1/s], the largest first, -inf where sticking or rest took the direction, NaN where the
    motion has no derivative, from lyapunov_undefined_time [s] on; lyapunov_growth: rows (t [s], logarithm of
    the growth of each disturbance since the first row); what checks them.
    """
    if len(totals.get("growth", ())) < 2:
        return {}
    known = {
        "lyapunov_exponents": totals["exponents"],
        "lyapunov_growth": totals["growth"],
        "lyapunov_rank_losses": totals["rank_losses"],
        "lyapunov_pieces": totals["tangent_pieces"],
        "lyapunov_tangencies": totals["tangencies"],
        "lyapunov_closest_tangency": totals["closest_tangency"],
    }
    for name in ("volume_residual", "closest_tangency_time", "undefined_time"):
        if np.isfinite(totals[name]):
            known[f"lyapunov_{name}"] = totals[name]
    return known

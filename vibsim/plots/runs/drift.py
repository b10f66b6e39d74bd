"""The slow drift of a block, by which friction and impacts carry it along while it vibrates."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibsim.plots.motion.turns import TURNS, states_at, turn_times
from vibsim.plots.view import Span

EXACT_UP_TO = 5000  # stroboscopic points that the engine evaluates; more are interpolated


def drift_rate(result: Any, column: str, span: Span) -> float:
    """Mean velocity of the column x of a block over the span [m/s], vibration left out.

    From points a multiple of the source's period apart, (x(t + nT) - x(t)) / nT: exact for a motion whose
    period divides n = 12, as those of 1, 2, 3, 4 and 6 turns do. With fewer turns in the span, n is half of
    them; with fewer than two there is no drift to tell from the vibration, and it is 0.
    """
    times = turn_times(result, span)
    apart = min(TURNS, len(times) // 2)
    if apart < 1:
        return 0.0
    x = states_at(result, (column, f"v{column[1:]}"), times, EXACT_UP_TO)[column]
    times = times[: len(x)]
    return float(np.sum(x[apart:] - x[:-apart]) / np.sum(times[apart:] - times[:-apart]))

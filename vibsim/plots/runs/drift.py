"""The slow drift of a block, by which friction and impacts carry it along while it vibrates."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibsim.physics.body_sets import drifting_sets
from vibsim.physics.parts import Scene, columns_of
from vibsim.plots.motion.turns import TURNS, states_at, turn_times
from vibsim.plots.view import Span

ROUNDING = 1e-9  # of the greatest displacement: what points of a settled motion scatter by
EXACT_UP_TO = 5000  # stroboscopic points that the engine evaluates; more are interpolated


def drift_rate(result: Any, column: str, span: Span) -> float:
    """Velocity at which a block travels over the span while it vibrates [m/s]; x is its `column`.

    From points a multiple of the source's period apart, the median of (x(t + nT) - x(t)) / nT: exact for a
    motion whose period divides n = 12, as those of 1, 2, 3, 4 and 6 turns do, whatever transient leads to it.
    With fewer turns in the span, n is half of them; with fewer than two there is no drift to tell from the
    vibration, and it is 0. So it is where nothing but rounding moves the points, and of a block that springs
    or stops hold.
    """
    times = turn_times(result, span)
    apart = min(TURNS, len(times) // 2)
    if apart < 1 or column not in free_columns(result.case.scene()):
        return 0.0
    x = states_at(result, (column, f"v{column[1:]}"), times, EXACT_UP_TO)[column]
    times = times[: len(x)]
    rate = float(np.median((x[apart:] - x[:-apart]) / (times[apart:] - times[:-apart])))
    return rate if abs(rate) * (span[1] - span[0]) > ROUNDING * np.abs(x).max() else 0.0


def free_columns(scene: Scene) -> set[str]:
    """Columns of the displacements of the blocks that nothing holds at the ground or the base."""
    return {columns_of(scene.bodies[body].name)[0] for one in drifting_sets(scene) for body in one.bodies}

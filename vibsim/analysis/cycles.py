"""Cycles of the source: the instants at which one ends and the next begins.

Forces and base: the multiples of their common period. Motor: the first passages of phi through multiples of
2 pi, on the line between two samples.
"""

from math import ceil, floor, pi

import numpy as np

from vibsim.physics.parts import Scene
from vibsim.physics.period import common_period
from vibsim.results.result import Result
from vibsim.results.windows import Window, pieces, rows_within

TURN = 2 * pi
ROWS = 1 << 20  # samples read at a time


def cycle_ends(result: Result, window: Window) -> np.ndarray:
    """Ascending times within the window at which a cycle of the source ends [s]; none without a source, and
    where several have no common period.
    """
    scene = result.case.scene()
    if scene.has_motor:
        return _turn_ends(result, window)
    return period_ends(scene, window)


def period_ends(scene: Scene, window: Window) -> np.ndarray:
    """Ascending ends of the common periods of forces and base within the window [s]; none without one."""
    period = common_period(scene)
    if period is None:
        return np.empty(0)
    first, last = (edge * period.cycles / period.turns for edge in window)
    times = np.asarray(period.end(np.arange(ceil(first), floor(last) + 1)))
    return times[(times >= window[0]) & (times <= window[1])]


def _turn_ends(result: Result, window: Window) -> np.ndarray:
    """Where the furthest angle so far passes a whole turn, on the line between two samples."""
    rows = rows_within(result.column("time"), window)
    ends, reached = [np.empty(0)], -np.inf
    for piece in pieces(rows, ROWS):
        joined = slice(max(piece.start - 1, rows.start), piece.stop)  # no interval is lost between pieces
        t, phi = (np.asarray(result.column(name)[joined]) for name in ("time", "phi"))
        ends.append(_passages(t, phi, reached))
        reached = max(reached, float(phi.max()))
    return np.concatenate(ends)


def _passages(t: np.ndarray, phi: np.ndarray, reached: float) -> np.ndarray:
    """Times [s] at which phi (n) first passes a whole turn above `reached`, the furthest angle before."""
    furthest = np.maximum.accumulate(phi)
    first = ceil(furthest[0] / TURN) if reached == -np.inf else floor(reached / TURN) + 1
    turns = TURN * np.arange(first, floor(furthest[-1] / TURN) + 1)
    right = np.searchsorted(furthest, turns, side="left")
    left = np.maximum(right - 1, 0)  # the first sample itself may end a turn
    rise = phi[right] - phi[left]
    share = np.divide(turns - phi[left], rise, out=np.zeros_like(rise), where=rise > 0)
    return np.asarray(t[left] + share * (t[right] - t[left]))

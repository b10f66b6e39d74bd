"""Cycles of the source: the instants at which one ends and the next begins.

Ideal source: the multiples of its period. Motor: the first passages of phi through multiples of 2 pi, on the
line between two samples.
"""

from math import ceil, floor, pi

import numpy as np

from vibsim.physics.two_blocks import TwoBlocks
from vibsim.results.result import Result
from vibsim.results.windows import Window, pieces, rows_within

TURN = 2 * pi
ROWS = 1 << 20  # samples read at a time


def cycle_ends(result: Result, window: Window) -> np.ndarray:
    """Ascending times within the window at which a cycle of the source ends [s]; none without a source."""
    scene = result.case.two_blocks()
    if scene.has_motor:
        return _turn_ends(result, window)
    return _period_ends(scene, window)


def _period_ends(scene: TwoBlocks, window: Window) -> np.ndarray:
    if scene.source != "harmonic" or not scene.cycles:
        return np.empty(0)
    first, last = ceil(window[0] * scene.cycles), floor(window[1] * scene.cycles)
    times = np.arange(first, last + 1) / scene.cycles
    return times[(times >= window[0]) & (times <= window[1])]


def _turn_ends(result: Result, window: Window) -> np.ndarray:
    """Where the furthest angle so far passes a whole turn, on the line between two samples."""
    rows = rows_within(result.column("time"), window)
    found, reached = [np.empty(0)], -np.inf
    for piece in pieces(rows, ROWS):
        joined = slice(max(piece.start - 1, rows.start), piece.stop)  # no interval is lost between pieces
        t, phi = (np.asarray(result.column(name)[joined]) for name in ("time", "phi"))
        found.append(_passages(t, phi, reached))
        reached = max(reached, float(phi.max()))
    return np.concatenate(found)


def _passages(t: np.ndarray, phi: np.ndarray, reached: float) -> np.ndarray:
    """Times [s] at which phi (n) first passes a whole turn above `reached`, the furthest angle before."""
    furthest = np.maximum.accumulate(phi)
    first = ceil(furthest[0] / TURN) if reached == -np.inf else floor(reached / TURN) + 1
    turns = TURN * np.arange(first, floor(furthest[-1] / TURN) + 1)
    right = np.searchsorted(furthest, turns, side="left")
    left = np.maximum(right - 1, 0)  # the first sample itself may end a turn
    rise = phi[right] - phi[left]
    share = np.divide(turns - phi[left], rise, out=np.zeros_like(rise), where=rise > 0)
    return t[left] + share * (t[right] - t[left])

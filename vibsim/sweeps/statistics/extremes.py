"""Least and greatest values from each row to the next: those of the rows, and of what turns between them."""

import numpy as np

from vibsim.physics.two_blocks import TwoBlocks
from vibsim.sweeps.statistics.accelerations import accelerations
from vibsim.sweeps.statistics.rows import Rows
from vibsim.sweeps.statistics.turning_points import may_turn_twice, quintic, turn_of_cubic, turn_of_quintic

NEAR = 0.1  # of the range; between rows a ripple at w rad/s rises by (w h)^2/8 of its amplitude, here 2 %

PLACES = np.linspace(0, 1, 18)[1:-1]


def displacements(scene: TwoBlocks, states: dict[str, np.ndarray]) -> np.ndarray:
    """x1, x2 and x1 - x2 as rows of one array (3, n); x1 alone where block 2 is fixed (1, n)."""
    if not scene.has_block2:
        return states["x1"][np.newaxis]
    return np.stack([states["x1"], states["x2"], states["x1"] - states["x2"]])


def rates(scene: TwoBlocks, found: dict[str, np.ndarray]) -> np.ndarray:
    """Velocities or accelerations of `displacements`, from columns v1 and v2."""
    if not scene.has_block2:
        return found["v1"][np.newaxis]
    return np.stack([found["v1"], found["v2"], found["v1"] - found["v2"]])


def displacement_extremes(scene: TwoBlocks, rows: Rows) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`displacements` of n rows, and their least and greatest up to the next row: (quantities, n) each."""
    t, x, v = rows.states["time"], displacements(scene, rows.states), rates(scene, rows.states)
    h, low, high = np.diff(t), x.copy(), x.copy()
    once = (v[:, :-1] * v[:, 1:] < 0) & (h > 0)
    twice = may_turn_twice(h, (x[:, :-1], x[:, 1:]), (v[:, :-1], v[:, 1:]))
    for turns, evaluate in ((once, turn_of_quintic), (twice, _along_quintic)):
        which, left = np.nonzero(turns)
        x_ends, v_ends = ((column[which, left], column[which, left + 1]) for column in (x, v))
        a = [
            _accelerations_at(scene, rows, left + side, left)[which, np.arange(len(left))] for side in (0, 1)
        ]
        values = np.atleast_2d(evaluate(h[left], x_ends, v_ends, a))
        low[which, left] = np.minimum(low[which, left], values.min(axis=0))
        high[which, left] = np.maximum(high[which, left], values.max(axis=0))
    return x, low, high


def _along_quintic(h, x, v, a):
    """The quintic at places so close together that what turns twice between two rows is seen."""
    return quintic(h, x, v, a, PLACES[:, np.newaxis])


def _accelerations_at(scene: TwoBlocks, rows: Rows, at: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Accelerations in the states of rows `at`, in the mode of the interval that begins with row `left`."""
    states = {name: column[at] for name, column in rows.states.items()}
    return rates(scene, accelerations(scene, states, rows.contact[left], rows.friction[left]))


def speed_extremes(scene: TwoBlocks, rows: Rows) -> tuple[float, float]:
    """Least and greatest speed of the motor [rad/s] within the rows; no event makes its derivative jump."""
    w = rows.states["phidot"]
    low, high = float(w.min()), float(w.max())
    left = _around_extremes(w, low, high)
    h = rows.states["time"][left + 1] - rows.states["time"][left]
    left, h = left[h > 0], h[h > 0]
    d0, d1 = (_speed_rate(scene, rows, left + side) for side in (0, 1))
    turning = d0 * d1 < 0
    left = left[turning]
    turn = turn_of_cubic(h[turning], (w[left], w[left + 1]), (d0[turning], d1[turning]))
    return min(low, turn.min(initial=np.inf)), max(high, turn.max(initial=-np.inf))


def _around_extremes(w: np.ndarray, low: float, high: float) -> np.ndarray:
    """Intervals beside the highest and lowest crests among the rows: the extremes lie in them."""
    margin, rise = NEAR * (high - low), np.diff(w)
    crest = np.ones(len(w), dtype=bool)
    crest[1:-1] = rise[:-1] * rise[1:] <= 0
    crest &= (w <= low + margin) | (w >= high - margin)
    return np.flatnonzero(crest[:-1] | crest[1:])


def _speed_rate(scene: TwoBlocks, rows: Rows, at: np.ndarray) -> np.ndarray:
    states = {name: column[at] for name, column in rows.states.items()}
    return accelerations(scene, states, rows.contact[at], rows.friction[at])["phidot"]

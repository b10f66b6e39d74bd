"""Least and greatest values from each row to the next: those of the rows, and of what turns between them."""

import numpy as np

from vibsim.physics.scene import Scene
from vibsim.sweeps.accelerations import accelerations
from vibsim.sweeps.rows import Rows
from vibsim.sweeps.turning_points import turn_of_cubic, turn_of_quintic

NEAR = 0.1  # of the range; between rows a ripple at w rad/s rises by (w h)^2/8 of its amplitude, here 2 %


def displacements(scene: Scene, states: dict[str, np.ndarray]) -> np.ndarray:
    """x1, x2 and x1 - x2 as rows of one array (3, n); x1 alone where block 2 is fixed (1, n)."""
    if not scene.has_block2:
        return states["x1"][np.newaxis]
    return np.stack([states["x1"], states["x2"], states["x1"] - states["x2"]])


def rates(scene: Scene, found: dict[str, np.ndarray]) -> np.ndarray:
    """Velocities or accelerations of `displacements`, from columns v1 and v2."""
    if not scene.has_block2:
        return found["v1"][np.newaxis]
    return np.stack([found["v1"], found["v2"], found["v1"] - found["v2"]])


def displacement_extremes(scene: Scene, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest of `displacements` from each of n rows to before the next: (quantities, n) each."""
    t, x, v = rows.states["time"], displacements(scene, rows.states), rates(scene, rows.states)
    low, high = x.copy(), x.copy()
    which, left = np.nonzero(np.signbit(v[:, :-1]) != np.signbit(v[:, 1:]))
    turning = (v[which, left] * v[which, left + 1] < 0) & (t[left + 1] > t[left])
    which, left = which[turning], left[turning]
    ends = [(column[which, left], column[which, left + 1]) for column in (x, v)]
    a0, a1 = (
        _accelerations_at(scene, rows, left + side, left)[which, np.arange(len(left))] for side in (0, 1)
    )
    turn = turn_of_quintic(t[left + 1] - t[left], ends[0], ends[1], (a0, a1))
    low[which, left] = np.minimum(low[which, left], turn)
    high[which, left] = np.maximum(high[which, left], turn)
    return low, high


def _accelerations_at(scene: Scene, rows: Rows, at: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Accelerations in the states of rows `at`, in the mode of the interval that begins with row `left`."""
    states = {name: column[at] for name, column in rows.states.items()}
    return rates(scene, accelerations(scene, states, rows.contact[left], rows.friction[left]))


def speed_extremes(scene: Scene, rows: Rows) -> tuple[float, float]:
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


def _speed_rate(scene: Scene, rows: Rows, at: np.ndarray) -> np.ndarray:
    states = {name: column[at] for name, column in rows.states.items()}
    return accelerations(scene, states, rows.contact[at], rows.friction[at])["phidot"]

"""Floquet multipliers: what a small disturbance of an orbit is multiplied by in one period."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, log, sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from vibsim.orbits.returns.return_map import Return

EPS = 2.0**-53
ROUNDING = 64  # units in the last place of the matrix: rounding of its eigenvalues, where they are simple
ON_CIRCLE = 1e-10  # of a multiplier beside the unit circle: on it but for rounding
FORGETS = {"stick_begin", "chatter", "rest_begin"}  # events behind which a direction is lost


def multipliers_of(end: Return) -> np.ndarray:
    """Multipliers of a closed motion (a `Return`), the largest first; complex, with exact conjugates.

    Where bodies stick, or rest on each other, the motion forgets a direction: the matrix has lost rank, and
    what rounding leaves of that multiplier is made 0.
    """
    matrix = end.derivative * end.coordinates.ratios
    rounding = ROUNDING * EPS * sqrt(np.vdot(matrix, matrix))
    from vibsim.orbits.lapack import eigenvalues  # scipy, which most commands do without

    values: list[complex] = sorted(eigenvalues(matrix), key=lambda mu: (-abs(mu), mu.real, mu.imag))
    values = [mu if abs(mu) > rounding else 0.0 for mu in values]
    if values and any(kind in FORGETS for kind, _ in end.events):
        values[-1] = 0.0
    return np.array(values, dtype=complex)


def sides_of_circle(multipliers: np.ndarray) -> tuple[int, int, int]:
    """How many multipliers are inside the unit circle, on it but for rounding, and outside."""
    beyond = np.abs(multipliers) - 1
    outside = int(np.count_nonzero(beyond > ON_CIRCLE))
    inside = int(np.count_nonzero(beyond < -ON_CIRCLE))
    return inside, len(beyond) - inside - outside, outside


def exponents_of(multipliers: Iterable[complex], period: float) -> list[float]:
    """Exponents ln |mu| / T [1/s] of multipliers and a period [s]; -inf for 0."""
    return [log(abs(mu)) / period if mu else -inf for mu in multipliers]

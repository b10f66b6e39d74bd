"""Floquet multipliers: what a small disturbance of an orbit is multiplied by in one period."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from vibsim.orbits.matrices import eigenvalues, length_of, moduli, modulus
from vibsim.physics.arithmetic.elementary import log

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
    rounding = ROUNDING * EPS * length_of(matrix)
    values: list[complex] = sorted(eigenvalues(matrix), key=largest_first)
    values = [mu if modulus(mu) > rounding else 0.0 for mu in values]
    if values and any(kind in FORGETS for kind, _ in end.events):
        values[-1] = 0.0
    return np.array(values, dtype=complex)


def largest_first(mu: complex) -> tuple[float, float, float]:
    """Key that sorts multipliers, the largest first."""
    return -modulus(mu), mu.real, mu.imag


def nearest_to_circle(multipliers: Iterable[complex]) -> complex:
    """The complex multiplier with positive imaginary part that is nearest to the unit circle."""
    return min(multipliers, key=lambda mu: abs(modulus(mu) - 1) + (mu.imag <= 0) * 1e3)


def sides_of_circle(multipliers: np.ndarray) -> tuple[int, int, int]:
    """How many multipliers are inside the unit circle, on it but for rounding, and outside."""
    beyond = moduli(multipliers) - 1
    outside = int(np.count_nonzero(beyond > ON_CIRCLE))
    inside = int(np.count_nonzero(beyond < -ON_CIRCLE))
    return inside, len(beyond) - inside - outside, outside


def exponents_of(multipliers: Iterable[complex], period: float) -> list[float]:
    """Exponents ln |mu| / T [1/s] of multipliers and a period [s]; -inf for 0."""
    return [log(modulus(mu)) / period if mu else -inf for mu in multipliers]

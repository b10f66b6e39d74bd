"""Matrices of a few unknowns, by LAPACK at once: what numpy does around it takes several times as long."""

from __future__ import annotations

from math import prod, sqrt

import numpy as np
from scipy.linalg import lapack


def solved_by_pivots(matrix: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, float]:
    """x with matrix x = right, and the smallest pivot over the size of the matrix: 0 where it is singular to
    the bit, and x says nothing.
    """
    factors, _, x, _ = lapack.dgesv(matrix, right)
    smallest = min(map(abs, factors.diagonal().tolist()))
    return x, smallest / sqrt(np.vdot(matrix, matrix)) if smallest > 0 else 0.0


def determinant(matrix: np.ndarray) -> float:
    """By factors with pivots."""
    if not len(matrix):
        return 1.0
    factors, pivots, _ = lapack.dgetrf(matrix)
    swaps = sum(place != row for row, place in enumerate(pivots.tolist()))
    return prod(factors.diagonal().tolist()) * (-1.0) ** swaps

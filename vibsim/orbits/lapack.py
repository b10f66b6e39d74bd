"""Matrices of a few unknowns, by LAPACK at once: what numpy does around it takes several times as long."""

from __future__ import annotations

from math import isfinite, prod, sqrt

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
    return float(prod(factors.diagonal().tolist()) * (-1.0) ** swaps)


def eigenvalues(matrix: np.ndarray) -> list[complex]:
    """Of a square matrix, with exact conjugates; the bits of `numpy.linalg.eigvals`. Raises LinAlgError where
    the iteration does not converge, or the matrix is not finite.
    """
    if not (isfinite(np.vdot(matrix, matrix)) or np.isfinite(matrix).all()):
        raise np.linalg.LinAlgError("the matrix is not finite")
    real, imaginary, _, _, failed = lapack.dgeev(matrix, 0, 0)
    if failed:
        raise np.linalg.LinAlgError("eigenvalues did not converge")
    return list(map(complex, real.tolist(), imaginary.tolist()))

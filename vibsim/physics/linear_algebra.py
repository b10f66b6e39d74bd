"""Eigenvalues of symmetric matrices of any size, in one order of operations: the same bits on every machine.

A LAPACK or BLAS shares sums out by the vector units and threads of a machine, and fuses products where it
can. Here each operation is rounded by itself. Small matrices of any kind are in `vibsim/engine/matrices.c`,
called by `vibsim.orbits.stability`.
"""

from __future__ import annotations

from math import copysign, sqrt
from typing import TYPE_CHECKING

from vibsim.physics.elementary import dot as sum_of_products

if TYPE_CHECKING:
    import numpy as np

STEPS = 60  # of the QL method to one eigenvalue; more than 30 have not been seen


def symmetric_eigenvalues(A: np.ndarray) -> list[float]:
    """Eigenvalues of a symmetric matrix (n, n), ascending, of any size: Householder's reflections to three
    diagonals (on arrays, entry by entry), then the QL method with implicit shifts.

    Raises ArithmeticError where that does not converge, as of a matrix that is not finite.
    """
    A, off = A.copy(), []
    n = len(A)
    for k in range(n - 2):
        below = A[k + 1 :, k].copy()
        size = sqrt(sum_of_products(below, below))
        off.append(-copysign(size, below[0]))
        if size == 0.0 or size == abs(below[0]):
            off[-1] = float(below[0])
            continue
        below[0] -= off[-1]
        half = float(sum_of_products(below, below)) / 2
        inner = A[k + 1 :, k + 1 :]
        pull = sum_of_products(inner, below) / half
        pull -= below * (float(sum_of_products(below, pull)) / (2 * half))
        inner -= below[:, None] * pull + pull[:, None] * below
    if n > 1:
        off.append(float(A[n - 1, n - 2]))
    return _of_three_diagonals(A.diagonal().tolist(), [*off, 0.0])


def _of_three_diagonals(d: list[float], e: list[float]) -> list[float]:
    """Eigenvalues, ascending, of a symmetric matrix of the diagonal d and beside it e (and a 0)."""
    n = len(d)
    for first in range(n):
        for _ in range(STEPS):
            m = first
            while m < n - 1 and abs(e[m]) + (near := abs(d[m]) + abs(d[m + 1])) != near:
                m += 1
            if m == first:
                break
            g = (d[first + 1] - d[first]) / (2.0 * e[first])
            g = d[m] - d[first] + e[first] / (g + copysign(sqrt(g * g + 1.0), g))
            s = c = 1.0
            p = 0.0
            for i in range(m - 1, first - 1, -1):
                f, b = s * e[i], c * e[i]
                r = sqrt(f * f + g * g)
                e[i + 1] = r
                if r == 0.0:
                    d[i + 1] -= p
                    break
                s, c = f / r, g / r
                g = d[i + 1] - p
                r = (d[i] - g) * s + 2.0 * c * b
                p = s * r
                d[i + 1] = g + p
                g = c * r - b
            else:
                d[first] -= p
                e[first] = g
            e[m] = 0.0
        else:
            raise ArithmeticError("eigenvalues did not converge")
    return sorted(d)

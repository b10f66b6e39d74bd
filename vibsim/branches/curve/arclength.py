"""Pseudo-arclength continuation: a curve z(s) of solutions of n equations in n + 1 unknowns.

The last unknown is the parameter. All unknowns are scaled, so that lengths and angles mean something. The
tangent spans the kernel of the n x (n + 1) Jacobian; a point is predicted along it and corrected by
Newton's method on the hyperplane across it (Keller 1977; Allgower and Georg 2003, chapter 6). Where the
kernel has more dimensions, as in a family of orbits with a multiplier of exactly 1, the step in it is the
shortest one.
"""

from math import isfinite

import numpy as np

from vibsim.orbits.matrices import directions, length_of, product, singular_values, solved_by_pivots

KERNEL = 1e-9  # singular values below this share of the largest are zero
BY_SLOPE = 1e-6  # the same where the derivative by the parameter, a difference quotient, has a say


class ContinuationError(Exception):
    """A point that was not found; the message says why."""


class NoCase(ContinuationError):
    """A value of the parameter that the case does not allow."""


def kernel(jacobian: np.ndarray) -> np.ndarray:
    """Orthonormal vectors that span the kernel of an n x (n + 1) matrix, one or more, one per row.

    It has more than one only where the exact derivatives, all columns but the last, are singular too. Raises
    ContinuationError for a motion without a derivative.
    """
    if not isfinite(length_of(jacobian)):
        raise ContinuationError("the motion has no derivative there")
    values, vectors, _ = directions(jacobian)
    sizes = values[: min(jacobian.shape)].tolist()
    if sizes[0] == 0:
        return vectors
    dimension = 1
    if sizes[-1] <= BY_SLOPE * sizes[0]:
        exact = singular_values(jacobian[:, :-1])
        zeros = int(np.count_nonzero(exact <= KERNEL * exact[0]))
        dimension += min(zeros, sum(size <= BY_SLOPE * sizes[0] for size in sizes))
    return vectors[len(vectors) - dimension :]


def tangent(jacobian: np.ndarray, along: np.ndarray) -> np.ndarray:
    """The unit vector of the kernel nearest to `along`.

    Where the kernel is a line not across `along`, it has the solution of jacobian t = 0, along t = 1; the
    singular values tell the kernel of other matrices.
    """
    n, unknowns = jacobian.shape
    if n + 1 == unknowns:
        matrix, right = np.empty((unknowns, unknowns)), np.zeros(unknowns)
        matrix[:n], matrix[n], right[n] = jacobian, along, 1.0
        direction, pivots = solved_by_pivots(matrix, right)
        if pivots > BY_SLOPE:
            return direction / length_of(direction)
    return nearest(kernel(jacobian), along)


def nearest(vectors: np.ndarray, along: np.ndarray) -> np.ndarray:
    """The unit vector nearest to `along` of those that orthonormal vectors, one per row, span."""
    shares = product(vectors, along)
    if not shares.any():
        return np.asarray(vectors[-1])
    direction = product(shares, vectors)
    return np.asarray(direction / length_of(direction))

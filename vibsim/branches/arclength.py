"""Pseudo-arclength continuation: a curve z(s) of solutions of n equations in n + 1 unknowns.

The last unknown is the parameter. All unknowns are scaled, so that lengths and angles mean something. The
tangent spans the kernel of the n x (n + 1) Jacobian; a point is predicted along it and corrected by
Newton's method on the hyperplane across it (Keller 1977; Allgower and Georg 2003, chapter 6). Where the
kernel has more dimensions, as in a family of orbits with a multiplier of exactly 1, the step in it is the
shortest one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

ITERATIONS = 8  # of Newton's method: more mean that the step was too long
CLOSE = 1e-13  # scaled length of a Newton step behind which rounding begins
ROUGH = 1e-8  # of the last Newton step, where rounding keeps it from growing shorter
KERNEL = 1e-9  # singular values below this share of the largest are zero
BY_SLOPE = 1e-6  # the same where the derivative by the parameter, a difference quotient, has a say


class Point(Protocol):
    """A point where the equations have been evaluated.

    z : unknowns, scaled (n + 1); residual : of the equations, scaled (n)
    settled : whether no further step is needed for what must be exact
    """

    z: np.ndarray
    residual: np.ndarray
    settled: bool

    def jacobian(self, slope: np.ndarray | None = None) -> np.ndarray:
        """Derivative of the residual by z (n, n + 1); slope: its last column, where one is good enough."""

    def moved(self, step: np.ndarray, slope: np.ndarray | None = None) -> np.ndarray:
        """z after a Newton step."""


class ContinuationError(Exception):
    """A point that was not found; the message says why."""


@dataclass(frozen=True)
class Corrected:
    """A point on the curve.

    iterations : Newton steps that it took
    """

    point: Any
    iterations: int


def kernel(jacobian: np.ndarray) -> np.ndarray:
    """Orthonormal vectors that span the kernel of an n x (n + 1) matrix, one or more, one per row.

    It has more than one only where the exact derivatives, all columns but the last, are singular too.
    """
    _, values, vectors = np.linalg.svd(jacobian)
    if values[0] == 0:
        return vectors
    dimension = 1
    if values[-1] <= BY_SLOPE * values[0]:
        exact = np.linalg.svd(jacobian[:, :-1], compute_uv=False)
        zeros = int(np.sum(exact <= KERNEL * exact[0]))
        dimension += min(zeros, int(np.sum(values <= BY_SLOPE * values[0])))
    return vectors[len(vectors) - dimension :]


def tangent(jacobian: np.ndarray, along: np.ndarray) -> np.ndarray:
    """The unit vector of the kernel nearest to `along`."""
    vectors = kernel(jacobian)
    shares = vectors @ along
    if not shares.any():
        return vectors[-1]
    direction = shares @ vectors
    return direction / np.linalg.norm(direction)


def correct(
    evaluate: Callable[[np.ndarray], Any],
    start: np.ndarray,
    across: np.ndarray,
    limit: float,
    slope: np.ndarray | None = None,
    families: bool = False,
) -> Corrected:
    """The point of the curve on the hyperplane through `start` across the unit vector `across`.

    evaluate : the `Point` at z; limit : no Newton step may be longer
    slope : derivative by the parameter from nearby, which spares its own at every step
    families : whether solutions nearby have more dimensions than one: then the shortest step is taken

    Raises ContinuationError where Newton's method does not come to an end.
    """
    z, last = start, np.inf
    for iteration in range(ITERATIONS + 1):
        point = evaluate(z)
        matrix = np.vstack([point.jacobian(slope), across])
        right = np.append(point.residual, across @ (z - start))
        step = -_solved(matrix, right, families)
        length = float(np.linalg.norm(step))
        if (length <= CLOSE or (last <= ROUGH and length >= last / 2)) and point.settled:
            return Corrected(point, iteration)
        if not length <= limit:
            raise ContinuationError("Newton's method left for elsewhere")
        z, last = point.moved(step, slope), length
    raise ContinuationError(f"Newton's method took more than {ITERATIONS} steps")


def _solved(matrix: np.ndarray, right: np.ndarray, families: bool) -> np.ndarray:
    """The solution of matrix x = right; the shortest one where the matrix is singular but for rounding."""
    if families:
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=BY_SLOPE)[0])
    try:
        x = np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        x = np.full(len(right), np.inf)
    if KERNEL * np.abs(x).max() * np.abs(matrix).max() > np.abs(right).max():
        x = np.linalg.lstsq(matrix, right, rcond=KERNEL)[0]
    return x

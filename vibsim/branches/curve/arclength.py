"""Pseudo-arclength continuation: a curve z(s) of solutions of n equations in n + 1 unknowns.

The last unknown is the parameter. All unknowns are scaled, so that lengths and angles mean something. The
tangent spans the kernel of the n x (n + 1) Jacobian; a point is predicted along it and corrected by
Newton's method on the hyperplane across it (Keller 1977; Allgower and Georg 2003, chapter 6). Where the
kernel has more dimensions, as in a family of orbits with a multiplier of exactly 1, the step in it is the
shortest one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Any, Protocol

import numpy as np

from vibsim.orbits.lapack import solved_by_pivots

ITERATIONS = 8  # of Newton's method: more mean that the step was too long
CLOSE = 1e-13  # scaled length of a Newton step behind which rounding begins
CLOSES = 1e-12  # residual, scaled, over the size of the unknowns, that no further step makes smaller
ROUGH = 1e-8  # of the last Newton step, where rounding keeps it from growing shorter
BESIDE = 2.0**-23  # of a Newton step, over the size of the unknowns: both its ends have one derivative
SLOW = 0.125  # of the last Newton step: a longer one is rounding, or the derivative by the parameter is rough
CREEPS, STRAIGHT = 0.2, 0.1  # share of the last Newton step, and of it across the last, of those that creep
PATIENCE = 3  # Newton steps that may grow no shorter while the residual is more than rounding: across a graze
KERNEL = 1e-9  # singular values below this share of the largest are zero
TOLD, SHARE = 1e-6, 1e-3  # change of the parameter, scaled, and share of it in a step, that tell a derivative
BY_SLOPE = 1e-6  # the same where the derivative by the parameter, a difference quotient, has a say


class Point(Protocol):
    """A point where the equations have been evaluated.

    z : unknowns, scaled (n + 1); residual : of the equations, scaled (n)
    settled : whether no further step is needed for what must be exact
    rounded : whether the residual is not larger than rounding may make it
    first_slope : derivative by the parameter that Newton's method begins with; None where each point has its
        own without further ado
    """

    z: np.ndarray
    residual: np.ndarray
    settled: bool
    rounded: bool
    first_slope: np.ndarray | None

    @property
    def linear(self) -> np.ndarray:
        """Derivative of the residual by z without the parameter (n, n)."""

    def jacobian(self, slope: np.ndarray | None = None) -> np.ndarray:
        """Derivative of the residual by z (n, n + 1); slope: its last column, where one is good enough."""

    def moved(self, step: np.ndarray, slope: np.ndarray | None = None) -> np.ndarray:
        """z after a Newton step."""

    @property
    def narrow_slope(self) -> np.ndarray | None:
        """A derivative by the parameter for where `slope` is too rough; None where no better one helps."""


class ContinuationError(Exception):
    """A point that was not found; the message says why."""


class NoCase(ContinuationError):
    """A value of the parameter that the case does not allow."""


@dataclass(frozen=True)
class Corrected:
    """A point on the curve.

    iterations : Newton steps that it took; slope : the derivative by the parameter that they came to, where
        they did not ask for it
    near : a point before it, so near that its derivative by the parameter, which was asked for, is the same
    """

    point: Any
    iterations: int
    slope: np.ndarray | None = None
    near: Any = None


def length_of(vector: np.ndarray) -> float:
    """Euclidean length."""
    return sqrt(vector.dot(vector))


def kernel(jacobian: np.ndarray) -> np.ndarray:
    """Orthonormal vectors that span the kernel of an n x (n + 1) matrix, one or more, one per row.

    It has more than one only where the exact derivatives, all columns but the last, are singular too.
    """
    _, values, vectors = np.linalg.svd(jacobian)
    sizes = values.tolist()
    if sizes[0] == 0:
        return vectors
    dimension = 1
    if sizes[-1] <= BY_SLOPE * sizes[0]:
        exact = np.linalg.svd(jacobian[:, :-1], compute_uv=False)
        zeros = int(np.sum(exact <= KERNEL * exact[0]))
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
    shares = vectors @ along
    if not shares.any():
        return vectors[-1]
    direction = shares @ vectors
    return direction / length_of(direction)


def correct(
    evaluate: Callable[[np.ndarray], Any],
    start: np.ndarray,
    across: np.ndarray | None,
    limit: float,
    slope: np.ndarray | None = None,
    families: bool = False,
    guessed: bool = False,
) -> Corrected:
    """The point of the curve on the hyperplane through `start` across the unit vector `across`; without one
    where the parameter is that of `start`.

    evaluate : the `Point` at z; limit : no Newton step may be longer
    slope : derivative by the parameter from nearby, else that of the first point; from one step to the next
        it is corrected by what the residual has told (`_secant`), which spares one at every step
    families : whether solutions nearby have more dimensions than one: then the shortest step is taken
    guessed : whether `slope` is only about right and the point's own will be asked for: it is asked for
        before the last steps then, which gain by it

    Raises ContinuationError where Newton's method does not come to an end.
    """
    z, last, before, near, narrow = start, np.inf, None, None, False
    taken, idle = np.zeros(len(z)), 0
    size = max(1.0, length_of(z))
    for iteration in range(ITERATIONS + 1):
        point = evaluate(z)
        if across is None:
            step = _held_step(point, families)
        else:
            if slope is None:
                slope = point.first_slope
            elif before is not None and near is None:
                slope = _secant(before, point, slope)
            step = _step(point, slope, across, z - start, families)
        length = length_of(step)
        if length <= CLOSE * size and point.settled and (last <= CLOSE * size or _closes(point, size)):
            return Corrected(point, iteration, slope, near)
        if near is not None and last <= ROUGH * size and point.settled and point.rounded:
            return Corrected(point, iteration, slope, near)
        if guessed and near is None and across is not None and length <= BESIDE * size:
            point.about, near = slope, point
            slope = near.slope
            step = _step(point, slope, across, z - start, families)
            length = length_of(step)
        if last <= ROUGH and length >= last * SLOW and point.settled:
            finer = None if across is None or narrow else point.narrow_slope
            if across is not None and finer is not None:
                slope, step = finer, _step(point, finer, across, z - start, families)
                length = length_of(step)
            elif length >= last / 2 and _creeps(taken, step) == 1.0:
                idle += 1
                if idle > PATIENCE or point.rounded or _closes(point, size):
                    return Corrected(point, iteration, slope, near)
            narrow = True
        if not length <= limit:
            raise ContinuationError("Newton's method left for elsewhere")
        longer = _creeps(taken, step) if across is None else 1.0
        taken = step if longer == 1.0 else np.zeros(len(z))
        z, last, before = point.moved(longer * step, slope), length, point
    raise ContinuationError(f"Newton's method took more than {ITERATIONS} steps")


def _creeps(one: np.ndarray, other: np.ndarray) -> float:
    """By how much the second of two Newton steps falls short of the place that both go to, where each is a
    steady share of the one before, as at the edge of what a power grows from: 1 / (1 - share); 1 elsewhere.
    """
    size = one @ one
    share = float(one @ other / size) if size else 0.0
    straight = length_of(other - share * one) <= STRAIGHT * length_of(other)
    return 1 / (1 - share) if straight and CREEPS < share < 1 - CREEPS else 1.0


def _closes(point: Any, size: float) -> bool:
    """Whether the residual is small too: beside a graze it is by orders larger than a Newton step."""
    return bool(abs(point.residual).max() <= CLOSES * size)


def _secant(one: Any, other: Any, slope: np.ndarray) -> np.ndarray:
    """The derivative by the parameter between two points, from what the residual has changed beyond the
    exact derivatives by the other unknowns; `slope` where the parameter has hardly changed.
    """
    change = other.z - one.z
    if not abs(change[-1]) > max(TOLD, SHARE * length_of(change)):
        return slope
    linear = (one.linear + other.linear) @ change[:-1] / 2
    return np.asarray((other.residual - one.residual - linear) / change[-1])


def _held_step(point: Any, families: bool) -> np.ndarray:
    """Newton's step with the parameter held."""
    step = np.zeros(len(point.z))
    step[:-1] = -_solved(point.linear, point.residual, families)
    return step


def _step(
    point: Any, slope: np.ndarray | None, across: np.ndarray, away: np.ndarray, families: bool
) -> np.ndarray:
    """Newton's step to the hyperplane across a unit vector, from which the point is `away`."""
    jacobian = point.jacobian(slope)
    matrix, right = np.empty((len(jacobian) + 1, len(away))), np.empty(len(jacobian) + 1)
    matrix[:-1], matrix[-1] = jacobian, across
    right[:-1], right[-1] = point.residual, across @ away
    return -_solved(matrix, right, families)


def _solved(matrix: np.ndarray, right: np.ndarray, families: bool) -> np.ndarray:
    """The solution of matrix x = right; the shortest one where the matrix is singular but for rounding.

    Raises ContinuationError for a motion without a derivative.
    """
    x, pivots = right, 0.0
    if matrix.shape[0] == matrix.shape[1] and not families:
        x, pivots = solved_by_pivots(matrix, right)
    if pivots > BY_SLOPE:  # not of what is not finite
        return x
    if not isfinite(np.vdot(matrix, matrix)):
        raise ContinuationError("the motion has no derivative there")
    if families:
        return np.asarray(np.linalg.lstsq(matrix, right, rcond=BY_SLOPE)[0])
    if pivots > 0 and KERNEL * abs(x).max() * abs(matrix).max() <= abs(right).max():
        return x
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=KERNEL)[0])

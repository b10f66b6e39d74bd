"""Newton's method on the hyperplane across the tangent of a curve, or at a given parameter."""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, ldexp, sqrt
from typing import Any, NamedTuple, Protocol

import numpy as np

from vibsim.orbits.stability import (
    directions,
    dot,
    least_squares,
    length_of,
    product,
    singular_values,
    solved_by_pivots,
)
from vibsim.physics.elementary import asin

ITERATIONS = 8  # of Newton's method: more mean that the step was too long
CLOSE = 1e-13  # scaled length of a Newton step behind which rounding begins
CLOSES = 1e-12  # residual, scaled, over the size of the unknowns, that no further step makes smaller
ROUGH = 1e-8  # of the last Newton step, where rounding keeps it from growing shorter
BESIDE = 2.0**-23  # of a Newton step, over the size of the unknowns: both its ends have one derivative
SLOW = 0.125  # of the last Newton step: a longer one is rounding, or the derivative by the parameter is rough
CREEPS, STRAIGHT = 0.2, 0.1  # share of the last Newton step, and of it across the last, of those that creep
PATIENCE = 3  # Newton steps that may grow no shorter while the residual exceeds rounding: across a grazing
TOLD, SHARE = 1e-6, 1e-3  # change of the parameter, scaled, and share of it in a step, that tell a derivative


class CorrectedPoint(Protocol):
    """A point where the equations have been evaluated.

    z : unknowns, scaled (n + 1); residual : of the equations, scaled (n)
    settled : whether no further step is needed for what must be exact
    rounded : whether the residual is not larger than rounding may make it
    first_slope : derivative by the parameter that Newton's method begins with; None where each point has its
        own without further ado
    slope, about : the point's own derivative by the parameter, and about the same; where `correct` is told
        of a guessed one
    """

    z: np.ndarray
    residual: np.ndarray
    settled: bool
    rounded: bool
    first_slope: np.ndarray | None
    slope: np.ndarray
    about: np.ndarray

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
    return _Correction(evaluate, start, across, limit, slope, families, guessed).corrected()


class _Correction:
    """Newton's method of `correct`, whose arguments it has.

    last : length of the step before; taken : that step, zeros behind one that was made longer
    before : the point before; near : as of `Corrected`
    narrowed : whether a narrow derivative by the parameter has been asked for
    idle : steps so far that grew no shorter
    """

    def __init__(
        self,
        evaluate: Callable[[np.ndarray], Any],
        start: np.ndarray,
        across: np.ndarray | None,
        limit: float,
        slope: np.ndarray | None,
        families: bool,
        guessed: bool,
    ) -> None:
        self.evaluate, self.start, self.across, self.limit = evaluate, start, across, limit
        self.slope, self.families = slope, families
        self.guessed = guessed and across is not None
        self.size = max(1.0, length_of(start))
        self.last, self.taken = np.inf, np.zeros(len(start))
        self.before: Any = None
        self.near: Any = None
        self.narrowed, self.idle = False, 0

    def corrected(self) -> Corrected:
        """The point that the steps lead to. Raises ContinuationError."""
        z = self.start
        for iteration in range(ITERATIONS + 1):
            point = self.evaluate(z)
            self._learn_slope(point)
            step = self._step(point)
            if not self._has_arrived(point, length_of(step)):
                step = self._step_by_own_slope(point, step)
                step, ends = self._step_within_rounding(point, step)
                if not ends:
                    z = self._moved(point, step)
                    continue
            return Corrected(point, iteration, self.slope, self.near)
        raise ContinuationError(f"Newton's method took more than {ITERATIONS} steps")

    def _learn_slope(self, point: Any) -> None:
        """Correct the derivative by the parameter by what the residual has told, but for a point's own."""
        if self.across is None:
            return
        if self.slope is None:
            self.slope = point.first_slope
        elif self.before is not None and self.near is None:
            self.slope = _secant(self.before, point, self.slope)

    def _step(self, point: Any) -> np.ndarray:
        if self.across is None:
            return _held_step(point, self.families)
        return _step(point, self.slope, self.across, point.z - self.start, self.families)

    def _has_arrived(self, point: Any, length: float) -> bool:
        """Whether a point is on the curve, from which Newton's step has a length."""
        close = CLOSE * self.size
        by_step = length <= close and (self.last <= close or _closes(point, self.size))
        by_rounding = self.near is not None and self.last <= ROUGH * self.size and point.rounded
        return bool((by_step or by_rounding) and point.settled)

    def _step_by_own_slope(self, point: Any, step: np.ndarray) -> np.ndarray:
        """The step with the point's own derivative by the parameter, where it was guessed until the last
        steps; else the step as it is.
        """
        if not self.guessed or self.near is not None or not length_of(step) <= BESIDE * self.size:
            return step
        point.about, self.near = self.slope, point
        self.slope = point.slope
        return self._step(point)

    def _step_within_rounding(self, point: Any, step: np.ndarray) -> tuple[np.ndarray, bool]:
        """The step, by a narrow derivative where steps grow shorter no faster than rounding or a rough
        derivative lets them; and whether no further one leads nearer.
        """
        length = length_of(step)
        if not (self.last <= ROUGH and length >= self.last * SLOW and point.settled):
            return step, False
        finer = None if self.across is None or self.narrowed else point.narrow_slope
        self.narrowed = True
        if finer is not None:
            self.slope = finer
            return self._step(point), False
        if length < self.last / 2 or _creeps(self.taken, step) != 1.0:
            return step, False
        self.idle += 1
        return step, self.idle > PATIENCE or bool(point.rounded) or _closes(point, self.size)

    def _moved(self, point: Any, step: np.ndarray) -> np.ndarray:
        """Scaled unknowns behind a step, which is made longer where it creeps."""
        self.last = length_of(step)
        if not self.last <= self.limit:
            raise ContinuationError("Newton's method left for elsewhere")
        longer = _creeps(self.taken, step) if self.across is None else 1.0
        self.taken = step if longer == 1.0 else np.zeros(len(step))
        self.before = point
        return np.asarray(point.moved(longer * step, self.slope))


def _creeps(one: np.ndarray, other: np.ndarray) -> float:
    """By how much the second of two Newton steps falls short of the place that both go to, where each is a
    steady share of the one before, as at the edge of what a power grows from: 1 / (1 - share); 1 elsewhere.
    """
    size = dot(one, one)
    share = dot(one, other) / size if size else 0.0
    straight = length_of(other - share * one) <= STRAIGHT * length_of(other)
    return 1 / (1 - share) if straight and CREEPS < share < 1 - CREEPS else 1.0


def _closes(point: Any, size: float) -> bool:
    """Whether the residual is small too: beside a grazing it is by orders larger than a Newton step."""
    return bool(abs(point.residual).max() <= CLOSES * size)


def _secant(one: Any, other: Any, slope: np.ndarray) -> np.ndarray:
    """The derivative by the parameter between two points, from what the residual has changed beyond the
    exact derivatives by the other unknowns; `slope` where the parameter has hardly changed.
    """
    change = other.z - one.z
    if not abs(change[-1]) > max(TOLD, SHARE * length_of(change)):
        return slope
    linear = product(one.linear + other.linear, change[:-1]) / 2
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
    right[:-1], right[-1] = point.residual, dot(across, away)
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
    if not isfinite(length_of(matrix)):
        raise ContinuationError("the motion has no derivative there")
    if families:
        return least_squares(matrix, right, BY_SLOPE)
    if pivots > 0 and KERNEL * abs(x).max() * abs(matrix).max() <= abs(right).max():
        return x
    return least_squares(matrix, right, KERNEL)


# Pseudo-arclength continuation: a curve z(s) of solutions of n equations in n + 1 unknowns.
#
# The last unknown is the parameter. All unknowns are scaled, so that lengths and angles mean something. The
# tangent spans the kernel of the n x (n + 1) Jacobian; a point is predicted along it and corrected by
# Newton's method on the hyperplane across it (Keller 1977; Allgower and Georg 2003, chapter 6). Where the
# kernel has more dimensions, as in a family of orbits with a multiplier of exactly 1, the step in it is the
# shortest one.


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


# How long the next step along a branch is: by the angle that the tangent turned, and by Newton's count.


TURN = 0.15  # angle between two tangents that is aimed at [rad]
SHARP = 0.35  # beyond it a step is taken again, shorter
COUNT = 5  # Newton steps that are aimed at
GROWTH, SHRINK = 1.6, 0.5


class Pace(NamedTuple):
    """Bounds of the step, in scaled length; the largest grows with the unknowns, as at a resonance."""

    first: float = 0.01
    least: float = 1e-9
    most: float = 0.05

    def following(self, step: float, turned: float, iterations: int, size: float = 1.0) -> float:
        """The step behind one that turned the tangent by `turned` [rad] in so many Newton steps, to a point
        of scaled length `size`.
        """
        by_angle = TURN / turned if turned > 0 else GROWTH
        halves, odd = divmod(COUNT - iterations, 2)
        by_count = ldexp(sqrt(2.0) if odd else 1.0, halves)
        return float(
            min(
                self.most * max(1.0, size),
                max(self.least, step * min(GROWTH, max(SHRINK, min(by_angle, by_count)))),
            )
        )


def turn(one: np.ndarray, other: np.ndarray) -> float:
    """Angle between two unit vectors [rad], right where it is small."""
    between = one - other
    return 2.0 * asin(min(1.0, length_of(between) / 2))

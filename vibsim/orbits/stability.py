"""Stability from the multipliers of an orbit: which bifurcations are near."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import copysign, inf, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibsim.cases.quantities import number
from vibsim.engine import _engine
from vibsim.engine.errors import State
from vibsim.engine.flows.accelerations import accelerations
from vibsim.engine.flows.closed import matrices
from vibsim.engine.flows.closed.matrices import Matrix
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.modes.status import BACKWARD, FORWARD
from vibsim.engine.resume import status_of
from vibsim.engine.tangent.carried import Carried, state_of
from vibsim.orbits.words import OF_FRICTION
from vibsim.physics.elementary import log
from vibsim.physics.formula_values import inputs_at, values_of
from vibsim.physics.numbers import Doubles, Kit, N
from vibsim.physics.parts import Scene

if TYPE_CHECKING:
    from vibsim.orbits.orbit import Orbit
    from vibsim.orbits.return_map import Return


NEAR = 0.02  # distance of a multiplier from the unit circle that is worth telling


@dataclass(frozen=True)
class Neighbour:
    """A multiplier near the unit circle. kind: "fold", "period doubling" or "Neimark-Sacker"; "family" for
    one that is 1 but for rounding.
    """

    kind: str
    mu: complex

    @property
    def text(self) -> str:
        if self.kind == "family":
            return "a multiplier is 1: one of a family of orbits, or a fold"
        shown = number(self.mu.real, 6) if self.mu.imag == 0 else f"magnitude {number(modulus(self.mu), 6)}"
        article = "a Neimark-Sacker point" if self.kind == "Neimark-Sacker" else f"a {self.kind}"
        return f"{article} is near (multiplier {'of ' * (self.mu.imag != 0)}{shown})"


def neighbours(orbit: Orbit) -> list[Neighbour]:
    """The bifurcations that are near, the nearest first."""
    near = [mu for mu in orbit.multipliers.tolist() if mu.imag >= 0 and abs(modulus(mu) - 1) < NEAR]
    return [Neighbour(_kind(mu), mu) for mu in sorted(near, key=lambda mu: abs(modulus(mu) - 1))]


def _kind(mu: complex) -> str:
    if mu.imag != 0:
        return "Neimark-Sacker"
    if mu.real < 0:
        return "period doubling"
    return "family" if modulus(mu - 1) < ON_CIRCLE else "fold"


# Floquet multipliers: what a small disturbance of an orbit is multiplied by in one period.


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
    """Numbers of multipliers inside the unit circle, on it but for rounding, and outside."""
    beyond = moduli(multipliers) - 1
    outside = int(np.count_nonzero(beyond > ON_CIRCLE))
    inside = int(np.count_nonzero(beyond < -ON_CIRCLE))
    return inside, len(beyond) - inside - outside, outside


def exponents_of(multipliers: Iterable[complex], period: float) -> list[float]:
    """Exponents ln |mu| / T [1/s] of multipliers and a period [s]; -inf for 0."""
    return [log(modulus(mu)) / period if mu else -inf for mu in multipliers]


# The sliding margin of an orbit: how far its reversals are from sticking, and its sticks from sliding on.
#
# Where a sliding velocity comes to zero, a tie there would have to pass some force S for the ends to stay
# together. Slip with the forces -forward and +backward on P gives the relative accelerations w+ and w-, which
# are linear in the force, so S is where that line is zero. A reversal has |S| above the limit, a stick below
# it; an orbit on which the two are equal is at a sliding bifurcation.


def sliding_margin(scene: Scene, carried: Carried) -> float:
    """The smallest distance of |S| from the limit [N] at the zeros of sliding velocities on a motion; inf
    without any.
    """
    maker = RowMaker(scene, Doubles)
    margins = [
        abs(excess(scene, maker, part, t, components, codes))
        for (kind, part), t, components, codes in zip(
            carried.events, carried.times, carried.states, carried.codes.tolist(), strict=True
        )
        if kind in OF_FRICTION and kind != "stick_end"
    ]
    return min((margin for margin in margins if margin == margin), default=inf)


def excess(
    scene: Scene, maker: RowMaker, i: int, t: float, components: np.ndarray, codes: Sequence[int]
) -> float:
    """How far the force S of a tie in place of friction `i` would be beyond its limits at a state [N]; below
    0 where it would hold, NaN where the friction does not move its ends against each other.
    """
    values: list[float] = components.tolist()
    state, status = state_of(scene, Doubles, t, values), status_of(scene, codes)
    friction = scene.frictions[i]
    P, Q = maker.ends(friction)
    rates = []
    for sense in (FORWARD, BACKWARD):
        a, _ = accelerations(scene, Doubles, maker.rows(status.with_frictions({i: sense})), state)
        rates.append(a[P] - a[Q])
    (forward, backward), (above, below) = _forces_of(scene, friction, state)
    if rates[0] == rates[1]:
        return float("nan")
    S = -forward - rates[0] * (forward + backward) / (rates[1] - rates[0])
    return max(-S - above, S - below)


def _forces_of(scene: Scene, friction: Any, state: State) -> tuple[Sequence[float], Sequence[float]]:
    """The forces [N] with which slip begins forwards and backwards, and the most that it holds against it."""
    if friction.holds is None:
        return (friction.forward, friction.backward), friction.limits
    at = inputs_at(scene, state.t, state.x, state.v, (state.phase, state.w))
    starts, limits = (
        [float(values_of(one, at)) for one in each] for each in (friction.slips, friction.holds)
    )
    return starts, limits


# Matrices and vectors of a few unknowns, as arrays, with the same bits on every machine.
#
# What numpy and scipy offer goes to a LAPACK and a BLAS, which round as the processor's vector units and
# their threads have it: then rounding decides on which machine a special point is found. These are our own,
# `vibsim/engine/matrices.c`.


class NoEigenvalues(ArithmeticError):
    """A matrix that is not finite, or whose eigenvalues did not converge."""


class Directions(NamedTuple):
    """Singular values of a matrix A (m, n), and the directions that belong to them.

    values : n of them, the largest first; those beyond the m-th are 0 but for rounding
    vectors : right singular vectors, the rows of an orthogonal matrix (n, n)
    images : A times each, one per row (n, m)
    """

    values: np.ndarray
    vectors: np.ndarray
    images: np.ndarray


def _plain(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(values, dtype="f8")


def product(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Product of two matrices, or of a matrix and a vector on either side."""
    one, other = _plain(one), _plain(other)
    shape = (*one.shape[:-1], *other.shape[1:])
    if not one.shape[-1]:
        return np.zeros(shape)
    out = np.empty(shape)
    _engine.product(one, other, out)
    return out


def dot(one: np.ndarray, other: np.ndarray) -> float:
    """Sum of the products of two vectors."""
    return _engine.dot(_plain(one), _plain(other))


def length_of(values: np.ndarray) -> float:
    """Euclidean length of a vector; of a matrix that of all its entries in a row."""
    flat = values.ravel()
    return sqrt(dot(flat, flat))


def modulus(value: complex) -> float:
    """|z|, which `abs` leaves to the C library."""
    re, im = value.real, value.imag
    if im == 0.0:
        return abs(re)
    largest = max(abs(re), abs(im))
    re, im = re / largest, im / largest
    return largest * sqrt(re * re + im * im)


def square_root(value: complex) -> complex:
    """The root of a complex number with a real part not below 0."""
    if not value:
        return 0j
    half = sqrt((abs(value.real) + modulus(value)) / 2)
    other = value.imag / (2 * half)
    return complex(half, other) if value.real >= 0 else complex(abs(other), copysign(half, value.imag))


def moduli(values: np.ndarray) -> np.ndarray:
    """|z| of complex numbers."""
    return np.array([modulus(value) for value in values.tolist()])


def solved_by_pivots(matrix: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, float]:
    """x with matrix x = right, and the smallest pivot over the size of the matrix: 0 where it is singular to
    the bit, and x says nothing.
    """
    x = np.empty(len(right))
    smallest = _engine.solved(_plain(matrix), _plain(right), x)
    return x, smallest / length_of(matrix) if smallest > 0 else 0.0


def determinant(matrix: np.ndarray) -> float:
    """By factors with pivots."""
    return _engine.determinant(_plain(matrix)) if len(matrix) else 1.0


def directions(matrix: np.ndarray) -> Directions:
    """Singular values and vectors. Raises NoEigenvalues for a matrix that is not finite."""
    m, n = matrix.shape
    out = np.empty(n * (1 + n + m))
    if not _engine.singular(_plain(matrix), out):
        raise NoEigenvalues("the matrix is not finite")
    return Directions(out[:n], out[n : n + n * n].reshape(n, n), out[n + n * n :].reshape(n, m))


def singular_values(matrix: np.ndarray) -> np.ndarray:
    """The smaller of m and n singular values of a matrix (m, n), the largest first."""
    return directions(matrix).values[: min(matrix.shape)]


def least_squares(matrix: np.ndarray, right: np.ndarray, cut: float) -> np.ndarray:
    """The shortest x of those with the least |matrix x - right|; directions whose singular value is no more
    than `cut` of the largest are left out.
    """
    values, vectors, images = directions(matrix)
    x = np.zeros(matrix.shape[1])
    for value, vector, image in zip(values.tolist(), vectors, images, strict=True):
        if value > cut * values[0]:
            x += (dot(image / value, right) / value) * vector
    return x


def eigenvalues(matrix: np.ndarray) -> list[complex]:
    """Of a square matrix, with exact conjugates. Raises NoEigenvalues."""
    out = np.empty((len(matrix), 2))
    if not _engine.eigenvalues(_plain(matrix), out):
        raise NoEigenvalues("eigenvalues did not converge, or the matrix is not finite")
    return [complex(re, im) for re, im in out.tolist()]


# Linear algebra of a few unknowns in numbers of any kit: what numpy does for doubles.
#
# A matrix is a list of rows. Complex numbers are pairs (re, im), which every kit has.


Complex = tuple[N, N]  # real and imaginary part


def solved(kit: Kit[N], matrix: Matrix[N], right: Sequence[N]) -> list[N]:
    """x with matrix x = right, by Gaussian elimination with the largest pivot of each column. Raises
    ZeroDivisionError for a matrix that is singular.
    """
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(float(rows[i][k])))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        if rows[k][k] == 0:
            raise ZeroDivisionError("the matrix is singular")
        for i in range(k + 1, n):
            share = rows[i][k] / rows[k][k]
            rows[i] = [a - share * b for a, b in zip(rows[i], rows[k], strict=True)]
    x = [kit.number(0)] * n
    for k in reversed(range(n)):
        rest = sum((rows[k][i] * x[i] for i in range(k + 1, n)), kit.number(0))
        x[k] = (rows[k][n] - rest) / rows[k][k]
    return x


def characteristic_polynomial(kit: Kit[N], matrix: Matrix[N]) -> list[N]:
    """Coefficients c_0, ..., c_n = 1 of det(x - matrix), by the method of Faddeev and LeVerrier."""
    n, one = len(matrix), kit.number(1)
    coefficients, powers = [one], [[kit.number(0)] * n for _ in range(n)]
    for k in range(1, n + 1):
        shifted = [[powers[i][j] + (coefficients[-1] if i == j else 0) for j in range(n)] for i in range(n)]
        powers = matrices.product(matrix, shifted)
        trace = sum((powers[i][i] for i in range(n)), kit.number(0))
        coefficients.append(-trace / k)
    return coefficients[::-1]


def refined_roots(
    kit: Kit[N], coefficients: Sequence[N], starts: Iterable[complex], steps: int
) -> list[Complex[N]]:
    """The roots of a polynomial near `starts` (complex), by Aberth's iteration: Newton's method that keeps
    from roots found by others. Pairs (re, im).
    """
    roots = [(kit.number(z.real), kit.number(z.imag)) for z in starts]
    for _ in range(steps):
        for i, z in enumerate(roots):
            value, slope = _horner(kit, coefficients, z)
            if value == (0, 0) or slope == (0, 0):
                continue
            newton = _over(value, slope)
            pull = (kit.number(0), kit.number(0))
            for j, other in enumerate(roots):
                apart = (z[0] - other[0], z[1] - other[1])
                if j != i and apart != (0, 0):
                    near = _over((kit.number(1), kit.number(0)), apart)
                    pull = (pull[0] + near[0], pull[1] + near[1])
            away = _times(newton, pull)
            step = _over(newton, (1 - away[0], -away[1]))
            roots[i] = z[0] - step[0], z[1] - step[1]
    return roots


def _horner(kit: Kit[N], coefficients: Sequence[N], z: Complex[N]) -> tuple[Complex[N], Complex[N]]:
    """Value and slope of the polynomial at z."""
    zero = kit.number(0)
    value, slope = (zero, zero), (zero, zero)
    for c in reversed(coefficients):
        turned = _times(slope, z)
        slope = (turned[0] + value[0], turned[1] + value[1])
        moved = _times(value, z)
        value = (moved[0] + c, moved[1])
    return value, slope


def _times(a: Complex[N], b: Complex[N]) -> Complex[N]:
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _over(a: Complex[N], b: Complex[N]) -> Complex[N]:
    size = b[0] * b[0] + b[1] * b[1]
    return (a[0] * b[0] + a[1] * b[1]) / size, (a[1] * b[0] - a[0] * b[1]) / size

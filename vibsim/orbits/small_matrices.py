"""Linear algebra of a few unknowns in numbers of any kit: what numpy does for doubles.

A matrix is a list of rows. Complex numbers are pairs (re, im), which every kit has.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from vibsim.engine.flows.closed import matrices
from vibsim.engine.flows.closed.matrices import Matrix
from vibsim.physics.arithmetic.numbers import Kit, N

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
        x[k] = kit.exact((rows[k][n] - rest) / rows[k][k])
    return x


def product(kit: Kit[N], one: Matrix[N], other: Matrix[N]) -> Matrix[N]:
    """Product of two square matrices."""
    return [kit.all_exact(row) for row in matrices.product(one, other)]


def characteristic_polynomial(kit: Kit[N], matrix: Matrix[N]) -> list[N]:
    """Coefficients c_0, ..., c_n = 1 of det(x - matrix), by the method of Faddeev and LeVerrier."""
    n, one = len(matrix), kit.number(1)
    coefficients, powers = [one], [[kit.number(0)] * n for _ in range(n)]
    for k in range(1, n + 1):
        shifted = [[powers[i][j] + (coefficients[-1] if i == j else 0) for j in range(n)] for i in range(n)]
        powers = product(kit, matrix, shifted)
        trace = sum((powers[i][i] for i in range(n)), kit.number(0))
        coefficients.append(kit.exact(-trace / k))
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
            roots[i] = (kit.exact(z[0] - step[0]), kit.exact(z[1] - step[1]))
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
    exact = kit.exact
    return (exact(value[0]), exact(value[1])), (exact(slope[0]), exact(slope[1]))


def _times(a: Complex[N], b: Complex[N]) -> Complex[N]:
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def _over(a: Complex[N], b: Complex[N]) -> Complex[N]:
    size = b[0] * b[0] + b[1] * b[1]
    return (a[0] * b[0] + a[1] * b[1]) / size, (a[1] * b[0] - a[0] * b[1]) / size

"""Matrices of doubles in one order of operations: what follows from them has the same bits on every machine.

A LAPACK or BLAS shares sums out by the vector units and threads of a machine, and fuses products where it
can. Here a matrix is a list of rows, sums go by ascending index, and each operation is rounded by itself.
These are the definition; `engine/matrices.c` repeats them operation by operation, and
`vibsim.orbits.stability` takes the copy where the engine was built.

Linear equations by Gaussian elimination with partial pivoting; singular values by one-sided Jacobi
rotations (Hestenes 1958; Golub and Van Loan, section 8.6.3); eigenvalues by balancing, Hessenberg form and
the QR method with double shifts (Martin, Peters and Wilkinson 1970; `hqr` of EISPACK).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import copysign, frexp, inf, isfinite, ldexp, sqrt
from typing import TYPE_CHECKING

from vibsim.physics.elementary import dot as sum_of_products

if TYPE_CHECKING:
    import numpy as np


Matrix = list[list[float]]

EPS = 2.0**-52
SWEEPS = 60  # of rotations, and of balancing: both converge within ten
STEPS = 60  # of the QR method to one eigenvalue; more than 30 have not been seen
UNUSUAL = (10, 20, 40)  # of these steps: with other shifts, where the usual ones go round in circles
WORTH = 0.95  # of the size of a row and its column: what balancing must gain


def product(A: Sequence[Sequence[float]], B: Sequence[Sequence[float]]) -> Matrix:
    """Matrix product (m, n) of A (m, k) and B (k, n), k > 0."""
    rows = []
    for row in A:
        sums = [row[0] * value for value in B[0]]
        for k in range(1, len(row)):
            factor = row[k]
            sums = [total + factor * value for total, value in zip(sums, B[k], strict=True)]
        rows.append(sums)
    return rows


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    """Sum of the products of two vectors."""
    total = 0.0
    for one, other in zip(a, b, strict=True):
        total = total + one * other
    return total


def solved(A: Sequence[Sequence[float]], b: Sequence[float]) -> tuple[list[float], float]:
    """(x, smallest pivot) of A x = b, A (n, n); the pivot is 0 where A is singular to the bit, and x is 0."""
    n = len(A)
    rows = [[*row, right] for row, right in zip(A, b, strict=True)]
    if _eliminate(rows) == 0.0:
        return [0.0] * n, 0.0
    x = [0.0] * n
    for k in range(n - 1, -1, -1):
        rest = rows[k][n]
        for i in range(k + 1, n):
            rest = rest - rows[k][i] * x[i]
        x[k] = rest / rows[k][k]
    return x, min((abs(rows[k][k]) for k in range(n)), default=inf)


def determinant(A: Sequence[Sequence[float]]) -> float:
    """Determinant of A (n, n), the product of the pivots."""
    rows = [list(row) for row in A]
    value = _eliminate(rows)
    for k in range(len(rows)):
        value = value * rows[k][k]
    return value


def _eliminate(rows: Matrix) -> float:
    """Gaussian elimination in place, the largest pivot of each column first: the sign of the exchanges of
    rows; 0 where a pivot is 0.
    """
    n, sign = len(rows), 1.0
    for k in range(n):
        place, largest = k, abs(rows[k][k])
        for i in range(k + 1, n):
            if abs(rows[i][k]) > largest:
                place, largest = i, abs(rows[i][k])
        if largest == 0.0:
            return 0.0
        if place != k:
            rows[k], rows[place], sign = rows[place], rows[k], -sign
        pivot = rows[k]
        for i in range(k + 1, n):
            row, share = rows[i], rows[i][k] / pivot[k]
            for j in range(k + 1, len(row)):
                row[j] = row[j] - share * pivot[j]
    return sign


def exponent_of(A: Sequence[Sequence[float]]) -> int | None:
    """Binary exponent of the largest entry; None where an entry is not finite."""
    largest = 0.0
    for row in A:
        for value in row:
            if not isfinite(value):
                return None
            largest = max(largest, abs(value))
    return frexp(largest)[1]


def singular(A: Sequence[Sequence[float]]) -> tuple[list[float], Matrix, Matrix] | None:
    """(values, V, W) of A (m, n): the n singular values, the largest first (those beyond m are rounding), the
    right singular vectors as the n rows of V, an orthogonal matrix, and A times each as the rows of W (n, m).
    None where A is not finite.

    The columns of A are turned in pairs until all are orthogonal but for rounding of the largest. A column of
    the size of that rounding belongs to the kernel, and is left.
    """
    exponent = exponent_of(A)
    if exponent is None:
        return None
    n = len(A[0])
    W = [[ldexp(row[j], -exponent) for row in A] for j in range(n)]
    V = [[1.0 if i == j else 0.0 for i in range(n)] for j in range(n)]
    least = 0.0
    for column in W:
        least = least + dot(column, column)
    least = (n * EPS) * (n * EPS) * least
    for _ in range(SWEEPS):
        turned = False
        for p in range(n - 1):
            for q in range(p + 1, n):
                turned = _turned(W, V, p, q, least) or turned
        if not turned:
            break
    sizes = [dot(column, column) for column in W]
    order = sorted(range(n), key=lambda j: -sizes[j])
    values = [ldexp(sqrt(sizes[j]), exponent) for j in order]
    return values, [V[j] for j in order], [[ldexp(value, exponent) for value in W[j]] for j in order]


def _turned(W: Matrix, V: Matrix, p: int, q: int, least: float) -> bool:
    """Turn two columns into each other until they are orthogonal; whether they were not."""
    a, b, across = dot(W[p], W[p]), dot(W[q], W[q]), dot(W[p], W[q])
    if a <= least or b <= least or abs(across) <= EPS * sqrt(a * b):
        return False
    slope = (b - a) / (2.0 * across)
    t = copysign(1.0, slope) / (abs(slope) + sqrt(1.0 + slope * slope))
    c = 1.0 / sqrt(1.0 + t * t)
    s = c * t
    for M in (W, V):
        one, other = M[p], M[q]
        M[p] = [c * x - s * y for x, y in zip(one, other, strict=True)]
        M[q] = [s * x + c * y for x, y in zip(one, other, strict=True)]
    return True


def eigenvalues(A: Sequence[Sequence[float]]) -> list[complex] | None:
    """Eigenvalues of A (n, n), with exact conjugates; those that zeros of a row or column isolate are exact.

    None where A is not finite, or the QR method does not converge.
    """
    exponent = exponent_of(A)
    if exponent is None:
        return None
    places, values = list(range(len(A))), []
    while (alone := _isolated(A, places)) is not None:
        places.remove(alone)
        values.append(complex(A[alone][alone], 0.0))
    H = [[ldexp(A[i][j], -exponent) for j in places] for i in places]
    _balance(H)
    _to_hessenberg(H)
    roots = _of_hessenberg(H)
    if roots is None:
        return None
    return [*values, *(complex(ldexp(re, exponent), ldexp(im, exponent)) for re, im in roots)]


def _isolated(A: Sequence[Sequence[float]], places: Sequence[int]) -> int | None:
    """The first of some rows and columns of which one has nothing but its diagonal entry among them."""
    for i in places:
        if not any(A[i][j] for j in places if j != i) or not any(A[j][i] for j in places if j != i):
            return i
    return None


def _balance(H: Matrix) -> None:
    """Scale rows and columns by powers of two until each row is about as large as its column."""
    n = len(H)
    for _ in range(SWEEPS):
        settled = True
        for i in range(n):
            column = row = 0.0
            for j in range(n):
                if j != i:
                    column, row = column + abs(H[j][i]), row + abs(H[i][j])
            if column == 0.0 or row == 0.0:
                continue
            factor, both = 1.0, column + row
            while column < row / 2.0 and factor < 2.0**200:
                factor, column, row = factor * 2.0, column * 2.0, row / 2.0
            while column > row * 2.0 and factor > 2.0**-200:
                factor, column, row = factor / 2.0, column / 2.0, row * 2.0
            if column + row < WORTH * both:
                settled = False
                for j in range(n):
                    H[i][j] = H[i][j] / factor
                for j in range(n):
                    H[j][i] = H[j][i] * factor
        if settled:
            return


def _to_hessenberg(H: Matrix) -> None:
    """Elimination with pivots to zeros below the first subdiagonal."""
    n = len(H)
    for m in range(1, n - 1):
        place, largest = m, abs(H[m][m - 1])
        for i in range(m + 1, n):
            if abs(H[i][m - 1]) > largest:
                place, largest = i, abs(H[i][m - 1])
        if largest == 0.0:
            continue
        if place != m:
            H[m], H[place] = H[place], H[m]
            for row in H:
                row[m], row[place] = row[place], row[m]
        for i in range(m + 1, n):
            share = H[i][m - 1] / H[m][m - 1]
            H[i][m - 1] = 0.0
            for j in range(m, n):
                H[i][j] = H[i][j] - share * H[m][j]
            for j in range(n):
                H[j][m] = H[j][m] + share * H[j][i]


def _of_hessenberg(H: Matrix) -> list[tuple[float, float]] | None:
    """(re, im) of the eigenvalues of a Hessenberg matrix, which is used up; None without convergence."""
    n, size = len(H), 0.0
    for i in range(n):
        for j in range(max(i - 1, 0), n):
            size = size + abs(H[i][j])
    roots: list[tuple[float, float]] = []
    last, step, shifted = n - 1, 0, 0.0
    while last >= 0:
        first = _start_of_block(H, last, size)
        if first == last:
            roots.append((H[last][last] + shifted, 0.0))
            last, step = last - 1, 0
        elif first == last - 1:
            roots += _of_pair(H, last, shifted)
            last, step = last - 2, 0
        elif step == STEPS:
            return None
        else:
            step += 1
            shifted = _qr_step(H, first, last, step, shifted)
    return roots


def _start_of_block(H: Matrix, last: int, size: float) -> int:
    """The first row of the block that ends at a row, whose subdiagonal entries are more than rounding."""
    for i in range(last, 0, -1):
        near = abs(H[i - 1][i - 1]) + abs(H[i][i])
        if near == 0.0:
            near = size
        if abs(H[i][i - 1]) + near == near:
            H[i][i - 1] = 0.0
            return i
    return 0


def _of_pair(H: Matrix, last: int, shifted: float) -> list[tuple[float, float]]:
    """Both eigenvalues of a block of two rows."""
    x, y = H[last][last], H[last - 1][last - 1]
    w = H[last][last - 1] * H[last - 1][last]
    p = 0.5 * (y - x)
    q = p * p + w
    z, x = sqrt(abs(q)), x + shifted
    if q < 0.0:
        return [(x + p, z), (x + p, -z)]
    z = p + copysign(z, p)
    return [(x + z, 0.0), (x - w / z if z != 0.0 else x + z, 0.0)]


def _qr_step(H: Matrix, first: int, last: int, step: int, shifted: float) -> float:
    """One step of the QR method with two shifts on a block; what is taken off the diagonal so far."""
    x, y = H[last][last], H[last - 1][last - 1]
    w = H[last][last - 1] * H[last - 1][last]
    if step in UNUSUAL:
        shifted = shifted + x
        for i in range(last + 1):
            H[i][i] = H[i][i] - x
        s = abs(H[last][last - 1]) + abs(H[last - 1][last - 2])
        x = y = 0.75 * s
        w = -0.4375 * s * s
    m, p, q, r = last - 2, 0.0, 0.0, 0.0
    while True:  # two subdiagonal entries in a row that are small
        z = H[m][m]
        r, s = x - z, y - z
        p = (r * s - w) / H[m + 1][m] + H[m][m + 1]
        q = H[m + 1][m + 1] - z - r - s
        r = H[m + 2][m + 1]
        s = abs(p) + abs(q) + abs(r)
        p, q, r = p / s, q / s, r / s
        if m == first:
            break
        u = abs(H[m][m - 1]) * (abs(q) + abs(r))
        v = abs(p) * (abs(H[m - 1][m - 1]) + abs(z) + abs(H[m + 1][m + 1]))
        if u + v == v:
            break
        m -= 1
    for i in range(m, last - 1):
        H[i + 2][i] = 0.0
        if i != m:
            H[i + 2][i - 1] = 0.0
    _chase(H, first, m, last, (p, q, r))
    return shifted


def _chase(H: Matrix, first: int, m: int, last: int, start: tuple[float, float, float]) -> None:
    """Reflections of three rows and columns each, down the block: the double step of Francis."""
    p, q, r = start
    x = 0.0
    for k in range(m, last):
        three = k + 1 != last
        if k != m:
            p, q, r = H[k][k - 1], H[k + 1][k - 1], H[k + 2][k - 1] if three else 0.0
            x = abs(p) + abs(q) + abs(r)
            if x == 0.0:
                continue
            p, q, r = p / x, q / x, r / x
        s = copysign(sqrt(p * p + q * q + r * r), p)
        if k != m:
            H[k][k - 1] = -s * x
        elif first != m:
            H[k][k - 1] = -H[k][k - 1]
        p = p + s
        x, y, z = p / s, q / s, r / s
        q, r = q / p, r / p
        for j in range(k, last + 1):
            p = H[k][j] + q * H[k + 1][j]
            if three:
                p = p + r * H[k + 2][j]
                H[k + 2][j] = H[k + 2][j] - p * z
            H[k + 1][j] = H[k + 1][j] - p * y
            H[k][j] = H[k][j] - p * x
        for i in range(first, min(last, k + 3) + 1):
            p = x * H[i][k] + y * H[i][k + 1]
            if three:
                p = p + z * H[i][k + 2]
                H[i][k + 2] = H[i][k + 2] - p * r
            H[i][k + 1] = H[i][k + 1] - p * q
            H[i][k] = H[i][k] - p


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

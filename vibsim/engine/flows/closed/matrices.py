"""Small matrices in numbers of any kit, lists of rows: factors, and one rotation that makes two diagonal."""

from __future__ import annotations

from typing import Any, Generic, cast

from vibsim.physics.numbers import Kit, N, abs

Matrix = list[list[N]]
SWEEPS = 60  # of Jacobi's rotations; they converge quadratically


def product(A: Matrix[N], B: Matrix[N]) -> Matrix[N]:
    """Matrix product, summed in the order of the indices."""
    rows: Matrix[N] = []
    for row in A:
        rows.append([])
        for j in range(len(B[0])):
            total = row[0] * B[0][j]
            for k in range(1, len(row)):
                total = total + row[k] * B[k][j]
            rows[-1].append(total)
    return rows


def transposed(A: Matrix[N]) -> Matrix[N]:
    return [list(column) for column in zip(*A, strict=True)]


def cholesky(kit: Kit[N], A: Matrix[N]) -> Matrix[N]:
    """Lower triangular L with L L' = A."""
    size = len(A)
    L = [[kit.number(0)] * size for _ in range(size)]
    for i in range(size):
        for j in range(i + 1):
            total = A[i][j]
            for k in range(j):
                total = total - L[i][k] * L[j][k]
            L[i][j] = kit.sqrt(total) if i == j else total / L[j][j]
    return L


def inverse_triangular(kit: Kit[N], L: Matrix[N]) -> Matrix[N]:
    """Inverse of a lower triangular matrix."""
    size = len(L)
    X = [[kit.number(0)] * size for _ in range(size)]
    for j in range(size):
        for i in range(j, size):
            total = kit.number(1 if i == j else 0)
            for k in range(j, i):
                total = total - L[i][k] * X[k][j]
            X[i][j] = total / L[i][i]
    return X


def norm(kit: Kit[N], A: Matrix[N]) -> N:
    total = kit.number(0)
    for row in A:
        for value in row:
            total = total + value * value
    return kit.sqrt(total)


def jacobi(kit: Kit[N], K: Matrix[N], C: Matrix[N]) -> Matrix[N] | None:
    """Orthogonal V that makes both symmetric matrices diagonal, or None where they do not commute (Jacobi's
    rotations for two matrices, Bunse-Gerstner, Byers & Mehrmann 1993).
    """
    size = len(K)
    scales = norm(kit, K), norm(kit, C)
    A = [
        [[value / scale for value in row] for row in M]
        for M, scale in zip((K, C), scales, strict=True)
        if scale > 0
    ]
    V = [[kit.number(1 if i == j else 0) for j in range(size)] for i in range(size)]
    small = 64 * kit.eps
    for _ in range(SWEEPS):
        turned = False
        for p in range(size - 1):
            for q in range(p + 1, size):
                turned = _rotate(kit, A, V, p, q, small) or turned
        if not turned:
            break
    off = max(
        (abs(M[i][j]) for M in A for i in range(size) for j in range(size) if i != j), default=kit.number(0)
    )
    return V if off <= 64 * size * kit.eps else None


def _rotate(kit: Kit[N], A: list[Matrix[N]], V: Matrix[N], p: int, q: int, small: N) -> bool:
    """One rotation of rows and columns p, q that makes the off-diagonal entries of all matrices least."""
    size = len(V)
    if max((abs(M[p][q]) for M in A), default=0) <= small / 64:
        return False
    h = [(M[p][p] - M[q][q], 2 * M[p][q]) for M in A]
    on = off = kit.number(0)
    for a, b in h:  # one by one: sum() of floats compensates from Python 3.12 on
        on, off = on + (a * a - b * b), off + 2 * a * b
    root = kit.sqrt(on * on + off * off)
    if root == 0:
        return False
    # cos and sin of the angle theta with tan(4 theta) = off / on, on the branch that shrinks the off-diagonal
    # entries
    # first that of cos and sin of 2 theta which is not small: the other follows without cancelling
    if on >= 0:
        double = kit.sqrt((1 + on / root) / 2)
        across = off / root / (2 * double)
    else:
        across = kit.sqrt((1 - on / root) / 2)
        across = across if off >= 0 else -across
        double = off / root / (2 * across)
    c = kit.sqrt((1 + double) / 2)
    s = across / (2 * c)
    if abs(s) <= kit.eps:
        return False
    for M in A:
        for k in range(size):
            a, b = M[k][p], M[k][q]
            M[k][p], M[k][q] = c * a + s * b, c * b - s * a
        for k in range(size):
            a, b = M[p][k], M[q][k]
            M[p][k], M[q][k] = c * a + s * b, c * b - s * a
    for k in range(size):
        a, b = V[k][p], V[k][q]
        V[k][p], V[k][q] = c * a + s * b, c * b - s * a
    return True


# Magnitudes of sums and products: what their rounding is proportional to, however much they cancel.


class Magnitude(Generic[N]):
    """A number of which only the magnitude counts: |a + b| and |a - b| are taken as |a| + |b|.

    What is written for numbers gives, on magnitudes, the sum of the magnitudes of its terms. Such a number is
    zero only where every term is.
    """

    __slots__ = ("size",)

    def __init__(self, value: N | int) -> None:
        self.size = abs(value)

    def __add__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size + size_of(other))

    __radd__ = __sub__ = __rsub__ = __add__

    def __mul__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size * size_of(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Magnitude[N]:
        return Magnitude(self.size / size_of(other))

    def __neg__(self) -> Magnitude[N]:
        return self

    def __eq__(self, other: object) -> bool:
        return bool(self.size == other)

    __hash__ = None  # type: ignore[assignment]


def size_of(value: Any) -> Any:
    """The magnitude of a number, or of a `Magnitude` what it stands for."""
    return value.size if isinstance(value, Magnitude) else abs(value)


def magnitudes(values: list[N]) -> list[N]:
    """The numbers as magnitudes, for what is written for numbers."""
    return cast("list[N]", [Magnitude(value) for value in values])

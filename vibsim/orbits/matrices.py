"""Matrices and vectors of a few unknowns, as arrays, with the same bits on every machine.

What numpy and scipy offer goes to a LAPACK and a BLAS, which round as the processor's vector units and their
threads have it: then rounding decides on which machine a special point is found. Here it is
`vibsim.physics.arithmetic.matrices`, or its copy in C where the engine was built.
"""

from __future__ import annotations

from math import copysign, sqrt
from typing import NamedTuple

import numpy as np

from vibsim.physics.arithmetic import matrices

try:
    from vibsim.engine import _engine as in_c
except ImportError:  # installed without a compiler: the definition itself
    in_c = None  # type: ignore[assignment]


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
    if in_c:
        in_c.product(one, other, out)
    else:
        rows = np.atleast_2d(one).tolist()
        columns = (other if other.ndim == 2 else other[:, None]).tolist()
        out[...] = np.reshape(matrices.product(rows, columns), shape)
    return out


def dot(one: np.ndarray, other: np.ndarray) -> float:
    """Sum of the products of two vectors."""
    if in_c:
        return in_c.dot(_plain(one), _plain(other))
    return matrices.dot(one.tolist(), other.tolist())


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
    if in_c:
        smallest = in_c.solved(_plain(matrix), _plain(right), x)
    else:
        x[:], smallest = matrices.solved(matrix.tolist(), right.tolist())
    return x, smallest / length_of(matrix) if smallest > 0 else 0.0


def determinant(matrix: np.ndarray) -> float:
    """By factors with pivots."""
    if not len(matrix):
        return 1.0
    return in_c.determinant(_plain(matrix)) if in_c else matrices.determinant(matrix.tolist())


def directions(matrix: np.ndarray) -> Directions:
    """Singular values and vectors. Raises NoEigenvalues for a matrix that is not finite."""
    m, n = matrix.shape
    if in_c:
        out = np.empty(n * (1 + n + m))
        if in_c.singular(_plain(matrix), out):
            return Directions(out[:n], out[n : n + n * n].reshape(n, n), out[n + n * n :].reshape(n, m))
        raise NoEigenvalues("the matrix is not finite")
    answer = matrices.singular(matrix.tolist()) if m else ([0.0] * n, np.eye(n), np.empty((n, 0)))
    if answer is None:
        raise NoEigenvalues("the matrix is not finite")
    return Directions(*(np.array(each) for each in answer))


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
    if in_c:
        out = np.empty((len(matrix), 2))
        known = in_c.eigenvalues(_plain(matrix), out)
        values = [complex(re, im) for re, im in out.tolist()] if known else None
    else:
        values = matrices.eigenvalues(matrix.tolist())
    if values is None:
        raise NoEigenvalues("eigenvalues did not converge, or the matrix is not finite")
    return values

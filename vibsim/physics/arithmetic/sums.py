"""Sums of arrays in one order, so that their bits are the same everywhere.

A dot product of numpy goes to whatever BLAS is installed, which shares it out among its threads; the order of
numpy's own sums is that of its release. Here the second half of the values is added to the first, then the
second half of that, and so on: element by element, each addition that of IEEE 754, in an order that the
number of values alone decides. It is as fast, and its rounding errors grow like log2(n).
"""

import numpy as np


def total(values: np.ndarray) -> np.ndarray:
    """Sum over the last axis of an array (..., n), shape (...); 0 for n = 0."""
    values = np.asarray(values, dtype="f8")
    if not values.shape[-1]:
        return np.zeros(values.shape[:-1])
    while (count := values.shape[-1]) > 1:
        half = (count + 1) // 2  # of an odd number the one in the middle waits
        sums = values[..., :half].copy()
        sums[..., : count - half] += values[..., half:]
        values = sums
    return values[..., 0]


def mean(values: np.ndarray) -> np.ndarray:
    """Mean over the last axis of an array (..., n), n > 0."""
    means: np.ndarray = total(values) / np.shape(values)[-1]
    return means


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sum of products over the last axis of two arrays, which numpy stretches to one shape."""
    return total(np.asarray(a) * b)

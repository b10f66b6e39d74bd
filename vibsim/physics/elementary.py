"""Elementary functions of doubles with the same bits on every machine.

Additions, products, quotients and square roots only: the C library's functions differ in last bits between
libraries, and between processors with and without fused products; a chaotic motion makes another motion of
that. They stand in `vibsim/engine/elementary.h`. Each is right to one or two units in the last place.
"""

import math
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vibsim.engine import _engine
from vibsim.engine._engine import asin as asin
from vibsim.engine._engine import cos as cos
from vibsim.engine._engine import exp as exp
from vibsim.engine._engine import log as log
from vibsim.engine._engine import power as power
from vibsim.engine._engine import sin as sin
from vibsim.engine._engine import sine_cosine as sine_cosine
from vibsim.engine._engine import sines_cosines

TWO_PI = 6.283185307179586
PER_LN_2, PER_LN_10 = 1.4426950408889634, 0.4342944819032518
VELTKAMP = 134217729.0  # 2**27 + 1: splits a double into two halves of 26 bits


def function(name: str) -> Callable[[float], float]:
    """The elementary function that formulas call by that name."""
    of: Callable[[float], float] = getattr(_engine, name)
    return of


def log2(x: float) -> float:
    """Binary logarithm, exact for powers of two."""
    m, e = math.frexp(x)
    return e + log(m) * PER_LN_2 if m != 0.5 else e - 1.0


def log10(x: float) -> float:
    """Decimal logarithm."""
    return log(x) * PER_LN_10


def sine_cosine_of_arrays(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sines and cosines of angles [rad] of any shape, right to 2e-16 up to a million radians.

    Of larger angles n the error is that of n eps, as of the angles themselves.
    """
    angles = np.asarray(angles, dtype="f8", order="C")
    sine, cosine = np.empty_like(angles), np.empty_like(angles)
    sines_cosines(angles, sine, cosine)
    return sine, cosine


# Sums of arrays in one order, so that their bits are the same everywhere.
#
# A dot product of numpy goes to whatever BLAS is installed, which shares it out among its threads; the order
# of numpy's own sums is that of its release. Here the second half of the values is added to the first, then
# the second half of that, and so on: element by element, each addition that of IEEE 754, in an order that the
# number of values alone decides. It is as fast, and its rounding errors grow like log2(n).


def total(values: np.ndarray) -> np.ndarray:
    """Sum over the last axis of an array (..., n), shape (...); 0 for n = 0."""
    values = np.asarray(values, dtype="f8")
    if not values.shape[-1]:
        return np.zeros(values.shape[:-1])
    while (count := values.shape[-1]) > 2:
        half = (count + 1) // 2  # of an odd number the one in the middle waits
        sums = values[..., :half].copy()
        sums[..., : count - half] += values[..., half:]
        values = sums
    return values[..., 0] + values[..., 1] if count == 2 else values[..., 0]


def mean(values: np.ndarray) -> np.ndarray:
    """Mean over the last axis of an array (..., n), n > 0."""
    means: np.ndarray = total(values) / np.shape(values)[-1]
    return means


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sum of products over the last axis of two arrays, which numpy stretches to one shape."""
    return total(np.asarray(a) * b)


# Gauss-Legendre quadrature on [0, 1]: n nodes integrate polynomials of degree 2 n - 1 exactly.


class Quadrature(NamedTuple):
    """Nodes, ascending, and their weights."""

    nodes: tuple[float, ...]
    weights: tuple[float, ...]


# fmt: off
TWELVE = Quadrature(
    nodes=(
        0.009219682876640375, 0.04794137181476257, 0.11504866290284765, 0.2063410228566913,
        0.3160842505009099, 0.43738329574426554, 0.5626167042557345, 0.6839157494990901, 0.7936589771433087,
        0.8849513370971523, 0.9520586281852375, 0.9907803171233597,
    ),
    weights=(
        0.023587668193255914, 0.05346966299765921, 0.08003916427167311, 0.10158371336153296,
        0.1167462682691774, 0.12457352290670139, 0.12457352290670139, 0.1167462682691774,
        0.10158371336153296, 0.08003916427167311, 0.05346966299765921, 0.023587668193255914,
    ),
)
EIGHT = Quadrature(
    nodes=(
        0.019855071751231884, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751,
        0.591717321247825, 0.7627662049581645, 0.8983332387068134, 0.9801449282487681,
    ),
    weights=(
        0.05061426814518813, 0.11119051722668721, 0.15685332293894363, 0.181341891689181,
        0.181341891689181, 0.15685332293894363, 0.11119051722668721, 0.05061426814518813,
    ),
)


# Correctly rounded products and quotients with 2 pi, from exact fractions.
#
# Hertz become rad/s, and rad/s cycles, with no error beyond the one rounding of the result: 2 pi is enclosed
# between two fractions, and the enclosure is narrowed until both ends round to one double (Ziv's strategy).


FIRST_BITS = 192  # more than three doubles: the loop below almost never goes round twice


def _arctan_inverse(n: int, bits: int) -> int:
    """arctan(1/n) * 2**bits, each of the fewer than `bits` terms truncated (error below `bits` units)."""
    power = (1 << bits) // n
    total, k, sign = power, 1, 1
    while power:
        power //= n * n
        k += 2
        sign = -sign
        total += sign * (power // k)
    return total


@lru_cache(maxsize=8)
def two_pi_bounds(bits: int) -> tuple[Fraction, Fraction]:
    """Fractions below and above 2 pi, about 2**-bits apart; Machin: pi = 16 arctan(1/5) - 4 arctan(1/239)."""
    work = bits + 32
    two_pi = 2 * (16 * _arctan_inverse(5, work) - 4 * _arctan_inverse(239, work))
    slack = 64 * work  # 2 (16 + 4) units per truncated term, rounded up
    scale = 1 << work
    return Fraction(two_pi - slack, scale), Fraction(two_pi + slack, scale)


def two_pi_fraction(digits: int) -> Fraction:
    """2 pi as a fraction, right to `digits` decimal digits."""
    return two_pi_bounds(digits * 4 + 8)[0]


def _rounded(function: Callable[[Fraction], float]) -> float:
    """function(2 pi), for a function that is monotone and rounds its result correctly."""
    bits = FIRST_BITS
    while True:
        low, high = two_pi_bounds(bits)
        first, second = function(low), function(high)
        if first == second:
            return first
        bits *= 2


def times_two_pi(value: Fraction, power: int = 1) -> float:
    """value * (2 pi)**power, correctly rounded: cycles to rad, Hz to rad/s; power 0 is plain rounding.

    Division of whole numbers rounds correctly, and asks for no common divisors as fractions do.
    """
    top, bottom = value.numerator, value.denominator
    if power == 0 or top == 0:
        return top / bottom
    if power == 1:
        return _rounded(lambda two_pi: top * two_pi.numerator / (bottom * two_pi.denominator))
    return _rounded(lambda two_pi: float(value * two_pi**power))


def radians_to_turns(radians: Fraction) -> tuple[float, float]:
    """radians / (2 pi) as an unevaluated double-double (high, low): rad/s to Hz with 106 bits."""
    high = _rounded(lambda two_pi: float(radians / two_pi))
    return high, _rounded(lambda two_pi: float(radians / two_pi - Fraction(high)))

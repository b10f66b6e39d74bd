"""Elementary functions of doubles with the same bits on every machine.

Additions, products, quotients and square roots only: the C library's functions differ in last bits between
libraries, and between processors with and without fused products; a chaotic motion makes another motion of
that. The operations stand in a fixed order, which `engine/elementary.h` repeats. Each is right to one or two
units in the last place.

An argument is reduced by whole multiples of pi/2 or ln 2, which are split so that the products are exact, and
the Taylor series of what is left is summed in pairs of pairs, which shortens the chain of operations.
"""

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

if TYPE_CHECKING:
    import numpy as np


X = TypeVar("X", float, "np.ndarray")

WHOLE = 6755399441055744.0  # 1.5 * 2**52: adding it rounds to a whole number, which the last bits then hold
QUARTERS = 2 / math.pi  # quarter turns to a radian
# pi/2 in three parts; a whole number below 2^20 times one of the first two is exact
FIRST, SECOND, THIRD = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21
LARGEST = 1.6e6  # [rad], below 2^20 quarter turns
TWO_PI = 6.283185307179586
# of (sin r / r - 1) / r^2; left out: (pi/4)^18 / 19! < 2e-19
SINE = [(-1) ** n / math.factorial(2 * n + 1) for n in range(1, 9)]
# of (cos r - 1 + r^2/2) / r^4; left out: (pi/4)^18 / 18! < 3e-18
COSINE = [(-1) ** n / math.factorial(2 * n) for n in range(2, 9)]

PER_LN_2, PER_LN_10 = 1.4426950408889634, 0.4342944819032518
LN_2, LN_2_LO = 0.6931471803691238, 1.9082149292705877e-10  # their sum; of the first, the last 21 bits are 0
EXPONENTIAL = [1 / math.factorial(n) for n in range(2, 14)]  # left out: 0.35^14 / 14! < 5e-18
FLAT = 1400.0  # beyond which exp is 0 or infinite
ROOT_HALF = 0.7071067811865476
LOGARITHM = [2 / (2 * n + 1) for n in range(1, 13)]  # left out: 0.03^13 / 27 < 1e-21

HALF_PI, HALF_PI_LO = 1.5707963267948966, 6.123233995736766e-17  # their sum; likewise of the following pairs
ARCTANGENT = [(-1) ** n / (2 * n + 1) for n in range(1, 13)]  # left out: 0.25^26 / 27 < 9e-18
# (up to |x|, c, atan(c)): between such borders x - c is exact and |x - c| / (1 + c x) at most 1/4
ANGLES = (
    (0.75, 0.5, 0.4636476090008061, 2.2698777452961687e-17),
    (1.5, 1.0, 0.7853981633974483, 3.061616997868383e-17),
    (4.0, 2.0, 1.1071487177940904, 9.40447137356638e-17),
)
VELTKAMP = 134217729.0  # 2**27 + 1: splits a double into two halves of 26 bits
ONE_THIRD, ONE_THIRD_LO = 0.3333333333333333, 1.850371707708594e-17
ONE_FIFTH, ONE_FIFTH_LO = 0.2, -1.1102230246251566e-17
AREA_TANGENT = [1 / (2 * n + 1) for n in range(3, 15)]  # left out: 0.03^15 / 31 < 1e-24


def off_quarters(angle: X) -> tuple[X, X, X]:
    """Whole quarter turns in an angle [rad] below LARGEST, and sine and cosine of what is left: at most pi/4.

    Of a double, or of an array with the same bits.
    """
    quarters = (angle * QUARTERS + WHOLE) - WHOLE
    r = ((angle - quarters * FIRST) - quarters * SECOND) - quarters * THIRD
    z = r * r
    z2 = z * z
    z4 = z2 * z2
    a, b = SINE, COSINE
    s = ((a[0] + a[1] * z) + (a[2] + a[3] * z) * z2) + ((a[4] + a[5] * z) + (a[6] + a[7] * z) * z2) * z4
    c = ((b[0] + b[1] * z) + (b[2] + b[3] * z) * z2) + ((b[4] + b[5] * z) + b[6] * z2) * z4
    half = 0.5 * z
    near = 1 - half
    return quarters, r + r * (z * s), near + (((1 - near) - half) + z2 * c)


def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle [rad]; beyond a million radians with the error that n eps in it makes."""
    if not -LARGEST < angle < LARGEST:
        angle = math.fmod(angle, TWO_PI) if math.isfinite(angle) else math.nan
    if angle != angle:
        return angle, angle
    quarters, sine, cosine = off_quarters(angle)
    quadrant = int(quarters) & 3
    if quadrant & 1:
        sine, cosine = cosine, sine
    return -sine if quadrant & 2 else sine, -cosine if quadrant + 1 & 2 else cosine


def sin(angle: float) -> float:
    """Sine of an angle [rad]."""
    return sine_cosine(angle)[0]


def cos(angle: float) -> float:
    """Cosine of an angle [rad]."""
    return sine_cosine(angle)[1]


def asin(x: float) -> float:
    """Angle [rad] from -pi/2 to pi/2 of a sine; nan beyond 1. By Newton's method."""
    if not abs(x) <= 1.0:
        return math.nan
    if abs(x) > ROOT_HALF:
        return math.copysign(TWO_PI / 4 - 2 * asin(math.sqrt((1 - abs(x)) / 2)), x)
    square = x * x
    angle = x * (1 + square * (1 / 6 + square * (3 / 40 + square * (15 / 336 + square * (105 / 3456)))))
    for _ in range(3):  # from 0.02 at most
        sine, cosine = sine_cosine(angle)
        angle = angle + (x - sine) / cosine
    return angle


def acos(x: float) -> float:
    """Angle [rad] from 0 to pi of a cosine; nan beyond 1."""
    if not abs(x) <= 1.0:
        return math.nan
    if x > 0.5:
        return 2 * asin(math.sqrt((1 - x) / 2))
    if x < -0.5:
        return 2 * HALF_PI - (2 * asin(math.sqrt((1 + x) / 2)) - 2 * HALF_PI_LO)
    return HALF_PI - (asin(x) - HALF_PI_LO)


def atan(x: float) -> float:
    """Angle [rad] from -pi/2 to pi/2 of a tangent: atan(c) + atan((x - c) / (1 + c x)), c near x."""
    size = abs(x)
    if size <= 0.25:
        return x + x * (x * x * _sum_of_twelve(ARCTANGENT, x * x))
    r, at, at_lo = -1 / size, HALF_PI, HALF_PI_LO
    for border, c, angle, angle_lo in ANGLES:
        if size <= border:
            r, at, at_lo = (size - c) / (1 + c * size), angle, angle_lo
            break
    z = r * r
    return math.copysign(at + (r + (r * (z * _sum_of_twelve(ARCTANGENT, z)) + at_lo)), x)


def _sum_of_twelve(c: Sequence[float], x: float) -> float:
    """c[0] + c[1] x + ... + c[11] x^11."""
    x2 = x * x
    x4 = x2 * x2
    low = (c[0] + c[1] * x) + (c[2] + c[3] * x) * x2
    middle = (c[4] + c[5] * x) + (c[6] + c[7] * x) * x2
    high = (c[8] + c[9] * x) + (c[10] + c[11] * x) * x2
    return low + (middle + high * x4) * x4


def _reduced(x: float) -> tuple[float, float]:
    """(n, exp(r) - 1) of x = n ln 2 + r, |r| < 0.35; x is not nan."""
    n = (x * PER_LN_2 + WHOLE) - WHOLE
    r = (x - n * LN_2) - n * LN_2_LO
    return n, r + r * r * _sum_of_twelve(EXPONENTIAL, r)


def exp(x: float) -> float:
    """exp(x); 0 or infinite where that is what is nearest."""
    if x != x:
        return x
    return _scaled(*_reduced(-FLAT if x < -FLAT else FLAT if x > FLAT else x))


def _scaled(n: float, rise: float) -> float:
    """(1 + rise) 2^n, infinite or rounded to what is below normal numbers where that is nearest."""
    first = (n * 0.5 + WHOLE) - WHOLE
    return ((1 + rise) * math.ldexp(1.0, int(first))) * math.ldexp(1.0, int(n - first))


def expm1(x: float) -> float:
    """exp(x) - 1."""
    if not -40.0 < x < 700.0:
        return exp(x) - 1
    n, rise = _reduced(x)
    if n == 0:
        return rise
    scale = math.ldexp(1.0, int(n))
    return scale * rise + (scale - 1)


def sinh(x: float) -> float:
    """Hyperbolic sine."""
    if -1.0 < x < 1.0:
        rise = expm1(x)
        return (rise + rise / (1 + rise)) / 2
    return (exp(x) - exp(-x)) / 2


def cosh(x: float) -> float:
    """Hyperbolic cosine."""
    return (exp(x) + exp(-x)) / 2


def tanh(x: float) -> float:
    """Hyperbolic tangent."""
    rise = expm1(2 * abs(x))
    if rise > 1.0:
        return math.copysign(1 - 2 / (rise + 2), x)
    return math.copysign(rise / (rise + 2), x)


def log(x: float) -> float:
    """Natural logarithm; -infinity of 0, nan of what is below it."""
    if not 0.0 < x < math.inf:
        return -math.inf if x == 0 else x if x > 0 else math.nan
    m, e = math.frexp(x)
    if m < ROOT_HALF:
        m, e = m + m, e - 1
    f = m - 1
    s = f / (2 + f)
    z = s * s
    rest = z * _sum_of_twelve(LOGARITHM, z)
    half = 0.5 * f * f
    return e * LN_2 - ((half - (s * (half + rest) + e * LN_2_LO)) - f)


def log2(x: float) -> float:
    """Binary logarithm, exact for powers of two."""
    m, e = math.frexp(x)
    return e + log(m) * PER_LN_2 if m != 0.5 else e - 1.0


def log10(x: float) -> float:
    """Decimal logarithm."""
    return log(x) * PER_LN_10


def power(a: float, p: float) -> float:
    """a**p for a >= 0, nan of a below 0; 1 for p = 0.

    By roots and products where |p| is 1/2, 3/2 or 5/2; else exp(p log a), the logarithm as a sum of two
    doubles: p log a is up to 745, and a relative error of eps in it would be 745 eps in the power.
    """
    if not 0.0 < a < math.inf:
        if p == 0 or not a >= 0:
            return 1.0 if p == 0 else math.nan
        return p if p != p else 0.0 if (a == 0) == (p > 0) else math.inf
    if p == 0.5:
        return math.sqrt(a)
    if p == 1.5:
        return a * math.sqrt(a)
    if p == 2.5:
        return a * a * math.sqrt(a)
    if p == -0.5:
        return 1 / math.sqrt(a)
    if p == -1.5:
        return 1 / a / math.sqrt(a)
    if p == -2.5:
        return 1 / a / a / math.sqrt(a)
    return _general_power(a, p)


def _general_power(a: float, p: float) -> float:
    """exp(p log a) of a finite a > 0."""
    high, low = _long_log(a)
    y = p * high
    if not -FLAT < y < FLAT:
        return exp(y)
    y_lo = _product_error(p, high, y) + p * low
    n, rise = _reduced(y)
    return _scaled(n, rise + (y_lo + y_lo * rise))


# Sums of two doubles, the second below the rounding of the first (Dekker 1971).


def _product_error(a: float, b: float, product: float) -> float:
    """a b - product, product = a b rounded: exactly, as long as it is a normal number."""
    wide = VELTKAMP * a
    a1 = wide - (wide - a)
    a2 = a - a1
    wide = VELTKAMP * b
    b1 = wide - (wide - b)
    b2 = b - b1
    return ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2


def _long_sum(a: float, b: float, low: float) -> tuple[float, float]:
    """a + b + low, |a| >= |b| or a = 0, low of the size of rounding."""
    total = a + b
    rest = (b - (total - a)) + low
    high = total + rest
    return high, rest - (high - total)


def _long_product(a: float, a_lo: float, b: float, b_lo: float) -> tuple[float, float]:
    """(a + a_lo) (b + b_lo)."""
    product = a * b
    rest = _product_error(a, b, product) + (a * b_lo + a_lo * b)
    high = product + rest
    return high, rest - (high - product)


def _long_log(a: float) -> tuple[float, float]:
    """Natural logarithm of a finite a > 0 to 2^-66 of itself.

    ln(2^e m) = e ln 2 + 2 artanh s, s = f / (2 + f), f = m - 1; artanh s = s (1 + z/3 + z^2/5 + ...), z = s^2
    """
    m, e = math.frexp(a)
    if m < ROOT_HALF:
        m, e = m + m, e - 1
    f = m - 1
    under = 2 + f
    s = f / under
    product = s * under
    s_lo = (((f - product) - _product_error(s, under, product)) - s * (f - (under - 2))) / under
    z, z_lo = _long_product(s, s_lo, s, s_lo)
    high, low = _long_sum(ONE_FIFTH, z * _sum_of_twelve(AREA_TANGENT, z), ONE_FIFTH_LO)
    high, low = _long_product(z, z_lo, high, low)
    high, low = _long_sum(ONE_THIRD, high, low + ONE_THIRD_LO)
    high, low = _long_product(z, z_lo, high, low)
    high, low = _long_product(s, s_lo, high, low)
    high, low = _long_sum(s, high, low + s_lo)
    high, low = _long_sum(e * LN_2, 2 * high, 2 * low)
    return _long_sum(high, e * LN_2_LO, low)


# Sine and cosine of many angles: `vibsim.physics.elementary`, operation by operation on arrays.
#
# numpy's own pick other code for other vector units, with other last bits.


def sine_cosine_of_arrays(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sines and cosines of angles [rad] of any shape, right to 2e-16 up to a million radians.

    Of larger angles n the error is that of n eps, as of the angles themselves.
    """
    angles = np.asarray(angles, dtype="f8")
    if np.any(np.abs(angles) >= LARGEST):
        angles = np.where(np.abs(angles) < LARGEST, angles, np.fmod(angles, TWO_PI))
    quarters, sine, cosine = off_quarters(angles)
    quadrant = quarters - 4 * np.floor(quarters / 4)
    swapped = (quadrant == 1) | (quadrant == 3)
    first, second = np.where(swapped, cosine, sine), np.where(swapped, sine, cosine)
    return (
        np.where(quadrant >= 2, -first, first),
        np.where((quadrant == 1) | (quadrant == 2), -second, second),
    )


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

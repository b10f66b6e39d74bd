"""Correctly rounded products and quotients with 2 pi, from exact fractions.

Hertz become rad/s, and rad/s cycles, with no error beyond the one rounding of the result: 2 pi is enclosed
between two fractions, and the enclosure is narrowed until both ends round to one double (Ziv's strategy).
"""

from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache

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

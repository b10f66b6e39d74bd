"""Binary numbers of any length as doubles and as decimal text, each rounded once."""

from decimal import ROUND_HALF_EVEN, Context, Decimal
from functools import lru_cache
from math import inf

SPARE = 12  # digits beyond those shown: the text is then the nearest one but for ties that no run meets
EXPONENT_ROOM = 8  # sign, point, "e" and an exponent of five characters


def nearest_double(mantissa: int, exponent: int) -> float:
    """The double nearest to mantissa 2**exponent (ints), subnormal or not; +-inf beyond them all."""
    try:
        if exponent >= 0:
            return float(mantissa << exponent)
        return mantissa / (1 << -exponent)  # Python divides whole numbers with one rounding
    except OverflowError:
        return inf if mantissa > 0 else -inf


def decimal_text(parts: tuple[int, int], digits: int) -> str:
    """m 2**e to so many significant decimal digits, "-4.98...e-3"; parts: the whole numbers m, e."""
    mantissa, exponent = parts
    if not mantissa:
        return f"{0:.{digits - 1}e}"
    context = _context(digits + SPARE)
    value = context.multiply(context.create_decimal(mantissa), _power_of_two(exponent, digits + SPARE))
    return f"{value:.{digits - 1}e}"


def text_width(digits: int) -> int:
    """Characters that the text of any number takes at most."""
    return digits + EXPONENT_ROOM


@lru_cache(maxsize=8)
def _context(digits: int) -> Context:
    return Context(prec=digits, rounding=ROUND_HALF_EVEN, Emin=-999999999, Emax=999999999)


@lru_cache(maxsize=4096)
def _power_of_two(exponent: int, digits: int) -> Decimal:
    context = _context(digits)
    return context.power(context.create_decimal(2), exponent)

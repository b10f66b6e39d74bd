"""Numbers of any length as doubles and as text, against fractions."""

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.physics.numbers import decimal_text, nearest_double, text_width


@given(st.integers(-(2**300), 2**300), st.integers(-1500, 600))
def test_doubles_are_the_nearest(mantissa, exponent):
    value = nearest_double(mantissa, exponent)
    if not math.isfinite(value):
        assert abs(mantissa) * Fraction(2) ** exponent >= Fraction(2**1024 - 2**970)
        return
    exact = mantissa * Fraction(2) ** exponent
    for other in (math.nextafter(value, math.inf), math.nextafter(value, -math.inf)):
        if math.isfinite(other):
            assert abs(exact - Fraction(value)) <= abs(exact - Fraction(other))


@given(st.integers(-(2**300), 2**300), st.integers(-1500, 600), st.integers(20, 90))
def test_texts_are_right_to_the_last_digit(mantissa, exponent, digits):
    text = decimal_text((mantissa, exponent), digits)
    exact = mantissa * Fraction(2) ** exponent
    assert len(text) <= text_width(digits)
    assert sum(letter.isdigit() for letter in text.split("e")[0]) == digits
    if mantissa:
        last_place = Fraction(10) ** (int(text.split("e")[1]) - digits + 1)
        assert abs(Fraction(text) - exact) <= last_place / 2


@pytest.mark.parametrize("digits", [20, 60])
def test_zero_has_digits_too(digits):
    assert float(decimal_text((0, 0), digits)) == 0.0

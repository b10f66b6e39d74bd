"""Phases keep full accuracy at any time: against exact rational arithmetic and mpmath."""

import math
from fractions import Fraction

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.physics.numbers import TWO_PI, TWO_PI_LO, Doubles
from vibsim.physics.precision import number_kit

EPS = 2.0**-53
frequencies = st.floats(1e-3, 1e3)
times = st.one_of(st.floats(1e-3, 1e3), st.floats(1e6, 1e9))


def exact_turns(cycles, cycles_lo, t):
    """(cycles + cycles_lo) t less the nearest whole turn, exactly."""
    turns = (Fraction(cycles) + Fraction(cycles_lo)) * Fraction(t)
    return turns - math.floor(turns + Fraction(1, 2))


def distance(turns, other):
    """Distance of two angles, in turns, on the circle."""
    gap = abs(turns - other)
    return min(gap, 1 - gap)


@given(frequencies, times, st.floats(-0.5, 0.5))
def test_turn_angle(cycles, t, share):
    cycles_lo = share * math.ulp(cycles)
    angle = Doubles.turn_angle(cycles, cycles_lo, t)
    exact = exact_turns(cycles, cycles_lo, t)
    assert abs(angle) <= math.pi * (1 + 4 * EPS)
    with mpmath.workdps(40):
        got = Fraction(*mpmath_ratio(mpmath.mpf(angle) / (2 * mpmath.pi)))
    # rounding of the sum of parts up to 1/2 turn, of cycles_lo t (eps of half an ulp of it) and of 2 pi
    small = Fraction(EPS) ** 2 * Fraction(cycles) * Fraction(t)
    assert (
        distance(got, exact)
        <= 2 * Fraction(EPS) * abs(exact) + Fraction(EPS) * Fraction(1, 2**20) + 4 * small
    )


def mpmath_ratio(value):
    numerator = int(mpmath.floor(value * mpmath.mpf(2) ** 120))
    return numerator, 2**120


@pytest.mark.parametrize("t", (1e6, 123456789.0, 1e9))
def test_turn_angle_of_the_papers_frequencies_at_late_times(t):
    # 3.3 Hz is no double: its phase needs the low part, 1e9 s x 4e-17 of a turn
    for text in ("3.5", "5.5", "6.5", "3.3", "0.1"):
        exact = Fraction(text)
        cycles = float(exact)
        angle = Doubles.turn_angle(cycles, float(exact - Fraction(cycles)), t)
        turns = exact * Fraction(t)
        rest = float(turns - math.floor(turns + Fraction(1, 2)))
        gap = abs(angle - 2 * math.pi * rest)
        assert min(gap, 2 * math.pi - gap) <= 4 * EPS * max(abs(angle), 1e-3)


@given(st.one_of(st.floats(-10, 10), st.floats(-1e4, 1e4)))
def test_reduce_angle(angle):
    reduced, turns = Doubles.reduce_angle(angle)
    assert turns == math.floor(turns)
    assert abs(reduced) <= math.pi * (1 + 4 * EPS) + 4 * EPS * abs(angle)
    with mpmath.workdps(40):
        exact = mpmath.mpf(angle) - 2 * mpmath.pi * turns
        # turns x TWO_PI is rounded: up to eps of the angle; exact for the |turns| <= 1 of a step
        allowed = 2 * EPS * abs(reduced) + EPS * abs(angle) * (abs(turns) > 1)
        assert abs(reduced - exact) <= allowed


def test_two_pi_in_two_parts():
    with mpmath.workdps(40):
        assert abs(mpmath.mpf(TWO_PI) + mpmath.mpf(TWO_PI_LO) - 2 * mpmath.pi) < 1e-31


@given(st.integers(-1000, 1000), st.floats(-3.14, 3.14))
def test_unwind_undoes_reduce(turns, phase):
    assert Doubles.unwind(phase, float(turns)) == pytest.approx(phase + 2 * math.pi * turns, rel=2 * EPS)


@pytest.mark.parametrize("halves", (1, 3, 1001))
@pytest.mark.parametrize("digits", (30, 40, 60))
def test_angles_of_many_digits_at_half_turns(digits, halves):
    """The middle of 0.5 turns and its rounding lie on both sides of where whole turns begin to count up: of a
    ball with both in it the floor was both, and a base that turned by half a turn between two events stood
    at 0 from then on.
    """
    pytest.importorskip("flint")
    kit = number_kit(digits)
    cycles = kit.number(Fraction(212, 100))
    exact = kit.number(Fraction(halves, 2)) / cycles
    for t in (exact.mid(), kit.next_after(exact.mid(), math.inf), exact.mid() * (1 - kit.eps)):
        angle = kit.turn_angle(cycles, kit.number(0), t)
        assert abs(kit.cos(angle) + 1) < 1e-25
        phase, turns = kit.reduce_angle(kit.pi * 2 * cycles * t)
        assert abs(kit.cos(phase) + 1) < 1e-25 and abs(turns - halves / 2) <= 0.5

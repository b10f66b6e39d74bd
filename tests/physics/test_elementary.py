"""Elementary functions: right to rounding, and the same bits in scalars and in arrays."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.engine import _engine
from vibsim.physics import elementary
from vibsim.physics.elementary import EIGHT, TWELVE, dot, mean, sine_cosine_of_arrays, total
from vibsim.physics.numbers import Doubles
from vibsim.physics.precision import number_kit

RANDOM = np.random.default_rng(7)
ULP = 2.0**-52
BOTH_SIGNS = np.concatenate(
    [RANDOM.uniform(-1, 1, 1000), 10 ** RANDOM.uniform(-300, 0, 100), [1e-300, 5e-324]]
)
BORDERS = [
    float(np.nextafter(sign * border, towards))
    for border in (0.25, 0.5, 0.7071067811865476, 0.75, 1.0, 1.5, 4.0)
    for sign in (1, -1)
    for towards in (-9, sign * border, 9)
]
NEAR_1 = 1 - 10 ** RANDOM.uniform(-16, -1, 200)
ANGLES = [x for x in [*BOTH_SIGNS, *NEAR_1, *-NEAR_1, *BORDERS] if abs(x) <= 1]
# name: (arguments, error allowed in units of 2^-52 of the value)
RELATIVE = {
    "exp": ([*RANDOM.uniform(-700, 700, 500), *RANDOM.uniform(-1, 1, 500)], 1.0),
    "expm1": ([*RANDOM.uniform(-50, 50, 500), *RANDOM.uniform(-1, 1, 500), 1e-300], 2.0),
    "sinh": ([*RANDOM.uniform(-20, 20, 500), *RANDOM.uniform(-1, 1, 500), 1e-300], 3.0),
    "cosh": ([*RANDOM.uniform(-20, 20, 500), *RANDOM.uniform(-1, 1, 500)], 2.0),
    "log": ([*10 ** RANDOM.uniform(-300, 300, 500), *RANDOM.uniform(0.5, 2, 500), 5e-324], 1.0),
    "log10": ([*10 ** RANDOM.uniform(-300, 300, 500), 2.0], 2.0),
    "log2": ([*10 ** RANDOM.uniform(-300, 300, 500), 3.0], 2.0),
    "tanh": ([*RANDOM.uniform(-25, 25, 500), *BOTH_SIGNS, 700.0, -700.0], 2.0),
    "asin": (ANGLES, 1.5),
    "acos": (ANGLES, 1.5),
    "atan": ([*RANDOM.uniform(-6, 6, 1500), *10 ** RANDOM.uniform(0, 308, 200), *BOTH_SIGNS, *BORDERS], 1.5),
}
# name: (a, p), drawn, and the error allowed in units of 2^-52 of the power
HALVES = (0.5, -0.5, 1.5, -1.5, 2.5, -2.5)
POWERS = {
    "of a wide range": (lambda: (10 ** RANDOM.uniform(-300, 300), RANDOM.uniform(-1, 1)), 1.0),
    "close to the ends of the range": (lambda: end_of_range(10 ** RANDOM.uniform(-307, 308)), 1.0),
    "high ones of numbers close to 1": (lambda: end_of_range(1 + 10 ** RANDOM.uniform(-15, 0)), 1.0),
    "high ones of numbers below 1": (lambda: end_of_range(1 - 10 ** RANDOM.uniform(-15, -0.1)), 1.0),
    "of tiny numbers": (lambda: (5e-324 * RANDOM.integers(1, 99), RANDOM.uniform(-0.9, 0.9)), 1.0),
    "roots": (lambda: (10 ** RANDOM.uniform(-300, 300), 1 / RANDOM.integers(3, 99)), 1.0),
    "whole ones": (lambda: (10 ** RANDOM.uniform(-30, 30), RANDOM.integers(-10, 10)), 1.0),
    "half-integers": (lambda: (10 ** RANDOM.uniform(-120, 120), RANDOM.choice(HALVES)), 2.0),
    "higher half-integers": (lambda: (10 ** RANDOM.uniform(-60, 60), RANDOM.integers(-5, 5) + 0.5), 2.0),
}
FEW_DIGITS = (30, 60)


def end_of_range(a):
    """a and an exponent: the power is anywhere between the least and the greatest of the normal numbers."""
    return a, RANDOM.uniform(-708, 709) / math.log(a)


@pytest.mark.parametrize("name", RELATIVE)
def test_they_are_right_to_rounding(name):
    arguments, allowed = RELATIVE[name]
    exact = {"log2": lambda x: mpmath.log(x, 2)}.get(name) or getattr(mpmath, name)
    of = getattr(elementary if name in ("log2", "log10") else _engine, name)
    with mpmath.workdps(50):
        for x in map(float, arguments):
            truth = exact(mpmath.mpf(x))
            assert abs(of(x) - truth) <= allowed * ULP * abs(truth), x


def test_sines_are_right_to_rounding_and_small_ones_relatively():
    with mpmath.workdps(40):
        for x in map(float, [*RANDOM.uniform(-4, 4, 500), *RANDOM.uniform(-1e6, 1e6, 500)]):
            sine, cosine = elementary.sine_cosine(x)
            assert abs(sine - mpmath.sin(x)) < ULP
            assert abs(cosine - mpmath.cos(x)) < ULP
        for x in (1e-300, 1e-8, 1e-3, 0.7):
            assert abs(elementary.sin(x) / mpmath.sin(x) - 1) < 1.1 * ULP


def test_at_the_ends_of_their_ranges():
    inf = math.inf
    assert [elementary.exp(x) for x in (0.0, -0.0, -inf, -1e4, 1e4, inf)] == [1.0, 1.0, 0.0, 0.0, inf, inf]
    assert elementary.exp(-740.0) == pytest.approx(math.exp(-740.0), abs=5e-324)
    assert elementary.exp(709.7) == pytest.approx(math.exp(709.7), rel=2 * ULP)
    assert [_engine.expm1(x) for x in (0.0, -inf, -1e4, 1e4)] == [0.0, -1.0, -1.0, inf]
    assert [elementary.log(x) for x in (1.0, 0.0, inf)] == [0.0, -inf, inf]
    assert [elementary.log2(2.0**k) for k in (-1074, -53, 0, 10)] == [-1074, -53, 0, 10]
    assert elementary.sine_cosine(0.0) == (0.0, 1.0)
    assert all(-1 <= value <= 1 for x in (1e7, -1e300) for value in elementary.sine_cosine(x))
    functions = (elementary.sin, elementary.cos, elementary.exp, _engine.expm1, elementary.log)
    assert all(math.isnan(function(math.nan)) for function in functions)
    assert all(map(math.isnan, (elementary.sin(inf), elementary.log(-1.0))))


@pytest.mark.parametrize("name", POWERS)
def test_powers_are_right_to_rounding(name):
    draw, allowed = POWERS[name]
    with mpmath.workdps(50):
        for a, p in (map(float, draw()) for _ in range(500)):
            truth = mpmath.power(mpmath.mpf(a), mpmath.mpf(p))
            assert abs(elementary.power(a, p) - truth) <= allowed * ULP * abs(truth), (a, p)


def test_powers_at_the_ends_of_their_range():
    inf, nan, power = math.inf, math.nan, elementary.power
    for p in (0.5, 1.5, 2.5, 0.3, 7.5, 1e300):
        assert [power(0.0, p), power(-0.0, p), power(1.0, p), power(inf, p)] == [0.0, 0.0, 1.0, inf]
        assert [power(0.0, -p), power(-0.0, -p), power(1.0, -p), power(inf, -p)] == [inf, inf, 1.0, 0.0]
        assert all(math.isnan(power(a, q)) for a in (-1.0, -inf, nan) for q in (p, -p))
    assert [power(a, 0.0) for a in (0.0, 3.0, inf)] == [1.0, 1.0, 1.0]
    assert all(math.isnan(power(a, nan)) for a in (0.0, 1.0, 3.0, inf))
    too_large = [(1e200, 1.6), (2.0, 1e300), (1e-206, -1.5), (1e300, 1.5)]
    too_small = [(1e200, -1.7), (2.0, -1e300), (1e-220, 1.5), (1e-200, 2.5)]
    assert [power(*pair) for pair in too_large + too_small] == [inf] * 4 + [0.0] * 4
    with mpmath.workdps(50):
        for a, p in [(1e-200, 1.5), (4e-206, -1.5), (3e205, -1.5), (1e-123, -2.5)]:
            truth = float(mpmath.mpf(a) ** mpmath.mpf(p))
            assert power(a, p) == pytest.approx(truth, rel=2 * ULP, abs=0)
        for a, p in [(1e-210, 1.5), (1e-213, 1.5), (1e-210, 1.499), (1e-213, 1.51), (1e212, -1.51)]:
            truth = float(mpmath.mpf(a) ** mpmath.mpf(p))  # below normal numbers, 5e-324 apart
            assert 0 < truth < 2.3e-308 and abs(power(a, p) - truth) <= 5e-324


def test_tangents_and_angles_at_the_ends_of_their_ranges():
    inf, nan = math.inf, math.nan
    assert [_engine.tanh(x) for x in (0.0, 20.0, 1e300, inf)] == [0.0, 1.0, 1.0, 1.0]
    assert [_engine.tanh(x) for x in (-20.0, -1e300, -inf)] == [-1.0, -1.0, -1.0]
    assert _engine.tanh(18.0) == 1 - 2.0**-51  # 2 exp(-36) = 4.6e-16
    quarter = math.pi / 2
    assert [elementary.asin(x) for x in (0.0, 1.0, -1.0)] == [0.0, quarter, -quarter]
    assert [_engine.acos(x) for x in (1.0, 0.0, -1.0)] == [0.0, quarter, math.pi]
    assert [_engine.atan(x) for x in (0.0, 1e300, inf, -inf)] == [0.0, quarter, quarter, -quarter]
    beyond = (math.nextafter(1.0, 2.0), -1.5, inf, -inf, nan)
    assert all(math.isnan(of(x)) for of in (elementary.asin, _engine.acos) for x in beyond)
    assert math.isnan(_engine.tanh(nan)) and math.isnan(_engine.atan(nan))
    for name in ("tanh", "asin", "atan"):
        of = elementary.function(name)
        assert all(of(-x) == -of(x) for x in map(float, RANDOM.uniform(0, 1, 100)))


def kits():
    """Kits of many digits."""
    return [number_kit(digits) for digits in FEW_DIGITS]


def as_mpf(kit, x):
    """A number of a kit for mpmath."""
    kit.activate()
    mantissa, exponent = kit.parts(x)
    return mpmath.ldexp(mpmath.mpf(mantissa), exponent)


def test_kits_of_many_digits_have_the_same_functions():
    for kit in kits():
        kit.activate()
        x, third = kit.number(Fraction(3, 7)), kit.number(Fraction(-1, 3))
        with mpmath.workdps(100):
            exact = mpmath.mpf(3) / 7
            for name in ("tanh", "asin", "acos", "atan"):
                truth = getattr(mpmath, name)(exact)
                assert abs(as_mpf(kit, kit.function(name)(x)) / truth - 1) < mpmath.mpf(10) ** -kit.digits
            truth = mpmath.cbrt(1 / exact)
            assert abs(as_mpf(kit, kit.power(x, third)) / truth - 1) < mpmath.mpf(10) ** -kit.digits


def test_kits_agree_about_special_values():
    for kit in [*kits(), Doubles]:
        if kit is not Doubles:
            kit.activate()
        number, inf = kit.number, kit.inf
        half, minus = number(1.5), number(-1.5)
        zero, one, nan = number(0), number(1), number(math.nan)
        assert [kit.power(zero, half), kit.power(zero, minus)] == [0, inf]
        assert [kit.power(inf, half), kit.power(inf, minus)] == [inf, 0]
        assert [kit.power(zero, zero), kit.power(one, half), kit.power(number(4), minus)] == [1, 1, 0.125]
        undefined = [kit.power(base, p) for base in (number(-2), nan) for p in (half, minus)]
        undefined += [of(number(x)) for of in map(kit.function, ("asin", "acos")) for x in (1.5, -1.5)]
        assert not any(math.isfinite(float(x)) for x in undefined)
        assert float(kit.function("tanh")(inf)) == 1.0 and float(kit.function("tanh")(number(-1e9))) == -1.0
        assert (
            float(kit.function("asin")(-one)) == -math.pi / 2 and float(kit.function("acos")(-one)) == math.pi
        )
        assert float(kit.function("atan")(inf)) == math.pi / 2


def test_arrays_have_the_bits_of_scalars():
    angles = np.concatenate([RANDOM.uniform(-10, 10, 2000), RANDOM.uniform(-3e6, 3e6, 500), [0.0, 1e300]])
    one_by_one = np.array([elementary.sine_cosine(float(x)) for x in angles]).T
    assert np.array_equal(np.array(sine_cosine_of_arrays(angles)), one_by_one)


# Sine and cosine by additions and products.


EPS = 2.0**-52


@given(st.floats(-1.5e6, 1.5e6))
def test_they_are_right_to_an_ulp_of_one(angle):
    """The mathematics library is right to half an ulp, below 2^-53; both together stay below 1.5 eps."""
    sine, cosine = sine_cosine_of_arrays(np.array([angle]))
    assert abs(float(sine[0]) - math.sin(angle)) <= 1.5 * EPS
    assert abs(float(cosine[0]) - math.cos(angle)) <= 1.5 * EPS


def test_quarter_turns_and_the_borders_between_them():
    quarters = np.arange(-9, 10)
    angles = np.concatenate([quarters * (math.pi / 4), np.nextafter(quarters * (math.pi / 4), 10)])
    sine, cosine = sine_cosine_of_arrays(angles)
    np.testing.assert_allclose(sine, list(map(math.sin, angles)), rtol=0, atol=1.5 * EPS)
    np.testing.assert_allclose(cosine, list(map(math.cos, angles)), rtol=0, atol=1.5 * EPS)


def test_small_angles_keep_their_relative_accuracy():
    angles = np.array([1e-300, 1e-17, 1e-8, 1e-3])
    np.testing.assert_allclose(sine_cosine_of_arrays(angles)[0], list(map(math.sin, angles)), rtol=2 * EPS)
    assert sine_cosine_of_arrays(np.zeros((2, 3)))[1].tolist() == [[1.0] * 3] * 2


@pytest.mark.parametrize("shape", [(), (0,), (3, 1, 2)])
def test_the_shape_is_kept(shape):
    assert [part.shape for part in sine_cosine_of_arrays(np.ones(shape))] == [shape, shape]


# Sums in an order of our own.


NUMBERS = st.lists(st.floats(-1e6, 1e6), max_size=300)


@given(NUMBERS)
def test_a_sum_is_that_of_exact_arithmetic_within_its_rounding(values):
    error = abs(float(total(np.array(values))) - math.fsum(values))
    levels = max(len(values) - 1, 0).bit_length()  # additions that each value goes through
    assert error <= levels * 2.0**-53 * 1.01 * math.fsum(map(abs, values))


def test_the_order_is_to_fold_the_second_half_onto_the_first():
    big = 2.0**60
    assert total(np.array([big, 1.0, -big, 1.0])) == 2.0  # (big - big) + (1 + 1)
    assert total(np.array([big, -big, 1.0, 1.0])) == 0.0  # (big + 1) + (-big + 1)
    assert total(np.array([1.0, 2.0, big, -big, 4.0])) == (1.0 - big + big) + (2.0 + 4.0)


@pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 64, 1001])
def test_rows_are_summed_like_single_ones_whatever_their_layout(count):
    rows = np.random.default_rng(count).standard_normal((5, count))
    expected = [float(total(row)) for row in rows]
    assert total(rows).tolist() == expected
    assert total(np.asfortranarray(rows)).tolist() == expected
    assert total(np.stack([rows, rows], axis=-1).T[0].T).tolist() == expected
    np.testing.assert_array_equal(rows, np.random.default_rng(count).standard_normal((5, count)))


def test_means_and_products():
    assert mean(np.array([1, 2, 6])) == 3.0
    assert dot(np.array([1.0, 2.0]), np.array([3.0, 4.0])) == 11.0
    np.testing.assert_array_equal(dot(np.eye(3), np.arange(3.0)), [0.0, 1.0, 2.0])


# Quadrature against the integrals of powers, and what its last place may be off by.


@pytest.mark.parametrize("rule", [EIGHT, TWELVE], ids=["eight", "twelve"])
def test_polynomials_are_integrated_exactly_up_to_twice_the_nodes(rule):
    count = len(rule.nodes)

    def miss(power):
        terms = [weight * node**power for node, weight in zip(*rule, strict=True)]
        return 1 / (power + 1) - math.fsum(terms)

    assert all(abs(miss(power)) < 2e-16 for power in range(2 * count))
    # the first that is missed, by (n!)^4 / ((2 n + 1) ((2 n)!)^2) of it
    first = math.factorial(count) ** 4 / ((2 * count + 1) * math.factorial(2 * count) ** 2)
    assert miss(2 * count) == pytest.approx(first, abs=2e-16)
    assert first > 3e-16 or count == 12


def test_eight_nodes_take_the_power_of_a_step_to_rounding():
    """(1 - cos 2 w t) / 2 over a step of 1.32 rad, the longest of order 20 at full tolerance."""
    angle = 1.32
    assert angle**20 / math.factorial(20) == pytest.approx(2.0**-53, rel=0.1)
    for phase in (0.0, 0.4, 1.1, 2.5):
        exact = angle / 2 - (math.sin(2 * (angle + phase)) - math.sin(2 * phase)) / 4
        powers = (math.sin(node * angle + phase) ** 2 for node in EIGHT.nodes)
        found = angle * math.fsum(w * power for w, power in zip(EIGHT.weights, powers, strict=True))
        assert found == pytest.approx(exact, abs=3e-16)

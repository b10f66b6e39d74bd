"""Elementary functions: right to rounding, and the same bits in scalars, in arrays and in C."""

import math

import mpmath
import numpy as np
import pytest

from vibsim.physics import elementary
from vibsim.physics.elementary import sine_cosine_of_arrays

RANDOM = np.random.default_rng(7)
ULP = 2.0**-52
# name: (arguments, error allowed in units of 2^-52 of the value)
RELATIVE = {
    "exp": ([*RANDOM.uniform(-700, 700, 500), *RANDOM.uniform(-1, 1, 500)], 1.0),
    "expm1": ([*RANDOM.uniform(-50, 50, 500), *RANDOM.uniform(-1, 1, 500), 1e-300], 2.0),
    "sinh": ([*RANDOM.uniform(-20, 20, 500), *RANDOM.uniform(-1, 1, 500), 1e-300], 3.0),
    "cosh": ([*RANDOM.uniform(-20, 20, 500), *RANDOM.uniform(-1, 1, 500)], 2.0),
    "log": ([*10 ** RANDOM.uniform(-300, 300, 500), *RANDOM.uniform(0.5, 2, 500), 5e-324], 1.0),
    "log10": ([*10 ** RANDOM.uniform(-300, 300, 500), 2.0], 2.0),
    "log2": ([*10 ** RANDOM.uniform(-300, 300, 500), 3.0], 2.0),
}


@pytest.mark.parametrize("name", RELATIVE)
def test_they_are_right_to_rounding(name):
    arguments, allowed = RELATIVE[name]
    exact = {"log2": lambda x: mpmath.log(x, 2)}.get(name) or getattr(mpmath, name)
    with mpmath.workdps(40):
        for x in map(float, arguments):
            truth = exact(mpmath.mpf(x))
            assert abs(getattr(elementary, name)(x) - truth) <= allowed * ULP * abs(truth), x


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
    assert [elementary.expm1(x) for x in (0.0, -inf, -1e4, 1e4)] == [0.0, -1.0, -1.0, inf]
    assert [elementary.log(x) for x in (1.0, 0.0, inf)] == [0.0, -inf, inf]
    assert [elementary.log2(2.0**k) for k in (-1074, -53, 0, 10)] == [-1074, -53, 0, 10]
    assert elementary.sine_cosine(0.0) == (0.0, 1.0)
    assert all(-1 <= value <= 1 for x in (1e7, -1e300) for value in elementary.sine_cosine(x))
    functions = (elementary.sin, elementary.cos, elementary.exp, elementary.expm1, elementary.log)
    assert all(math.isnan(function(math.nan)) for function in functions)
    assert all(map(math.isnan, (elementary.sin(inf), elementary.log(-1.0))))


def test_arrays_have_the_bits_of_scalars():
    angles = np.concatenate([RANDOM.uniform(-10, 10, 2000), RANDOM.uniform(-3e6, 3e6, 500), [0.0, 1e300]])
    one_by_one = np.array([elementary.sine_cosine(float(x)) for x in angles]).T
    assert np.array_equal(np.array(sine_cosine_of_arrays(angles)), one_by_one)

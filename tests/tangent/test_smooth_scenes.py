"""Exponents of linear scenes without events: known exactly."""

import math

import numpy as np
import pytest

from tests.scenes import fixed_block, harmonic, motor, scene
from tests.tangent.bundles import exponents

m1, m2, k1 = 0.297, 2.94, 200.0
MOBILITY = 1 / m1 + 1 / m2
METHODS = ("closed_form", "taylor")
ROUNDING = 1e-12  # of some 100 pieces over some 10 s


def turns(a, b, count):
    """Time of `count` turns of y'' + 2 a y' + b y = 0 [s]: over it all (y, y') shrink by exp(-a t)."""
    return count * 2 * math.pi / math.sqrt(b - a * a)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "source", [None, harmonic(3.5, 0.07), harmonic(math.sqrt(k1 / m1) / 2 / math.pi, 0.1, 0.2)]
)
@pytest.mark.parametrize("c", [0.001, 0.5, 10.0])
def test_a_damped_oscillator(method, source, c):
    a = c / (2 * m1)
    t_end = turns(a, k1 / m1, 30)
    found = exponents(fixed_block(source, c=c, G=None, x1=0.01, t_end=t_end, method=method))
    np.testing.assert_allclose(found.exponents, -a, rtol=0, atol=ROUNDING * (1 + a))
    assert found.span == (0.0, t_end)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("c", [20.0, 100.0])
def test_an_overdamped_oscillator(method, c):
    a = c / (2 * m1)
    kappa = math.sqrt(a * a - k1 / m1)
    at_rest = fixed_block(None, c=c, G=None, t_end=8.0, method=method)
    found = exponents(at_rest, begin=4.0)  # exp(-2 kappa 4) = 1e-57 at most: the directions have settled
    slow = -(k1 / m1) / (a + kappa)
    np.testing.assert_allclose(found.exponents, [slow, -(a + kappa)], rtol=1e-12)


@pytest.mark.parametrize("c", [0.02, 2.0])
def test_two_blocks_without_friction(c):
    """(y, u) shrinks by exp(-a t) with a = c (1/m1 + 1/m2) / 2; the common velocity stays."""
    a, b = c * MOBILITY / 2, k1 * MOBILITY
    settled = 40.0 / a
    t_end = settled + turns(a, b, 50)
    two = scene(harmonic(3.5, 0.07), c=c, N=None, k2=None, G=None, t_end=t_end)
    found = exponents(two, begin=settled)
    np.testing.assert_allclose(found.exponents, [0.0, -a, -a], rtol=0, atol=ROUNDING * (1 + a))


@pytest.mark.parametrize("method", METHODS)
def test_blocks_without_damping(method):
    """Nothing grows or shrinks but by turning in an ellipse: the exponents vanish like 1 / t."""
    free = scene(c=0.0, N=None, k2=None, G=None, x1=0.01, t_end=turns(0.0, k1 * MOBILITY, 40), method=method)
    np.testing.assert_allclose(exponents(free).exponents, 0.0, atol=1e-12)


def test_the_motor_alone():
    """V9: 0 for the angle, -M0 / (Omega0 (J + m3 e^2)) for the speed; the heavy block swings undamped."""
    rate = 0.005 / (2 * math.pi * 5.5 * (0.001 + 0.03 * 0.11**2))
    heavy = fixed_block(motor(5.5), m1=1e30, k1=1e31, c=0.0, G=None, t_end=600.0)
    found = exponents(heavy, begin=400.0)  # exp(-rate 400) = 6e-19
    # the swing shakes the rotor: m3 e times its acceleration over J + m3 e^2 tilts the directions to and fro
    np.testing.assert_allclose(found.exponents[3], -rate, rtol=1e-5)
    np.testing.assert_allclose(found.exponents[:3], 0.0, atol=1e-5)
    assert sum(found.exponents) == pytest.approx(-rate, rel=1e-12)


def test_all_exponents_add_up_to_the_mean_contraction():
    """Sum = -c (1/m1 + 1/m2), with or without the friction that never turns round here."""
    sliding = scene(harmonic(3.5, 0.07), v1=5.0, v2=5.0, c=0.3, k2=None, G=None, t_end=30.0)
    found = exponents(sliding, begin=5.0)
    assert sum(found.exponents) == pytest.approx(-0.3 * MOBILITY, rel=1e-12)
    assert found.rank_losses == 0

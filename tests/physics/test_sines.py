"""Sine and cosine by additions and products."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.physics.elementary import sine_cosine_of_arrays

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

"""Sums in an order of our own."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.physics.elementary import dot, mean, total

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

"""Measures of basins on planes whose boundaries are known."""

import numpy as np
import pytest

from vibsim.sweeps.basin_measures import basin_entropy, uncertain_share, uncertainty_exponent


def test_a_straight_boundary_has_an_exponent_of_one():
    """n starts on either side of a straight line are uncertain at n steps."""
    labels = np.zeros((256, 256), dtype=int)
    labels[:, 100:] = 1
    for steps in (1, 2, 4, 8):
        assert uncertain_share(labels, steps) == (256 * 2 * steps, 256 * 256)
    slope = uncertainty_exponent(labels)
    assert slope.value == pytest.approx(1, abs=1e-12) and slope.error < 1e-12


def test_a_cantor_set_of_strips_has_its_dimension():
    """Middle thirds: the boundary along one axis has the dimension ln 2 / ln 3, alpha = 1 - that = 0.369."""
    line = np.zeros(3**6, dtype=int)

    def fill(first, length, label):
        if length >= 3:
            third = length // 3
            line[first + third : first + 2 * third] = label
            fill(first, third, 3 - label)
            fill(first + 2 * third, third, 3 - label)

    fill(0, len(line), 1)
    labels = np.broadcast_to(line, (3**6, 3**6))
    alpha = uncertainty_exponent(labels).value
    assert alpha == pytest.approx(1 - np.log(2) / np.log(3), abs=0.1)


def test_undecided_starts_make_no_boundary():
    labels = np.zeros((64, 64), dtype=int)
    labels[30] = -1
    assert uncertain_share(labels, 1) == (0, 63 * 64)
    assert np.isnan(uncertainty_exponent(labels).value)


def test_entropy_of_boxes_by_hand():
    """Of 25 boxes five are crossed, 2 of 5 columns in each: p = 0.4 and 0.6."""
    labels = np.zeros((25, 25), dtype=int)
    labels[:, 12:] = 1
    of_one = -(0.4 * np.log(0.4) + 0.6 * np.log(0.6))
    entropy, boundary, boxes, crossed = basin_entropy(labels)
    assert (boxes, crossed) == (25, 5)
    assert entropy == pytest.approx(5 * of_one / 25, rel=1e-14)
    assert boundary == pytest.approx(of_one, rel=1e-14)


def test_entropy_of_noise_is_that_of_its_labels():
    """Four labels at random: ln 4, less what 25 draws of them lack, (4 - 1) / (2 25) to first order."""
    labels = np.random.default_rng(1).integers(0, 4, (200, 200))
    entropy, boundary, _, _ = basin_entropy(labels)
    assert entropy == boundary == pytest.approx(np.log(4) - 3 / 50, abs=5e-3)
    assert boundary > np.log(2)


def test_a_small_plane_has_no_entropy():
    assert np.isnan(basin_entropy(np.zeros((10, 10), dtype=int))[0])

"""The rest distance needed: maxima between samples count, whatever the blocks."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.results.made import short_case, short_run
from vibsim.results.columns import LARGEST_STEP, Distances, largest_of_cubics

SCENE = short_case().two_blocks()


class Rest(Distances):
    """The rest distance of a case."""

    def __init__(self, case=None):
        case = case or short_case()
        super().__init__(case, case.scene())

    @property
    def needed(self):
        return self.attrs["rest_distance_needed"]


def rows(clock, t, y, v):
    """Rows in which x1 - x2 = y."""
    return {clock: t, "x1": y + 1.0, "v1": v - 2.0, "x2": np.ones_like(t), "v2": np.full_like(t, -2.0)}


def sine(t, w=7.0):
    return np.sin(w * t), w * np.cos(w * t)


NO_EVENTS = rows("t", np.empty(0), np.empty(0), np.empty(0))


def test_a_maximum_between_samples_is_found():
    t = np.arange(0, 2, 0.05)
    y, v = sine(t)
    assert y.max() < 0.9999
    rest = Rest()
    rest.update(rows("time", t, y, v), NO_EVENTS)
    bound = (7.0 * 0.05) ** 4 / 384  # Hermite remainder for |y''''| <= w^4
    assert 1 - bound <= rest.needed <= 1 + bound
    assert rest.needed > y.max()


def test_a_maximum_across_two_blocks_is_found():
    t = np.array([0.1, 0.35])  # the top of the first arch, pi / 14, lies between
    y, v = sine(t)
    rest = Rest()
    for i in range(2):
        rest.update(rows("time", t[i : i + 1], y[i : i + 1], v[i : i + 1]), NO_EVENTS)
    assert rest.needed == pytest.approx(1, abs=(7.0 * 0.25) ** 4 / 384)
    assert rest.needed > y.max() + 0.1


def test_events_are_rows_too():
    rest = Rest()
    samples = rows("time", np.array([0.0, 1.0]), np.zeros(2), np.zeros(2))
    rest.update(samples, rows("t", np.array([0.4]), np.array([0.3]), np.zeros(1)))
    assert rest.needed == pytest.approx(0.3)


def test_events_out_of_order_with_samples_are_merged():
    t = np.linspace(0, 1, 41)
    y, v = sine(t)
    rest, pieces = Rest(), np.arange(41) % 3 == 0
    rest.update(rows("time", t[pieces], y[pieces], v[pieces]), rows("t", t[~pieces], y[~pieces], v[~pieces]))
    assert rest.needed == largest_of_cubics(t, y + 1.0 - 1.0, v)


def test_a_fixed_block_2_leaves_x1_alone():
    rest = Rest(short_case(blocks__m2="fixed", friction="none"))
    nothing = {name: np.empty(0) for name in ("t", "x1", "v1")}
    rest.update({"time": np.array([0.0]), "x1": np.array([0.25]), "v1": np.zeros(1)}, nothing)
    assert rest.needed == 0.25


@given(st.tuples(*[st.floats(-3, 3) for _ in range(4)]))
def test_no_point_of_the_cubic_is_above_and_one_attains_it(numbers):
    y0, y1, d0, d1 = numbers
    found = largest_of_cubics(np.array([0.0, 1.0]), np.array([y0, y1]), np.array([d0, d1]))
    s = np.linspace(0, 1, 2001)
    curve = (1 + 2 * s) * (1 - s) ** 2 * y0 + s**2 * (3 - 2 * s) * y1
    curve += s * (1 - s) ** 2 * d0 + s**2 * (s - 1) * d1
    # between grid points h apart it rises by at most h^2/8 max|y''|, and |y''| <= 6|y1 - y0| + 6 max|d|
    assert curve.max() - 1e-12 <= found <= curve.max() + 60 / 8 * (1 / 2000) ** 2 + 1e-12


def test_too_coarse_an_output_says_nothing():
    fastest = math.sqrt(SCENE.k1 * (1 / SCENE.m1 + 1 / SCENE.m2))
    near, far = (short_run(run__every=f"{f * LARGEST_STEP / fastest:.6f} s") for f in (0.99, 1.01))
    assert "rest_distance_needed" in near.attrs
    assert "rest_distance_needed" not in far.attrs


def test_the_output_interval_hardly_matters():
    fine = short_run(run__every="0.5 ms").attrs["rest_distance_needed"]
    for every in ("5 ms", "20 ms"):
        # amplitudes below 10 x the maximum
        bound = 10 * fine * (28 * float(every.split()[0]) / 1000) ** 4 / 384
        assert short_run(run__every=every).attrs["rest_distance_needed"] == pytest.approx(fine, abs=bound)

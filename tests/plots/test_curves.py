"""Curves of many and of few samples: no extreme is lost, nothing is invented between them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.plots.artists import lines, points
from vibsim.cases import load_case
from vibsim.plots import samples
from vibsim.plots.poincare_sections import _turns, states_at, turn_times
from vibsim.plots.samples import Envelope
from vibsim.plots.subject import Subject, View
from vibsim.plots.time_histories import displacement_picture
from vibsim.plots.traces import hermite, one_per_pixel, root_time, samples_are_sparse
from vibsim.results import simulate

COLUMNS = 37


def enveloped(t, values, blocks=1, columns=COLUMNS):
    envelope = Envelope(t[0], t[-1], columns)
    for part in np.array_split(np.arange(len(t)), blocks):
        envelope.add(t[part], values[part])
    return envelope.points()


def column_of(t, start, stop, columns=COLUMNS):
    return np.minimum((t - start) / (stop - start) * columns, columns - 1).astype(int)


@given(st.integers(0, 2**32 - 1), st.integers(2, 3000), st.integers(1, 7))
def test_every_column_keeps_its_extremes_and_ends(seed, count, blocks):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.1, 1.0, count))
    values = rng.normal(size=count)
    kept_t, kept = enveloped(t, values, min(blocks, count))
    all_columns, kept_columns = column_of(t, t[0], t[-1]), column_of(kept_t, t[0], t[-1])
    assert set(all_columns) == set(kept_columns)
    for column in set(all_columns):
        whole, part = values[all_columns == column], kept[kept_columns == column]
        assert (part.min(), part.max(), part[0], part[-1]) == (whole.min(), whole.max(), whole[0], whole[-1])


def test_kept_points_are_samples_in_order():
    t = np.linspace(0, 1, 5000)
    values = np.sin(900 * t)
    kept_t, kept = enveloped(t, values)
    assert len(kept_t) <= 4 * COLUMNS
    assert np.all(np.diff(kept_t) > 0)
    np.testing.assert_array_equal(kept, values[np.searchsorted(t, kept_t)])


@pytest.mark.parametrize("row", [0, 777, 4999])
def test_a_single_spike_survives(row):
    t, values = np.arange(5000.0), np.zeros(5000)
    values[row] = -3.0
    kept_t, kept = enveloped(t, values, blocks=3)
    assert kept.min() == -3.0
    assert kept_t[kept.argmin()] == row


def test_blocks_do_not_matter():
    t = np.linspace(0, 1, 4321)
    values = np.cumsum(np.random.default_rng(1).normal(size=t.size))
    for once, often in zip(enveloped(t, values), enveloped(t, values, blocks=11), strict=True):
        np.testing.assert_array_equal(once, often)


# One sample per pixel: nothing invented, nothing farther than a pixel from what is kept.


PIXELS = (60, 40)


def test_samples_are_kept_and_none_is_far():
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=5000), rng.uniform(size=5000)
    kept_x, kept_y = one_per_pixel(
        lambda: zip(np.array_split(x, 7), np.array_split(y, 7), strict=True), PIXELS
    )
    assert len(kept_x) < len(x)
    assert set(zip(kept_x, kept_y, strict=True)) <= set(zip(x, y, strict=True))
    dx = np.abs(x[:, None] - kept_x) / np.ptp(x) * PIXELS[0]
    dy = np.abs(y[:, None] - kept_y) / np.ptp(y) * PIXELS[1]
    assert np.maximum(dx, dy).min(axis=1).max() <= 1 + 1e-12


def test_pixels_are_not_kept_twice():
    x = np.array([0.0, 1.0, 0.0, 1.0])
    kept_x, _ = one_per_pixel(lambda: [(x, x), (x, x)], PIXELS)
    assert sorted(kept_x) == [0.0, 1.0]


def test_a_point_at_rest_is_one_point():
    x = np.full(100, 2.0)
    assert one_per_pixel(lambda: [(x, x)], PIXELS)[0].tolist() == [2.0]


def cubic(t):
    return 2 * t**3 - t**2 + 4 * t - 1, 6 * t**2 - 2 * t + 4


def test_cubics_are_reproduced():
    t = np.array([0.0, 0.3, 1.0, 2.5])
    f, slope = cubic(t)
    at = np.array([0.1, 0.3, 0.9, 2.4])
    value, derivative = hermite(t, f, slope, np.array([0, 1, 1, 2]), at)
    np.testing.assert_allclose(value, cubic(at)[0], rtol=1e-13)
    np.testing.assert_allclose(derivative, cubic(at)[1], rtol=1e-12)


def test_root_of_a_cubic():
    f, slope = cubic(np.array([0.0, 2.0]))
    target = cubic(np.array([0.7]))[0]
    ends = [np.array([value]) for value in (0.0, 2.0, f[0], f[1], slope[0], slope[1])]
    np.testing.assert_allclose(root_time(*ends, target), [0.7], rtol=1e-12)


def test_root_stays_inside_where_the_slope_vanishes():
    zero = np.array([0.0])
    root = root_time(zero, zero + 1, zero, zero + 1, zero, zero, zero)
    assert 0 <= root[0] <= 1


# Runs with few samples are not drawn as if there were nothing between them.


@pytest.fixture(scope="module")
def sparse():
    """A run with one sample per second, of a source with 6.5 periods per second."""
    case = load_case("I-C", {"run.t_end": "20 s", "run.every": "1 s"})
    return Subject("sparse", "sparse", "trajectory", case, simulate(case))


def test_which_samples_are_sparse(sparse):
    assert samples_are_sparse(sparse.scene)
    assert not samples_are_sparse(load_case("I-C").scene())


def test_vibrations_between_samples_are_drawn_and_the_interval_is_stated(sparse):
    figure = displacement_picture([sparse], View(width="column"))
    t, x1 = points(lines(figure, "x1")[0])
    assert len(t) > 16 * 6.5 * 20
    assert np.ptp(x1) > 1.5 * 1000 * np.ptp(sparse.result["x1"])
    assert "samples every 1 s" in figure.axes[0].get_title(loc="right")


def test_an_interrupted_run_says_so(sparse):
    sparse.result.attrs["complete"] = 0
    assert "incomplete run" in displacement_picture([sparse], View(width="column")).axes[0].get_title(
        loc="right"
    )


# Stroboscopic instants and states.


def test_harmonic_turns_are_multiples_of_the_period(subject):
    times = turn_times(subject("ideal").result, (1.0, 3.0))
    np.testing.assert_allclose(times, np.arange(7, 20) / 6.5, rtol=1e-15)


def test_motor_turns_are_where_phi_passes_multiples_of_2_pi(subject):
    result = subject("motor").result
    times = turn_times(result, (0.0, 20.0))
    turns = result.at(times)["phi"] / (2 * math.pi)
    # cubic Hermite: h^4 / 384 max |phi''''|, h = 5 ms, |phi''''| < 2e5 rad/s^4 in contact: below 1e-6 rad
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-6)
    assert len(times) == math.floor(result["phi"][-1] / (2 * math.pi))


def test_no_turn_is_lost_between_blocks(subject, monkeypatch):
    result = subject("motor").result
    whole = turn_times(result, (0.0, 20.0))
    monkeypatch.setattr(samples, "BLOCK", 300)
    np.testing.assert_array_equal(turn_times(result, (0.0, 20.0)), whole)


def test_several_turns_between_samples():
    t = np.array([0.0, 1.0, 2.0])
    phi, phidot = 2 * math.pi * 3.5 * t - 1, np.full(3, 2 * math.pi * 3.5)
    expected = (2 * math.pi * np.arange(0, 7) + 1) / (2 * math.pi * 3.5)
    np.testing.assert_allclose(_turns(t, phi, phidot), expected, rtol=1e-13)
    np.testing.assert_allclose(_turns(t, -phi, -phidot), expected, rtol=1e-13)


@pytest.mark.parametrize("name", ["ideal", "motor", "fixed"])
def test_many_states_are_interpolated(subject, name):
    one = subject(name)
    names = tuple(column for column in ("x1", "v1", "x2", "v2") if column in one.result)
    times = np.linspace(0.013, 7.9, 500)
    exact, near = (states_at(one.result, names, times, limit) for limit in (500, 10))
    for column in names:
        size = np.ptp(exact[column])
        np.testing.assert_allclose(near[column], exact[column], atol=0.05 * size)
        assert np.median(np.abs(near[column] - exact[column])) < 1e-3 * size


def test_turns_of_nothing(subject):
    result = subject("ideal").result
    assert len(turn_times(result, (1.01, 1.02))) == 0
    assert len(states_at(result, ("x1", "v1"), np.empty(0), 10)["x1"]) == 0

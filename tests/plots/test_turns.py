"""Stroboscopic instants and states."""

import math

import numpy as np
import pytest

from vibsim.plots import samples
from vibsim.plots.poincare_sections import states_at, turn_times


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
    from vibsim.plots.poincare_sections import _turns

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

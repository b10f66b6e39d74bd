"""The largest Lyapunov exponent of a run with its interval, and what it adds to the verdict."""

import numpy as np
import pytest

from tests.results.made import short_run
from vibsim.analysis import analyse, judge_regime, largest_exponent
from vibsim.analysis.regime import exponent_of
from vibsim.command_line.commands.analyse import regime_lines

LINEAR = {"blocks__m2": "fixed", "friction": "none", "stop": "none"}


def test_a_linear_oscillator_has_its_damping():
    """Disturbances fall as exp(-c t / 2 m1), to within the swing of one vibration."""
    found = largest_exponent(short_run("I-B", "100 s", **LINEAR, coupling__c="0.2 N s/m"), (20.0, 100.0))
    assert found.value == pytest.approx(-0.2 / (2 * 0.297), rel=0.01)
    assert found.sign == -1
    undamped = largest_exponent(short_run("I-B", "100 s", **LINEAR, coupling__c="0"))
    assert (undamped.value, undamped.sign) == (pytest.approx(0, abs=0.01), 0)


def test_intervals_hold_as_often_as_they_say():
    """Growth at a mean rate of 0.3 1/s with independent scatter; 1000 trials at 95 %."""
    rng = np.random.default_rng(2)
    times = np.linspace(150, 300, 101)
    held = 0
    for _ in range(1000):
        steps = 0.3 * 1.5 + 0.8 * rng.normal(size=100)
        found = exponent_of(times, np.concatenate([[0.0], np.cumsum(steps)]))
        held += abs(found.value - 0.3) <= found.half_width
    assert 0.93 <= held / 1000 <= 0.99


def test_what_gives_no_exponent():
    times = np.linspace(0, 10, 101)
    assert exponent_of(times[:15], times[:15]) is None
    assert exponent_of(times, np.where(times > 5, -np.inf, times)) is None
    assert exponent_of(times, 0.2 * times).half_width == pytest.approx(0, abs=1e-12)


def test_it_makes_no_chaos_of_what_the_0_1_test_finds_between():
    """Over 6000 s too the 0-1 test says 0.81."""
    run = short_run("I-C-eq211", "300 s")
    assert judge_regime(run).verdict == "undecided"
    assert analyse(run, what=["regime"], exponent=False).regime.exponent is None
    found = analyse(run, what=["regime"]).regime
    assert 0.1 < found.chaos_number < 0.9
    assert found.exponent.sign == 1
    assert found.verdict == "undecided"


def test_what_settles_has_a_negative_one():
    """That of the orbit it goes to: ln |mu| / T, mu of 16 digits (tests/orbits/truths.json)."""
    run = short_run("I-C", "300 s")
    assert largest_exponent(run).sign == -1
    found = analyse(run, what=["regime"]).regime
    assert (found.verdict, found.exponent) == ("periodic", None)
    exact = np.log(abs(0.8486435858373631123 - 0.5215168804985693551j)) * 6.5
    np.testing.assert_allclose(found.exponents, [exact, exact, np.log(0.9303994608203476) * 6.5], rtol=1e-10)


def test_a_periodic_motion_gets_no_estimate():
    run = short_run("I-A", "300 s")
    found = analyse(run).regime
    assert (found.verdict, found.exponent) == ("periodic", None)
    given = judge_regime(run, exponent=largest_exponent(run))
    assert all("largest Lyapunov exponent" not in text for _, text in regime_lines(given))


def test_a_shift_in_time_neither_grows_nor_shrinks_with_a_motor():
    found = largest_exponent(short_run("II-B", "300 s", coupling__c="0.03 N s/m"))
    assert found.sign == 0
    assert abs(found.value) < 0.05

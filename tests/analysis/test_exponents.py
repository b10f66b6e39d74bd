"""Lyapunov exponents of cases: intervals, running estimates, warnings."""

import math
from dataclasses import replace

import numpy as np
import pytest

import vibsim
from tests.results.made import short_run
from vibsim.analysis import analyse, judge_regime, largest_exponent
from vibsim.analysis.regime import exponent_of, judged
from vibsim.command_line.commands.analyse import regime_lines
from vibsim.engine.tangent.lyapunov import LyapunovExponents

RATE, TIMES = 0.7, np.linspace(100.0, 300.0, 101)


def grown(*logarithms, **changes):
    """Exponents whose logarithms of growth at TIMES are given."""
    growth = np.column_stack([TIMES, *logarithms])
    fields = {
        "exponents": growth[-1, 1:] / 200.0,
        "growth": growth,
        "rank_losses": 0,
        "volume_residual": 1e-13,
        "tangencies": 0,
        "closest_tangency": 0.1,
        "closest_tangency_time": 123.0,
        "tangent_pieces": 1000,
        "undefined_time": np.nan,
    }
    return LyapunovExponents(**{**fields, **changes})


def steady(scatter=0.0):
    noise = np.random.default_rng(1).standard_normal(len(TIMES)) * scatter
    return RATE * (TIMES - 100.0) + np.cumsum(noise) - noise[0]


def test_even_growth_is_known_exactly():
    found = judged(grown(steady()), 1e-16)
    assert found.exponents[0] == pytest.approx(RATE)
    assert found.half_widths[0] == pytest.approx(0.0, abs=1e-12)
    assert found.running[:, 0] == pytest.approx(RATE)
    assert found.finite_time[:, 0] == pytest.approx(RATE)
    assert found.running.shape == found.finite_time.shape == (100, 1)
    assert found.span == (100.0, 300.0) and found.times[0] == TIMES[1]
    assert found.warnings == ()


def test_intervals_hold_the_rate_and_narrow_with_the_scatter():
    wide, narrow = (judged(grown(steady(scatter)), 1e-16) for scatter in (1.0, 0.1))
    for found in (wide, narrow):
        assert abs(found.exponents[0] - RATE) < found.half_widths[0]
    assert narrow.half_widths[0] == pytest.approx(0.1 * wide.half_widths[0], rel=1e-6)
    # 100 steps of scatter 1 over 200 s: a standard deviation of 10 / 200, itself known from ten blocks
    assert 0.025 < wide.half_widths[0] < 0.4


def test_a_direction_that_sticking_took():
    lost = np.where(TIMES > 100.0, -math.inf, 0.0)
    found = judged(grown(steady(), lost, rank_losses=3), 1e-16)
    assert found.exponents[1] == -math.inf and math.isnan(found.half_widths[1])
    assert np.all(np.isneginf(found.finite_time[:, 1])) and np.all(np.isneginf(found.running[:, 1]))
    assert found.rank_losses == 3


def test_a_motion_that_has_not_settled():
    chaotic_first = np.where(TIMES < 200.0, steady(0.1), RATE * 100.0)
    (warning,) = judged(grown(chaotic_first), 1e-16).warnings
    assert warning.startswith("the largest exponent is 0.7") and "before 200 s" in warning
    assert judged(grown(0.001 * steady(0.1)), 1e-16).warnings == ()


def test_tangencies_are_told_with_their_time():
    (warning,) = judged(grown(steady(), tangencies=4), 1e-16).warnings
    assert warning.startswith("4 events crossed almost tangentially, the closest at 123 s")


def test_a_broken_volume_is_told_unless_the_tolerance_allows_it():
    broken = grown(steady(), volume_residual=1e-8)
    (warning,) = judged(broken, 1e-16).warnings
    assert "the exponents are not right" in warning
    assert judged(broken, 1e-9).warnings == ()


def test_a_span_too_short_for_intervals():
    found = grown(steady())
    short = replace(found, growth=found.growth[:10])
    assert math.isnan(judged(short, 1e-16).half_widths[0])
    ended = replace(found, growth=found.growth[:1])
    assert judged(ended, 1e-16).warnings == ("the run ended before the span of the exponents began",)


def case(name="I-C-eq211", t_end="120 s"):
    return vibsim.load_case(name, {"run.t_end": t_end})


def test_a_case_from_load_to_exponents():
    found = vibsim.lyapunov(case())
    assert found.span == (60.0, 120.0)
    assert len(found.exponents) == len(found.half_widths) == 3
    assert found.exponents[0] > 0.1 and found.half_widths[0] > 0.0  # chaos for hundreds of seconds
    assert sum(found.exponents) < 0.0
    assert abs(found.volume_residual) < 1e-10


def test_fewer_exponents_are_the_same():
    two = vibsim.lyapunov(case(t_end="20 s"), count=2, discard=5.0)
    everything = vibsim.lyapunov(case(t_end="20 s"), discard=5.0)
    np.testing.assert_array_equal(two.exponents, everything.exponents[:2])


def test_a_regular_motor_has_its_own_direction():
    """Exponents of II-A add up to its contraction, and the largest is that of a shift in time: 0."""
    found = vibsim.lyapunov(case("II-A", "300 s"))
    assert abs(found.exponents[0]) < 2e-3  # log(150) / 150 at most
    assert np.all(found.exponents[1:] < -0.01)


def test_what_a_case_has_not_got():
    with pytest.raises(ValueError, match="count must be 1 to 3 for this case, got 4"):
        vibsim.lyapunov(case(), count=4)
    with pytest.raises(ValueError, match="a transient of 120 s leaves nothing of 120 s"):
        vibsim.lyapunov(case(), discard=120.0)
    with pytest.raises(TypeError, match="discard must be a time in s, or a text such as '100 s'"):
        vibsim.lyapunov(case(), discard=[120.0])


def test_a_transient_may_be_a_text():
    timed, shared, plain = (vibsim.lyapunov(case(), count=1, discard=each) for each in ("30 s", "25 %", 30))
    assert timed.exponents == shared.exponents == plain.exponents


# The largest Lyapunov exponent of a run with its interval, and what it adds to the verdict.


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
    assert largest_exponent(short_run("I-C", "300 s")).sign == -1


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

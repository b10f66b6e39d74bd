"""From distances to estimates and a horizon."""

import math
from contextlib import suppress

import numpy as np
import pytest

from tests.scenes import NO_SOURCE, fixed_block, harmonic, motor, scene
from vibsim.physics.rates import longest_period
from vibsim.results.parallel_runs import GROWN, WINDOW, NotYet
from vibsim.results.trust_horizon import ErrorEstimate, held, rounded_up, widened

TIME = np.arange(2001) / 200
PERIOD = 0.5
SCENE = scene(harmonic(1 / PERIOD, 1.0)).as_parts()
ULP = 2.0**-52
CHORD = 2 / math.log(2) / math.e * 1.0001  # greatest ratio of 1 + x to 2^x between 0 and 1


def growing(start=1e-16, rate=2.3):
    """Two runs of size 1 whose distance swings and grows tenfold per second."""
    ours = np.stack([np.cos(12 * TIME), np.sin(3 * TIME)])
    apart = start * np.exp(rate * TIME) * np.sin(12 * TIME)
    return ours, ours + np.stack([apart, apart / 2])


def estimated(ours, theirs, tolerance=1e-10, pieces=1):
    estimate = ErrorEstimate(SCENE, tolerance)
    parts = [
        estimate.update(TIME[rows], ours[:, rows], theirs[:, rows])
        for rows in np.array_split(np.arange(len(TIME)), pieces)
    ]
    return estimate, np.concatenate(parts)


def test_the_estimate_is_no_less_than_the_distance_and_not_much_more():
    ours, theirs = growing()
    _, got = estimated(ours, theirs)
    distance = np.abs(ours - theirs).max(axis=0)
    assert np.all(got >= distance)
    assert np.all(got >= ULP)
    assert np.all(got <= np.maximum(1e-16 * np.exp(2.3 * TIME), ULP) * 3.7)


def test_blocks_of_any_size_give_the_same():
    whole, got = estimated(*growing())
    for pieces in (2, 7, len(TIME)):
        other, again = estimated(*growing(), pieces=pieces)
        np.testing.assert_allclose(again, got, rtol=2e-3)  # three digits are kept
        assert other.horizon(10) == pytest.approx(whole.horizon(10), abs=0.005)
        assert other.largest == pytest.approx(whole.largest, rel=2e-3)


def test_the_horizon_is_the_last_sample_within_the_tolerance():
    estimate, got = estimated(*growing())
    horizon = estimate.horizon(10.0)
    assert 0 < horizon < 10
    assert np.all(got[horizon >= TIME] <= 1e-10)
    assert got[horizon < TIME][0] > 1e-10


def test_a_tolerance_that_is_never_passed_and_one_that_is_at_once():
    assert estimated(*growing(), tolerance=1.0)[0].horizon(9.5) == 9.5
    assert estimated(*growing(), tolerance=1e-17)[0].horizon(9.5) == 0.0


def test_what_was_passed_once_stays_passed():
    ours, theirs = growing(rate=0.0)
    theirs[:, 400:440] += 1e-3
    estimate, got = estimated(ours, theirs, tolerance=1e-5, pieces=10)
    assert got[-1] < 1e-5
    assert estimate.horizon(10.0) == TIME[399]
    assert estimate.largest == got.max()


def test_without_a_companion_the_estimate_is_the_size_of_the_motion():
    ours, theirs = growing()
    theirs[:, 1000:] = np.nan
    _, got = estimated(ours, theirs)
    assert got[999] < 1e-9
    assert np.all(got[1000:] >= 1.0)


def test_equal_runs_at_rest_have_no_error():
    still = np.zeros((2, len(TIME)))
    estimate, got = estimated(still, still)
    assert not got.any()
    assert estimate.horizon(10.0) == 10.0
    assert len(estimate.update(TIME[:0], still[:, :0], still[:, :0])) == 0


def test_values_are_held_and_fade():
    values = np.zeros(len(TIME))
    values[100] = 1.0
    got = held(TIME, values, 2.0)
    faded = np.exp2(-2 * (TIME[100:] - TIME[100]) / math.log(2))
    assert np.all(got[100:] >= faded * (1 - 1e-10))
    assert np.all(got[100:] <= faded * CHORD)
    halves = TIME[100] + math.log(2) / 2 * np.arange(8)  # the half-lives
    np.testing.assert_allclose(held(np.append(TIME[100], halves), np.eye(9)[0], 2.0)[1:], 0.5 ** np.arange(8))
    assert not got[:100].any()


def test_distances_that_have_grown_count_for_more():
    decades = np.array([0.0, 2.0, 4.0, 8.0])
    np.testing.assert_allclose(
        widened(ULP * 10**decades, np.full(4, ULP)), ULP * 10**decades * [1, 1.25, 1.5, 2], rtol=0.007
    )
    assert widened(np.array([0.0]), np.array([0.0])) == 0.0
    assert widened(np.array([0.0]), np.array([ULP])) == ULP


def test_rounding_goes_up_and_keeps_three_digits():
    values = np.concatenate([10.0 ** np.linspace(-300, 3, 999), [0.0, 1.0, 2.0**-40]])
    got = rounded_up(values)
    assert np.all((got >= values) & (got <= values * 1.002))
    assert got[-3:].tolist() == [0.0, 1.0, 2.0**-40]


def test_the_slower_of_source_and_free_vibration_sets_the_time():
    natural = 2 * math.pi / math.sqrt(200 * (1 / 0.297 + 1 / 2.94))
    assert longest_period(scene().as_parts()) == pytest.approx(natural, rel=5e-3)  # of three digits
    assert longest_period(scene(harmonic(1.0, 1.0)).as_parts()) == pytest.approx(1.0)
    loaded = 2 * math.pi / math.sqrt(200 * (1 / 0.327 + 1 / 2.94))  # the unbalanced mass moves with block 1
    assert longest_period(scene(motor(50.0)).as_parts()) == pytest.approx(loaded, rel=5e-3)
    assert longest_period(fixed_block({**NO_SOURCE, "source": "none"}, k1=0.0).as_parts()) == math.inf


def asking(further, pieces=1, late=0):
    """Estimates where a third run is `further` times as far away as the companion, and answers after `late`
    questions; (estimates, questions).
    """
    ours, theirs = growing()
    questions = []

    def third(count, last, until):
        questions.append((count, last, until))
        if len(questions) <= late:
            raise NotYet
        rows = slice(count - last, count)
        return ours[:, rows] + further * (theirs - ours)[:, rows]

    estimate = ErrorEstimate(SCENE, 1e-10)
    waiting = np.array_split(np.arange(len(TIME)), pieces)
    parts = []
    while waiting:
        rows = waiting[0]
        with suppress(NotYet):
            parts.append(estimate.update(TIME[rows], ours[:, rows], theirs[:, rows], third=third))
            waiting.pop(0)
    return np.concatenate(parts), questions


def test_a_third_run_that_is_further_away_widens_what_follows():
    plain = estimated(*growing())[1]
    got, [(count, last, until)] = asking(20.0)
    assert until == TIME[count - 1] and last == WINDOW
    assert GROWN * ULP < plain[count - 1] < 1e3 * GROWN * ULP
    np.testing.assert_array_equal(got[:count], plain[:count])
    assert np.all(got[count:] >= 0.999 * np.minimum(20 * plain, 1)[count:])
    assert np.all(got[count:] <= 20 * 1.5 * plain[count:])  # decades of the wider distance count too
    for pieces in (2, 7, 300, len(TIME)):
        again, questions = asking(20.0, pieces)
        np.testing.assert_allclose(again, got, rtol=2e-3)
        assert questions == [(count, last, until)]


@pytest.mark.parametrize("pieces", [1, 7, 300])
def test_samples_that_a_third_run_was_late_for_are_judged_as_if_it_had_not_been(pieces):
    at_once, [question] = asking(20.0, pieces)
    later, questions = asking(20.0, pieces, late=3)
    np.testing.assert_array_equal(later, at_once)
    assert questions == 4 * [question]


def test_where_a_third_run_will_not_be_known_the_estimate_is_the_size_of_the_motion():
    ours, _ = growing()
    got, [(count, *_)] = asking(math.inf)
    size = np.maximum.accumulate(np.abs(ours).max(axis=0))
    np.testing.assert_array_equal(got[:count], estimated(*growing())[1][:count])
    assert np.all(got[count:] >= size[count:])


@pytest.mark.parametrize("further", [0.05, 1.0, math.nan])
def test_a_third_run_that_is_nearer_or_fails_changes_nothing(further):
    got, questions = asking(further)
    assert len(questions) == 1
    np.testing.assert_array_equal(got, estimated(*growing())[1])


def test_where_nothing_grows_no_third_run_is_asked():
    ours, _ = growing()
    estimate = ErrorEstimate(SCENE, 1e-10)
    estimate.update(TIME, ours, ours + 100 * ULP, third=lambda *_: pytest.fail("asked"))


def test_ages_beyond_all_measure_leave_the_estimate_as_it_is():
    """Fading at 1e152 1/s, of a spring of 1e300 N/m, gave a RuntimeWarning of numpy."""
    values = held(np.array([0.0, 0.5, 1.0]), np.array([1e-9, 1e-12, 1e-10]), 1e152)
    assert values.tolist() == pytest.approx([1e-9, 1e-12, 1e-10], rel=0.1)
    assert np.isfinite(held(np.array([0.0, 1.0]), np.array([1e-9, 0.0]), 1e308)).all()

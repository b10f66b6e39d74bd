"""The regime of maps and signals outside vibsim whose regime is known."""

import numpy as np
import pytest

from tests.analysis import known_maps
from vibsim.analysis.sections import (
    Exponent,
    approached_period,
    bands_of,
    find_period,
    judge_points,
    prediction_error,
    square_displacements,
    zero_one,
)

RNG = np.random.default_rng(11)


@pytest.mark.parametrize("count", [200, 500, 1500])
@pytest.mark.parametrize(("r", "period"), [(2.8, 1), (3.2, 2), (3.5, 4), (3.55, 8), (3.83, 3)])
def test_periodic_windows_of_the_logistic_map(r, period, count):
    found = judge_points(known_maps.logistic(r, count))
    assert (found.verdict, found.period, found.onset) == ("periodic", period, 0)


@pytest.mark.parametrize("count", [250, 500, 1500])
@pytest.mark.parametrize("orbit", [lambda n: known_maps.logistic(3.97, n), known_maps.henon])
def test_chaotic_maps(orbit, count):
    found = judge_points(orbit(count))
    assert found.verdict == "chaotic"
    assert found.chaos_number > 0.95


@pytest.mark.parametrize("count", [500, 1500])
@pytest.mark.parametrize(
    "orbit", [known_maps.torus, lambda n: known_maps.circle_map((np.sqrt(5) - 1) / 2, 0.8, n)]
)
def test_two_incommensurable_frequencies(orbit, count):
    found = judge_points(orbit(count))
    assert found.verdict == "quasi-periodic"
    assert abs(found.chaos_number) < 0.1


def test_a_locked_circle_map_is_periodic():
    found = judge_points(known_maps.circle_map(0.5, 0.9, 500))
    assert (found.verdict, found.period) == ("periodic", 2)


@pytest.mark.parametrize("dimension", [1, 3])
def test_noise_is_undecided(dimension):
    found = judge_points(RNG.normal(size=(800, dimension)))
    assert found.verdict == "undecided"
    assert "noise" in found.reason
    assert found.chaos_number > 0.9  # the 0-1 test alone takes it for chaos
    assert found.prediction == pytest.approx(1, abs=0.15)


def test_mostly_the_same_with_bursts():
    points = np.zeros((400, 1))
    points[RNG.choice(400, 20, replace=False)] = 1.0
    found = judge_points(points)
    assert (found.verdict, found.prediction) == ("undecided", None)


def test_a_noisy_period_is_not_taken_for_a_torus():
    noisy = known_maps.logistic(3.55, 800) + 0.01 * RNG.normal(size=(800, 1))
    assert judge_points(noisy).verdict == "undecided"


def test_a_spiral_is_on_its_way_to_a_fixed_point_however_it_turns():
    for turn in (0.1, 2 * np.pi / 23, 1.0, np.pi / 2 + 0.01):
        points = known_maps.spiral(500, turn, 0.99)
        found = judge_points(points)
        assert (found.verdict, found.period) == ("transient", 1), turn
    found = judge_points(known_maps.spiral(1500, 1.0, 0.99))
    assert (found.verdict, found.period) == ("periodic", 1)
    assert found.onset == pytest.approx(np.log(1e-3) / np.log(0.99), abs=30)


def test_a_slow_drift_along_a_curve_is_no_period():
    """Near a resonance of order 6 the points come back after 6, but a little further on each time."""
    phase = 2 * np.pi * np.arange(500) * (1 / 6 + 2e-6)
    points = np.stack([np.cos(phase), np.sin(phase)], axis=1)
    assert find_period(points[-60:]) is None
    assert judge_points(points).verdict != "periodic"


def test_a_motion_that_becomes_periodic_within_the_span_is_so_since_then():
    points = np.concatenate([known_maps.logistic(3.97, 300), known_maps.logistic(3.5, 200)])
    found = judge_points(points)
    assert (found.verdict, found.period) == ("periodic", 4)
    assert found.onset == pytest.approx(300, abs=2)


def test_chance_recurrences_are_not_approached():
    """Logistic map, 40 values of r from two bands to full chaos."""
    orbits = [known_maps.logistic(r, count) for r in np.linspace(3.58, 3.99, 40) for count in (100, 400)]
    assert sum(approached_period(orbit) is not None for orbit in orbits if find_period(orbit) is None) == 0


def test_too_few_points():
    assert "cycles are too few" in judge_points(known_maps.logistic(3.97, 30)).reason
    found = judge_points(known_maps.logistic(3.97, 150))
    assert (found.verdict, found.chaos_number) == ("undecided", None)
    assert judge_points(known_maps.logistic(3.5, 60)).verdict == "periodic"


@pytest.mark.parametrize(
    ("value", "between", "chaotic", "regular"),
    [
        (0.4, "undecided", "chaotic", "undecided"),
        (0.0, "undecided", "undecided", "quasi-periodic"),
        (-0.4, "transient", "undecided", "transient"),
    ],
)
def test_an_exponent_must_not_contradict(value, between, chaotic, regular):
    bands = known_maps.logistic(3.6, 390)  # two, of too few points each: K is between
    assert judge_points(bands).verdict == "undecided"
    orbits = [bands, known_maps.henon(500), known_maps.torus(500)]
    found = [judge_points(orbit, Exponent(value, 0.05)).verdict for orbit in orbits]
    assert found == [between, chaotic, regular]


@pytest.mark.parametrize(("r", "count"), [(3.66, 2), (3.59, 4), (3.5735, 8)])
def test_chaos_in_bands_is_chaos(r, count):
    """Bands of the logistic map merge at r = 3.678573 (2 to 1), 3.592572 and 3.574804."""
    points = known_maps.logistic(r, 400 * count)
    found = judge_points(points, Exponent(0.1, 0.05))
    assert (found.verdict, bands_of(points)) == ("chaotic", count)
    assert judge_points(points, Exponent(-0.1, 0.05)).verdict != "chaotic"


def test_what_alternates_and_is_not_chaotic_is_not_called_so():
    """Curves gone through in turn, and places with noise about them."""
    n = np.arange(1000)
    noise = np.random.default_rng(5).normal(size=(1000, 2))
    for k in (2, 3, 5):
        places = np.stack([np.cos(2 * np.pi * n / k), np.sin(2 * np.pi * n / k)], axis=1)
        assert judge_points(places + 0.1 * known_maps.torus(1000)).verdict != "chaotic"
        assert judge_points(places + 0.01 * noise).verdict != "chaotic"


def test_the_0_1_test_against_the_figures_of_its_authors():
    """Gottwald and Melbourne: K near 0 or 1 along the logistic map; here at 5 values of r."""
    found = [zero_one(known_maps.logistic(r, 1000).ravel()) for r in (3.5, 3.55, 3.83, 3.9, 3.97)]
    assert np.round(found, 1).tolist() == [0, 0, 0, 1, 1]
    assert np.isnan(zero_one(np.ones(300)))


def test_points_of_a_map_follow_from_their_neighbours():
    assert prediction_error(known_maps.henon(500)) < 0.03
    assert np.isnan(prediction_error(np.ones((500, 1))))
    assert np.isnan(prediction_error(np.ones((10, 1))))


def test_square_displacements_against_their_definition():
    path = np.cumsum(RNG.normal(size=(3, 200)) + 1j * RNG.normal(size=(3, 200)), axis=1)
    steps = np.arange(1, 21)
    expected = [np.mean(np.abs(path[:, n : n + 180] - path[:, :180]) ** 2, axis=1) for n in steps]
    found = square_displacements(path.real, path.imag, steps)
    np.testing.assert_allclose(found, np.transpose(expected), rtol=1e-11)

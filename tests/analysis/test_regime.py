"""The regime of runs: linear oscillators, the paper's cases, and what has no section."""

import numpy as np
import pytest

import vibsim
from tests.analysis import known_maps
from tests.results.made import short_case, short_run
from tests.trust.random_cases import driven_hard
from vibsim.analysis.cycles import Span
from vibsim.analysis.regime import judge_regime, word_period
from vibsim.analysis.sections import (
    Exponent,
    approached_period,
    bands_of,
    find_period,
    judge_points,
    prediction_error,
    section_of,
    square_displacements,
    zero_one,
)
from vibsim.engine.trajectory import open_trajectory

LINEAR = {"blocks__m2": "fixed", "friction": "none", "stop": "none"}


@pytest.mark.parametrize(
    ("name", "changes"),
    [("I-B", {}), ("I-B-eq211", {}), ("II-B", {}), ("II-B", {"stop": "none", "friction": "none"})],
)
def test_the_section_is_the_one_of_the_engine(name, changes):
    run = short_run(name, "30 s", **changes)
    section = section_of(run, Span(5.0, 30.0))
    blocks = [block.section for block in open_trajectory(run.case.scene(), section=True).blocks()]
    exact = {key: np.concatenate([block[key] for block in blocks]) for key in blocks[0]}
    rows = (exact["time"] >= 5) & (exact["time"] <= 30)
    exact = {key: column[rows] for key, column in exact.items()}
    late = run.time >= 5
    lengths, speeds = (np.ptp((run[f"{kind}1"] - run[f"{kind}2"])[late]) / 2 for kind in "xv")
    np.testing.assert_allclose(section.times, exact["time"], atol=1e-11)
    y, u = exact["x1"] - exact["x2"], exact["v1"] - exact["v2"]
    np.testing.assert_allclose(section.points[:, 0], y / lengths, atol=1e-9)
    np.testing.assert_allclose(section.points[:, 1], u / speeds, atol=1e-9)
    np.testing.assert_allclose(section.points[:, 2], exact["v2"] / speeds, atol=1e-9)
    assert section.points.shape[1] == (4 if name == "II-B" else 3)


def test_a_linear_oscillator_settles_to_period_1():
    """V4: transients fall as exp(-c t/2m): to 1e-3 after 6.9 x 0.594 s / 0.2."""
    run = short_run("I-B", "100 s", **LINEAR, coupling__c="0.2 N s/m")
    found = judge_regime(run, (0.0, 100.0))
    assert (found.verdict, found.period, found.word_period) == ("periodic", 1, 1)
    assert found.since == pytest.approx(np.log(1e3) * 2 * 0.297 / 0.2, rel=0.2)
    early = judge_regime(run, (0.0, 15.0))
    assert (early.verdict, early.period, early.since) == ("periodic", 1, None)  # 6e-3 away, and on its way
    np.testing.assert_allclose(early.exponents, [-0.2 / (2 * 0.297)] * 2, rtol=1e-9)
    np.testing.assert_allclose(found.exponents, early.exponents, rtol=1e-9)


def test_an_undamped_oscillator_is_quasi_periodic():
    """Two frequencies, of the source and its own, incommensurable and never settling."""
    found = judge_regime(short_run("I-B", "300 s", **LINEAR, coupling__c="0"))
    assert found.verdict == "quasi-periodic"


@pytest.mark.parametrize(("name", "period"), [("I-A", 5), ("I-B", 18)])
def test_the_periodic_cases_of_the_paper(name, period):
    """The states repeat themselves to rounding after so many cycles, see their section at 3000 s."""
    found = judge_regime(short_run(name, "300 s"))
    assert (found.verdict, found.period, found.word_period) == ("periodic", period, period)
    run = short_run(name, "300 s")
    times = 300 - np.array([0, period]) / run.case.two_blocks().cycles
    v1 = run.at(times)["v1"]
    assert abs(v1[0] - v1[1]) < 1e-7


def test_i_c_is_on_its_way_to_period_1():
    """The multipliers in 16 digits: tests/orbits/truths.json."""
    found = judge_regime(short_run("I-C", "300 s"))
    assert (found.verdict, found.period) == ("periodic", 1)
    assert found.step < 1e-3 and found.since > 200
    multipliers = np.array([complex(*pair) for pair in found.multipliers])
    exact = [0.8486435858373631 - 0.5215168804985694j, 0.8486435858373631 + 0.5215168804985694j]
    np.testing.assert_allclose(multipliers, [*exact, 0.9303994608203476], rtol=0, atol=1e-12)
    assert (found.exponent, found.exponents) == (None, pytest.approx(np.log(np.abs(multipliers)) * 6.5))


def test_a_stable_orbit_beside_the_run_is_none_it_goes_to():
    """I-C-eq211 goes to an orbit of 6 periods; the stable one of 1 that Newton's method meets is another."""
    found = judge_regime(short_run("I-C-eq211", "300 s"))
    assert (found.verdict, found.multipliers) == ("undecided", None)


@pytest.mark.parametrize("seed", [9, 19, 4, 7, 12, 31])  # 6 is periodic after a chaotic transient
def test_chaos_and_the_trust_horizon_agree(seed):
    """Driven hard against a stop, chaotic motion loses 1e-16 to 1e-6 m early, regular motion never."""
    run = vibsim.simulate(driven_hard(seed).with_values({"run.t_end": "200 s"}))
    found = judge_regime(run)
    assert found.verdict == ("chaotic" if run.trust_horizon < 30 else "periodic")
    assert found.span.trusted == (found.verdict == "periodic")


def test_nothing_moves():
    found = judge_regime(short_run("I-A", excitation="none"))
    assert (found.verdict, found.period) == ("at rest", None)


def test_what_has_no_section_is_undecided():
    found = judge_regime(short_run("I-A", excitation="none", initial__x1="5 mm"))
    assert (found.verdict, found.reason) == ("undecided", "no source, so no stroboscopic section")
    assert judge_regime(short_run("I-A")).verdict == "undecided"
    assert judge_regime(short_run("I-A"), (1.0, 1.1)).cycles == 0


def test_files_are_judged_as_runs_in_memory_are(tmp_path):
    run = vibsim.simulate(short_case("I-A", "60 s"))
    run.save(tmp_path / "run.h5")
    assert judge_regime(vibsim.open_result(tmp_path / "run.h5")) == judge_regime(run)


def test_periods_of_words():
    assert word_period(["c", "cr", "c", "cr"]) == 2
    assert word_period(["c", "cr", "c"]) is None
    assert word_period(["c", "c", "c", "cr"]) is None
    assert word_period([]) is None


# The regime of maps and signals outside vibsim whose regime is known.


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
    assert "too few cycles" in judge_points(known_maps.logistic(3.97, 30)).reason
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

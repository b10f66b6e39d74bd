"""From cases, runs, stored orbits and random starts to orbits."""

import numpy as np
import pytest

import vibsim
from tests.orbits.truths import TRUTHS
from vibsim.analysis.attractor import is_mirrored, lies_on, neighbourhood_of
from vibsim.cases import load_case
from vibsim.orbits.coordinates import OrbitError
from vibsim.orbits.newton import likely_periods
from vibsim.orbits.orbit import save_orbit
from vibsim.orbits.search import (
    NewtonAttempt,
    SearchTally,
    orbit,
    same,
    search_attempts,
    search_orbits,
    time_of_returns,
)
from vibsim.orbits.stability import moduli
from vibsim.orbits.words import cyclic
from vibsim.results import simulate
from vibsim.results.hdf5_reading import ResultFileError

SETTLES = {"I-A": 5, "I-B": 18, "I-C": 1, "I-A-eq211": 1, "II-A": 1, "II-B": 3, "II-C": 1}
CAPTURED = {"c": "0.03 N s/m", "Omega0": "5 Hz"}


@pytest.mark.parametrize("name", SETTLES)
def test_where_the_papers_cases_go(name):
    orbit_there = orbit(name)
    assert orbit_there.n == SETTLES[name] and orbit_there.stable and orbit_there.certified
    assert abs(orbit_there.energy["energy_residual"]) < 1e-14  # rounding of the rotor's energy, half a joule
    energy = orbit_there.energy
    gained, lost = (sum(energy[key] for key in energy if key.startswith(kind)) for kind in ("work", "loss"))
    assert gained == pytest.approx(lost, rel=1e-9)


def test_a_run_is_followed_past_the_unstable_orbits_on_its_way():
    """I-B-eq211 is chaotic for longer than its 300 s, and by an unstable orbit of period 6 then."""
    assert orbit("I-B-eq211").stable


def test_the_attractor_of_I_A_is_the_truths():
    """At one of its five returns it is the state of truths.json; its word is that one turned round."""
    of = TRUTHS["I-A attractor, period 5"]
    orbit_there = orbit("I-A")
    assert np.abs(orbit_there.points - of.unknowns).max(axis=1).min() < 1e-15
    assert len(orbit_there.points) == 5 and orbit_there.spelled != of.word
    assert sorted(orbit_there.spelled) == sorted(of.word) and of.word in 2 * orbit_there.spelled


def test_a_run_and_a_file_of_it(tmp_path):
    case = load_case("I-C", {"run.t_end": "60 s"})
    result = simulate(case)
    result.save(tmp_path / "run.h5")
    of_case, of_result, of_file = (orbit(s) for s in (case, result, vibsim.open_result(tmp_path / "run.h5")))
    np.testing.assert_allclose(of_result.X, of_case.X, rtol=0, atol=1e-15)
    np.testing.assert_allclose(of_file.X, of_result.X, rtol=0, atol=0)


def test_a_stored_orbit(tmp_path):
    """A run of one period that starts on it; a start for others; written again it is the same."""
    first = orbit("II-B", CAPTURED)
    stored = save_orbit(first, tmp_path / "orbit.h5")
    assert stored.attrs["orbit_periods"] == 1 and stored.t_reached == first.period
    again = orbit(vibsim.open_result(tmp_path / "orbit.h5"))
    assert orbit(str(tmp_path / "orbit.h5")).state == orbit(tmp_path / "orbit.h5").state == again.state
    assert again.solution.steps == 0 and np.array_equal(again.X, first.X)
    np.testing.assert_array_equal(stored.orbit["multiplier_real"], first.multipliers.real)
    assert list(stored.orbit["unknown"]) == ["x1-x2", "v1", "v2", "phidot"]
    end = {name: stored.events[name][-1] for name in ("x1", "x2", "v1", "v2", "phidot")}
    np.testing.assert_allclose(again.end.coordinates.of([*list(end.values())[:4], 0, end["phidot"]]), first.X)
    stored.save(tmp_path / "copy.h5")
    copy = vibsim.open_result(tmp_path / "copy.h5").orbit
    assert all(np.array_equal(copy[name], stored.orbit[name]) for name in stored.orbit)
    beside = orbit(vibsim.open_result(tmp_path / "orbit.h5"), {"Omega0": "5.1 Hz"})
    assert beside.spelled == first.spelled and beside.solution.steps <= 6
    with pytest.raises(ResultFileError, match="exists"):
        save_orbit(first, tmp_path / "orbit.h5")


def test_a_run_that_starts_on_it_stays_there(tmp_path):
    stored = save_orbit(orbit("II-B", CAPTURED), tmp_path / "orbit.h5")
    run = simulate(stored.case.with_values({"run.t_end": f"{20 * stored.t_reached!r} s"}))
    ends = run.at(np.arange(20) * stored.t_reached)
    np.testing.assert_allclose(ends["phidot"], ends["phidot"][0], rtol=1e-11)
    np.testing.assert_allclose(ends["x1"] - ends["x2"], ends["x1"][0], rtol=1e-10)


def test_a_search_lists_each_orbit_once():
    """V12: a stable orbit of two periods, beside it one of one; multipliers multiply to exp(-c T / m)."""
    case = load_case("gallery/bilinear-oscillator")
    orbits = [one for attempt in search_attempts(case, 12, seed=3) for one in attempt.orbits]
    assert {(one.n, one.stable) for one in orbits} >= {(2, True), (1, False)}
    for i, one in enumerate(orbits):
        assert np.prod(one.multipliers).real == pytest.approx(np.exp(-0.02 * one.period), rel=1e-11)
        assert not any(same(one, other) for other in orbits[:i])
    again = [one.spelled for one in search_orbits(case, count=12, seed=3)]
    assert again == [one.spelled for one in orbits]
    two = next(one for one in orbits if one.n == 2)
    shifted = orbit(case, start=two.end.coordinates.state(two.points[1]), period=2)
    assert same(two, shifted) and cyclic(shifted.events) == two.word


def test_likely_periods():
    """Of a motion of period 3 that is settling, 3 comes before its multiples and before what is as near."""
    n = np.arange(120)
    points = np.stack([np.cos(2 * np.pi * n / 3) + 0.3 * 0.95**n, np.sin(2 * np.pi * n / 3)], axis=1)
    numbers, distances = likely_periods(points)
    assert numbers[0] == 3 and distances[2] < 1e-2 < distances[0]


def test_more_periods_than_points_are_looked_at():
    """Of a motor only the last points on the section are there to tell how long so many turns take."""
    times = np.array([1.0, 2.0, 4.0, 5.0])
    assert [time_of_returns(times, n) for n in (1, 2, 3)] == [1.0, 3.0, 4.0]
    assert time_of_returns(times, 4) == pytest.approx(16 / 3)


def test_what_is_no_state_of_an_orbit():
    with pytest.raises(OrbitError, match="misses v2"):
        orbit("I-C", start={"x1": 0, "x2": 0, "v1": 0})
    with pytest.raises(OrbitError, match="no stored orbit"):
        orbit("I-C", start=simulate(load_case("I-C", {"run.t_end": "1 s"})))


@pytest.mark.parametrize("value", [0, -1, 1.5, "2", True])
def test_counts_are_whole_numbers(value):
    with pytest.raises(OrbitError, match="period must be a whole number, one or more"):
        orbit("I-C", period=value)
    with pytest.raises(OrbitError, match="count must be a whole number, one or more"):
        search_orbits("I-C", count=value)
    with pytest.raises(OrbitError, match="max_points must be a whole number, 2 or more"):
        vibsim.continue_branch("I-C", "A", "0.1:0.2 N", max_points=value)


@pytest.mark.parametrize(
    "start", [3, "x", [0, 0, 0], [0, 0, 0, np.nan], {"x1": "a", "v1": 0, "x2": 0, "v2": 0}]
)
def test_what_is_no_start(start):
    no_state = "a state is a finite number for each component"
    no_word = "the start is an orbit, a state or 'initial', got 'x'"
    with pytest.raises(OrbitError, match=no_word if start == "x" else no_state):
        orbit("I-C", start=start)
    with pytest.raises(OrbitError, match=no_state):
        vibsim.monodromy("I-C", state=start, T=1.0)


def test_a_state_by_name_or_in_the_order_of_the_columns():
    by_name = vibsim.monodromy("I-C", state={"x1": 1e-4, "v2": 0.1}, T=1.0)
    in_order = vibsim.monodromy("I-C", state=np.array([1e-4, 0, 0, 0.1]), T=1.0)
    assert np.array_equal(by_name.matrix, in_order.matrix)
    found = orbit("I-C")
    assert orbit("I-C", start=list(found.state.values())).residual == orbit("I-C", start=found).residual


@pytest.mark.parametrize("T", ["1 s", -1, 0, np.inf, np.nan, None])
def test_what_is_no_time(T):
    with pytest.raises(OrbitError, match="T must be a number of seconds above 0"):
        vibsim.monodromy("I-C", state={}, T=T)


# How complete a search for orbits is, and what it finds on the way of runs.


def tally_of(*starts):
    tally = SearchTally()
    for i, met in enumerate(starts):
        tally.add(NewtonAttempt(i, [], met))
    return tally


def test_counts_by_hand():
    """Orbits 0 to 3 by 4, 1, 2 and 1 starts: f1 = 2, f2 = 1, so 2 (2 - 1) / (2 (1 + 1)) 3 / 4 = 3/8."""
    tally = tally_of((0,), (0, 1), (0, 2), (0, 2, 3))
    assert tally.counts == [4, 1, 2, 1] and tally.starts == 4
    assert (tally.found(1), tally.found(2)) == (2, 1)
    assert tally.unseen == pytest.approx(3 / 8) and tally.next_is_new == 0.5


def test_the_estimates_hold_where_the_truth_is_known():
    """60 kinds of different chances, 100 draws: Chao's is a lower bound, Good's the chance of what is new."""
    random = np.random.default_rng(5)
    chances = random.dirichlet(np.full(60, 0.5))
    unseen, estimated, new, told = [], [], [], []
    for _ in range(200):
        numbers: dict[int, int] = {}
        draws = random.choice(60, 100, p=chances).tolist()
        tally = tally_of(*((numbers.setdefault(draw, len(numbers)),) for draw in draws))
        missed = [kind for kind in range(60) if kind not in numbers]
        unseen.append(len(missed))
        estimated.append(tally.unseen)
        new.append(chances[missed].sum())
        told.append(tally.next_is_new)
    assert 0.2 * np.mean(unseen) < np.mean(estimated) < 1.1 * np.mean(unseen)
    assert np.mean(told) == pytest.approx(np.mean(new), rel=0.1)


def test_runs_that_pass_by_lead_to_unstable_orbits_of_four_periods():
    """I-A at 3.5 Hz: the two whose largest multipliers are 3.227 and 38.48, which few random starts meet."""
    case = vibsim.load_case("I-A", {"excitation.omega": "3.5 Hz"})
    tally, found = SearchTally(), []
    for attempt in search_attempts(case, 40):
        tally.add(attempt)
        found += attempt.orbits
    assert len(tally.counts) == len(found) and sum(tally.counts) > 100
    largest = sorted(float(moduli(one.multipliers).max()) for one in found if one.n == 4)
    assert largest == pytest.approx([3.227, 38.48], rel=1e-3)


def test_the_neighbourhood_of_a_linear_orbit_contracts_as_its_multipliers():
    """The cantilever clear of its stop: V solves A' P A - P = -1, and holds up to where it meets the stop."""
    orbit = vibsim.orbit("gallery/cantilever")
    around = neighbourhood_of(orbit)
    ratios = orbit.end.coordinates.ratios
    A = orbit.end.derivative * ratios
    np.testing.assert_allclose(A.T @ around.form @ A - around.form, -np.eye(2), atol=1e-9)
    drawn = np.random.default_rng(3).normal(size=(20, 2))
    for y in drawn:  # inside the tested ellipsoid, in directions that were not tested
        y = y * 0.4 * around.radius / np.sqrt(y @ around.form @ y)
        image = orbit.return_map.plain(orbit.X + y / around.weights).image
        assert around.sizes(image[None])[0] < 0.999 * 0.4 * around.radius
    assert around.radius > 0


def test_no_neighbourhood_of_what_is_unstable():
    case = vibsim.load_case("gallery/cantilever")
    saddle = next(one for one in vibsim.search_orbits(case, count=12, seed=1) if not one.stable)
    assert neighbourhood_of(saddle).radius == 0
    assert not neighbourhood_of(saddle).holds(saddle.X[None])[0]


def test_points_of_an_orbit_at_other_phases_lie_on_it():
    orbit = vibsim.orbit("I-A")
    assert orbit.n == 5 and all(lies_on(orbit, point) for point in orbit.points)
    assert not lies_on(orbit, orbit.points[0] + 1e-4 * orbit.X)


def test_mirror_images_of_a_symmetric_scene():
    """The friction oscillator is its own mirror image half a period later; the cantilever has one stop."""
    symmetric = vibsim.orbit("gallery/friction-oscillator")
    assert is_mirrored(symmetric, symmetric.X)
    one_sided = vibsim.orbit("gallery/impact-oscillator")
    assert not is_mirrored(one_sided, one_sided.X)

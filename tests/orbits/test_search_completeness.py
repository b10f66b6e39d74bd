"""How complete a search for orbits is, and what it finds on the way of runs."""

import numpy as np
import pytest

import vibsim
from vibsim.analysis.attractor import is_mirrored, lies_on, neighbourhood_of
from vibsim.orbits.search import NewtonAttempt, SearchTally, search_attempts
from vibsim.orbits.stability import moduli


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

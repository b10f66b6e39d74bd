"""Orbits against 22 digits of them (truths.json says from where)."""

import numpy as np
import pytest

from tests.orbits.truths import TRUTHS
from vibsim.orbits import find_orbit
from vibsim.orbits.newton import newton_step, tolerance
from vibsim.orbits.words import LETTERS, cyclic, spelled

GRAZING = "I-A n=5 grazing rsurrbrerrrrrbrerr>rsurberbrerrrrrbrerr"
FOLDS = ("I-A n=5 isola fold", "II-B c=0.03 captured branch fold")
OTHERS = [name for name in TRUTHS if name not in (*FOLDS, GRAZING)]


def disturbed(state, by):
    signs = np.random.default_rng(13).choice([-1, 1], len(state))
    return {name: value * (1 + by * sign) for (name, value), sign in zip(state.items(), signs, strict=True)}


def error_bound(orbit):
    """What the rounding of the map leaves of a fixed point: the tolerance by (I - P')^-1, as weighed."""
    end = orbit.end
    weights = end.coordinates.weights
    matrix = (np.eye(len(weights)) - end.derivative) * (weights[:, None] / weights)
    return tolerance(end) / np.linalg.svd(matrix, compute_uv=False).min() / weights


def distance(multipliers, truths):
    return max(min(abs(multipliers - mu)) for mu in truths)


@pytest.mark.parametrize("name", OTHERS)
def test_orbits(name):
    of = TRUTHS[name]
    orbit = find_orbit(of.scene, disturbed(of.state, 1e-4), of.n)
    assert orbit.n == of.n and orbit.spelled == of.word and orbit.certified
    assert np.all(np.abs(orbit.X - of.unknowns) <= error_bound(orbit) + 2e-16 * np.abs(of.unknowns))
    assert orbit.period == pytest.approx(of.period, rel=1e-13)
    # the multipliers change with the state, at a Neimark-Sacker point a hair before a fold by a factor of 10
    assert distance(orbit.multipliers, of.multipliers) < 1e-10
    assert orbit.residual <= orbit.solution.tolerance


@pytest.mark.parametrize("name", FOLDS)
def test_a_fold(name):
    """I - P' is singular: a residual of rounding leaves the square root of it of the state."""
    of = TRUTHS[name]
    orbit = find_orbit(of.scene, disturbed(of.state, 1e-6), of.n)
    assert np.all(np.abs(orbit.X - of.unknowns) < 1e-5) and orbit.spelled == of.word
    assert distance(orbit.multipliers, of.multipliers) < 2e-5
    exact = find_orbit(of.scene, of.state, of.n)
    assert exact.solution.steps == 0 and distance(exact.multipliers, of.multipliers) < 1e-11


def test_an_orbit_that_grazes():
    """Beside a graze the matrix changes like the root of the distance: what 1e-17 m of depth leave is 1e-5.

    The word has the graze itself, g, or a contact of that depth in its place.
    """
    of = TRUTHS[GRAZING]
    orbit = find_orbit(of.scene, disturbed(of.state, 1e-4), of.n)
    assert np.all(np.abs(orbit.X - of.unknowns) < 1e-14)
    assert distance(orbit.multipliers, of.multipliers) < 1e-4
    assert orbit.spelled in (of.word.replace("g", ""), of.word.replace("g", "be"))


def test_stability():
    exact = {name: find_orbit(of.scene, of.state, of.n) for name, of in TRUTHS.items()}
    for name in OTHERS:
        assert distance(exact[name].multipliers, TRUTHS[name].multipliers) < 1e-11
    simple = ["I-C attractor, period 1", "II-B c=0.03 captured n=1 (2 impacts/turn)"]
    assert max(distance(exact[name].multipliers, TRUTHS[name].multipliers) for name in simple) < 1e-12
    stable = {name for name, orbit in exact.items() if orbit.stable}
    assert {name for name in TRUTHS if "attractor" in name or "impacts/turn" in name} <= stable
    assert not stable & {GRAZING, "II-B c=0.03 saddle on the captured branch, n=1", FOLDS[1]}


@pytest.mark.parametrize("name", [name for name in OTHERS if TRUTHS[name].n == 1])
def test_the_least_period(name):
    """Newton's method over three periods of an orbit of one lands on the orbit of one."""
    of = TRUTHS[name]
    orbit = find_orbit(of.scene, disturbed(of.state, 1e-6), 3)
    assert orbit.n == 1 and orbit.period == pytest.approx(of.period, rel=1e-12)
    assert orbit.spelled == of.word


@pytest.mark.parametrize("name", ["I-A attractor, period 5", "II-B c=0.03 captured n=1 (2 impacts/turn)"])
def test_the_derivative_of_the_map(name):
    """By difference quotients of the map itself, beside the orbit, the time of return free as it is."""
    of = TRUTHS[name]
    orbit = find_orbit(of.scene, of.state, of.n)
    return_map, derivative = orbit.return_map, orbit.end.derivative
    for k, size in enumerate(np.maximum(np.abs(orbit.X), 1e-3)):
        h = 1e-6 * size * np.eye(len(orbit.X))[k]
        images = [landing(return_map, orbit.X + sign * h, orbit.period) for sign in (1, -1)]
        np.testing.assert_allclose((images[0] - images[1]) / (2e-6 * size), derivative[:, k], atol=2e-5)


def landing(return_map, X, T):
    """Where the motion from X meets the section."""
    for _ in range(4):
        end = return_map(X, T)
        if end.tilt is None:
            return end.image
        T -= end.ahead / end.tilt[1]
    return end.image


def test_a_step_solves_the_linearised_equations():
    of = TRUTHS["II-B c=0.03 captured n=1 (2 impacts/turn)"]
    orbit = find_orbit(of.scene, of.state, 1)
    end = orbit.return_map(orbit.X * (1 + 1e-5), orbit.period * (1 - 1e-5))
    change, longer = newton_step(end)
    after = end.image + end.flow_matrix @ change + end.rate * longer
    np.testing.assert_allclose(after, end.X + change, rtol=0, atol=1e-14)
    slopes, rate = end.tilt
    assert end.ahead + slopes @ change + rate * longer == pytest.approx(0, abs=1e-15)


def test_words_are_circles():
    of = TRUTHS["I-A attractor, period 5"]
    word = find_orbit(of.scene, of.state, 5).events
    assert cyclic(word[3:] + word[:3]) == cyclic(word) != cyclic(word[:-1])
    assert spelled(of.scene, word) == of.word
    assert len(set(LETTERS.values())) == len(LETTERS)

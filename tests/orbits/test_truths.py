"""Orbits against 22 digits of them (truths.json says from where), and against numbers of other programs."""

import json
from decimal import Decimal
from functools import cache
from math import cos, exp, pi, sqrt
from pathlib import Path

import mpmath
import numpy as np
import pytest

import vibsim
from tests.branches.made import CAPTURED, PERIOD_5, RESONANT, orbit_of
from tests.orbits.truths import STORED, TRUTHS, landing
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.orbits.coordinates import OrbitError
from vibsim.orbits.newton import newton_step, tolerance
from vibsim.orbits.orbit_digits import refine
from vibsim.orbits.search import find_orbit, orbit
from vibsim.orbits.stability import characteristic_polynomial, refined_roots, solved
from vibsim.orbits.words import LETTERS, cyclic, spelled
from vibsim.physics.numbers import Doubles
from vibsim.physics.precision import number_kit

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
    for name in (RESONANT, CAPTURED):
        assert distance(exact[name].multipliers, TRUTHS[name].multipliers) < 1e-12
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


@pytest.mark.parametrize("name", [PERIOD_5, CAPTURED])
def test_the_derivative_of_the_map(name):
    """By difference quotients of the map itself, beside the orbit, the time of return free as it is."""
    of = TRUTHS[name]
    orbit = find_orbit(of.scene, of.state, of.n)
    return_map, derivative = orbit.return_map, orbit.end.derivative
    for k, size in enumerate(np.maximum(np.abs(orbit.X), 1e-3)):
        h = 1e-6 * size * np.eye(len(orbit.X))[k]
        images = [landing(return_map, orbit.X + sign * h, orbit.period) for sign in (1, -1)]
        np.testing.assert_allclose((images[0] - images[1]) / (2e-6 * size), derivative[:, k], atol=2e-5)


def test_a_step_solves_the_linearised_equations():
    of = TRUTHS[CAPTURED]
    orbit = find_orbit(of.scene, of.state, 1)
    end = orbit.return_map(orbit.X * (1 + 1e-5), orbit.period * (1 - 1e-5))
    change, longer = newton_step(end)
    after = end.image + end.flow_matrix @ change + end.rate * longer
    np.testing.assert_allclose(after, end.X + change, rtol=0, atol=1e-14)
    slopes, rate = end.tilt
    assert end.ahead + slopes @ change + rate * longer == pytest.approx(0, abs=1e-15)


def test_words_are_circles():
    of = TRUTHS[PERIOD_5]
    word = find_orbit(of.scene, of.state, 5).events
    assert cyclic(word[3:] + word[:3]) == cyclic(word) != cyclic(word[:-1])
    assert spelled(of.scene, word) == of.word
    assert len(set(LETTERS.values())) == len(LETTERS)


# Orbits and multipliers in many digits, against 22 and 16 of them (truths.json).


BY_NAME = {stored["name"]: stored for stored in STORED}


@pytest.mark.parametrize("name", [PERIOD_5, RESONANT, CAPTURED])
def test_the_truths(name):
    stored, digits = BY_NAME[name], refine(orbit_of(name), 23)
    assert abs(Decimal(digits.period) / Decimal(stored["period"]) - 1) < Decimal("1e-21")
    state = [stored["state"][key] for key in ("y", "v1", "v2", "phidot") if key in stored["state"]]
    size = max(abs(Decimal(value)) for value in state[:3])
    for text, value in zip(digits.coordinates.values(), state, strict=True):
        assert abs(Decimal(text) - Decimal(value)) < Decimal("2e-21") * max(size, abs(Decimal(value)))
    multipliers = [complex(float(re), float(im)) for re, im in digits.multipliers]
    for re, im in stored["multipliers"]:
        assert min(abs(mu - complex(float(re), float(im))) for mu in multipliers) < 5e-16
    assert digits.correction < 1e-23


def test_more_digits_begin_with_the_same():
    orbit = orbit_of(RESONANT)
    few, many = refine(orbit, 20), refine(orbit, 50)
    for one, other in zip(few.coordinates.values(), many.coordinates.values(), strict=True):
        assert len(other.partition("e")[0]) > 50 and abs(Decimal(one) / Decimal(other) - 1) < Decimal("1e-19")
    sizes = [Decimal(re) ** 2 + Decimal(im) ** 2 for re, im in many.multipliers]
    assert abs(sizes[0] / sizes[1] - 1) < Decimal("1e-49")  # a conjugate pair


def test_a_linear_oscillator_in_closed_form():
    """Multipliers exp(-a T) exp(+- i w T), whatever the load."""
    case = load_case(
        "name: linear\nbodies: {mass: 1 kg}\n"
        "links: {spring: {between: [mass, ground], k: 10 N/m, c: 0.2 N s/m}}\n"
        "forces: {drive: {on: mass, A: 1 N, omega: 0.25 Hz}}\nrun: {t_end: 400 s, every: 10 ms}\n"
    )
    orbit = find_orbit(case.scene(), {"x_mass": 0.0, "v_mass": 0.0}, 1, case=case)
    T, a = 4.0, 0.1
    w = sqrt(10 - a * a)
    for re, _ in refine(orbit, 25).multipliers:
        assert float(re) == pytest.approx(exp(-a * T) * cos(w * T), abs=1e-14)
    assert orbit.multipliers[0].real == pytest.approx(exp(-a * T) * cos(w * T), abs=1e-14)
    assert orbit.solution.steps <= 1 and orbit.stable  # the map is linear
    amplitude = 1 / sqrt((10 - (pi / 2) ** 2) ** 2 + (0.2 * pi / 2) ** 2)
    assert np.hypot(orbit.X[0], orbit.X[1] / (pi / 2)) == pytest.approx(amplitude, rel=1e-12)


def test_a_scene_alone_has_no_more_digits():
    orbit = find_orbit(load_case("I-C").scene(), TRUTHS[RESONANT].state, 1)
    with pytest.raises(OrbitError, match="its numbers are doubles"):
        refine(orbit, 30)


@pytest.mark.parametrize("kit", [Doubles, number_kit(40)], ids=["doubles", "40 digits"])
def test_matrices_of_any_kit(kit):
    matrix = [[2.0, -1.0, 0.5], [0.25, 3.0, 1.0], [-4.0, 1.0, 0.125]]
    numbers = [[kit.number(value) for value in row] for row in matrix]
    x = solved(kit, numbers, [kit.number(value) for value in (1.0, -2.0, 3.0)])
    np.testing.assert_allclose([float(value) for value in x], np.linalg.solve(matrix, [1, -2, 3]), rtol=1e-14)
    polynomial = characteristic_polynomial(kit, numbers)
    np.testing.assert_allclose([float(c) for c in polynomial[::-1]], np.poly(matrix), rtol=1e-14)
    values = np.linalg.eigvals(matrix)
    roots = refined_roots(kit, polynomial, (values * (1 + 1e-3)).tolist(), 8)
    np.testing.assert_allclose([complex(float(a), float(b)) for a, b in roots], values, rtol=1e-14)


CHATTERING = """
bodies: {a: 1.036 kg, b: 1.621 kg}
links:
  w: {between: [a, ground], k: 88.55 N/m, c: 0.433 N s/m}
  l: {between: [a, b], k: 169.67 N/m, c: 0.932 N s/m}
stops: {s: {between: [a, b], law: rigid, e: 0.37, gap: 12.3 mm, acts: compression}}
friction: {f: {between: [b, ground], N: 0.795 N, mu: 0.495}}
forces: {p: {on: a, A: 2.997 N, omega: 5.2472 rad/s, phase: 11.5 deg}}
run: {t_end: 100 s, every: 50 ms}
"""


def test_an_orbit_that_chatters_is_known_in_doubles_only():
    """Newton's step was no number, and the next motion ended with "the state is no longer finite"."""
    found = orbit(load_case_text(CHATTERING))
    assert "c" in found.spelled
    with pytest.raises(OrbitError, match="orbits that chatter or graze are known in doubles only"):
        refine(found, 30)


# Orbits of vibsim's own in 40 digits (own_digits.json), held to laws that know of no orbit.


OWN = {one["case"]: one for one in json.loads(Path(__file__).with_name("own_digits.json").read_text())}
QUICK = ["gallery/impact-oscillator-coco", "gallery/ball-on-shaken-table"]
# what the multipliers of a period multiply to: exp(-c T / m), times e^2 at each impact
LAWS = {
    "gallery/bilinear-oscillator": lambda T: mpmath.exp(-T / 50),
    "gallery/impact-oscillator-coco": lambda T: mpmath.mpf("0.64") * mpmath.exp(-T / 10),
    "gallery/impact-oscillator": lambda T: mpmath.mpf("0.64"),
    "gallery/ball-on-shaken-table": lambda T: mpmath.mpf("0.64"),
}


@pytest.mark.parametrize("name", LAWS)
def test_multipliers_multiply_as_liouville_says(name):
    stored = OWN[name]
    with mpmath.workdps(50):
        (re, im), (other, minus) = [[mpmath.mpf(text) for text in pair] for pair in stored["multipliers"]]
        product = re * other - im * minus
        assert abs(product / LAWS[name](mpmath.mpf(stored["period"])) - 1) < mpmath.mpf("1e-38")


def test_budd_and_duxs_orbit_in_closed_form():
    """V13: the trace of the matrix, with the speed of the impact from the closed form, in 40 digits."""
    stored = OWN["gallery/impact-oscillator"]
    with mpmath.workdps(50):
        w, e = mpmath.mpf("3.7"), mpmath.mpf("0.8")
        T, gain = 4 * mpmath.pi / w, 1 / (1 - w**2)
        a, b = mpmath.sin(T) / (1 - mpmath.cos(T)) * (1 + e), (1 - e) / w
        V = 2 * mpmath.sqrt(gain**2 * (a**2 + b**2)) / (a**2 + b**2)
        load = a * V / 2 / gain
        trace = -2 * e * mpmath.cos(T) + (1 + e) * load * mpmath.sin(T) / V
        assert abs(mpmath.mpf(stored["period"]) / T - 1) < mpmath.mpf("1e-39")
        assert abs(sum(mpmath.mpf(re) for re, _ in stored["multipliers"]) / trace - 1) < mpmath.mpf("1e-37")


@pytest.mark.parametrize("name", QUICK)
def test_doubles_and_digits(name):
    met(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in OWN if name not in QUICK])
def test_doubles_and_digits_of_the_others(name):
    met(name)


def met(name):
    """The orbit in doubles is the stored one to rounding, and its digits are the stored ones."""
    stored, orbit = OWN[name], vibsim.orbit(name)
    assert (orbit.n, orbit.spelled) == (stored["n"], stored["events"])
    assert orbit.period == pytest.approx(float(stored["period"]), rel=1e-14)
    size = max(abs(orbit.X))
    for value, text in zip(orbit.X, stored["coordinates"].values(), strict=True):
        assert value == pytest.approx(float(text), abs=1e-12 * size)
    told = refine(orbit, 40)
    with mpmath.workdps(50):
        for name_of, text in stored["coordinates"].items():
            assert abs(mpmath.mpf(told.coordinates[name_of]) - mpmath.mpf(text)) < mpmath.mpf("1e-38") * size
    exact = [complex(float(re), float(im)) for re, im in stored["multipliers"]]
    np.testing.assert_allclose(orbit.multipliers, exact, rtol=0, atol=1e-11)


# Orbits of shipped cases beside numbers that programs which share nothing with vibsim came to. Each was
# written from the equations of its scene alone. Flights under a constant and a sinusoidal force have a closed
# form, whose zeros Brent's method found; springs went through scipy's DOP853 (rtol 1e-13) from event to
# event. Multipliers are eigenvalues of central differences of the return map.


DIFFERENCED = 1e-7  # of a multiplier: rounding 1e-16 over steps of 1e-5 to 1e-7, and its spread over these


@cache
def of_gallery(case):
    return orbit(f"gallery/{case}")


def test_drift_of_an_oscillator_that_chatters_to_rest():
    """Closed form of each flight and slide; blows until they part with less than 1e-9 m/s: 15 of the 29.

    The ground's friction stops both bodies while they touch. Rest wipes out all but one multiplier.
    """
    drifting = of_gallery("drifting-oscillator")
    kinds = [kind for kind, _ in drifting.events]
    assert kinds[-4:] == ["chatter", "rest_begin", "stick_begin", "rest_end"]
    assert drifting.drift["slider"] == pytest.approx(0.03965442606858631, rel=1e-14)
    largest, *others = sorted(drifting.multipliers, key=abs, reverse=True)
    assert largest == pytest.approx(-0.51261714, abs=DIFFERENCED)
    assert others == [0, 0]


def test_dry_friction_with_reversals():
    """A body on a spring and dry friction that turns round without a stick, at 0.9 rad/s."""
    sliding = of_gallery("friction-oscillator")
    assert sliding.stable and sliding.spelled == "rr"
    np.testing.assert_allclose(np.abs(sliding.end.carried.states[:, 0]), 2.42023635057437, rtol=1e-14)
    multipliers = sorted(mu.real for mu in sliding.multipliers)
    assert multipliers == pytest.approx([0.08723319, 0.56936554], abs=DIFFERENCED)


def test_stick_slip_on_a_belt_with_stribeck_friction():
    """From the onset of slip, where the spring and the damper pull mu_s N, to the belt's speed, and the stick
    that leads back to it. Slip and stick last 5.8108208155 s and 0.5054855424 s.

    The integrator began 1e-12 m/s slower than the belt: a time of 1e-12 s is what it is good for.
    """
    cycle = of_gallery("belt-oscillator")
    assert cycle.period == pytest.approx(6.3163063578909, abs=2e-12)
    assert cycle.state["x_block"] == pytest.approx(-0.952825783, abs=1e-9)  # printed to so many digits
    assert list(cycle.multipliers) == [0]  # the onset of slip has one place

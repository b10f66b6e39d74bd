"""Orbits that are hard by name, against closed forms and laws."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

import vibsim
from tests.engine.runs import scene_of
from vibsim.cases import load_case
from vibsim.command_line.commands.orbit import stability_text
from vibsim.orbits import find_orbit
from vibsim.orbits.stability import neighbours


def rubbing(ratio, friction, force=1.0):
    """x'' + x = force sin(ratio t) - friction sgn x'."""
    return scene_of(f"""
bodies: {{m: 1 kg}}
links: {{spring: {{between: [m, ground], k: 1 N/m}}}}
friction: {{floor: {{between: [m, ground], N: {friction} N, mu: 1}}}}
forces: {{drive: {{on: m, A: {force} N, omega: {ratio} rad/s}}}}
""")


def reversal_factors(of, orbit):
    """(|S| - N) / (|S| + N) at each reversal, S the force that would have to be held there."""
    carried, N = orbit.end.carried, of.frictions[0].forward
    (term,) = of.forces[0].terms
    forces = term.amplitude * np.sin(term.omega * carried.times + term.phase) - carried.states[:, 0]
    return (np.abs(forces) - N) / (np.abs(forces) + N)


@pytest.mark.parametrize("x", [-0.1, -0.05, 0.0, 0.025])
def test_a_family_of_orbits_under_dry_friction(x):
    """At half the natural frequency, without damping, non-sticking orbits form a family (Csernak and Stepan
    2006; Csernak, Stepan and Shaw 2007): in half a period the free vibration returns to where it was. So one
    multiplier is exactly 1, and no fold; the other is the product of what the reversals do.
    """
    of = rubbing(0.5, 0.1)
    orbit = find_orbit(of, {"x_m": x, "v_m": 0.6667}, 1)
    assert orbit.spelled == "rr" and orbit.n == 1
    one, other = orbit.multipliers
    assert abs(one - 1) < 1e-13 and abs(other - np.prod(reversal_factors(of, orbit))) < 1e-13
    assert orbit.X[1] == pytest.approx(2 / 3, abs=1e-12)  # 1 / (1 - 1/4) of the force, at its rate 1/2
    assert [near.kind for near in neighbours(orbit)] == ["family"]
    assert not orbit.stable and "undecided by first order: 1 multiplier on" in stability_text(orbit)


@pytest.mark.parametrize("ratio", [0.6, 0.7, 1.3])
def test_den_hartogs_motion_without_stops(ratio):
    """Amplitude x = sqrt(V^2 - (f U)^2) (Den Hartog 1930), and the determinant of the matrix."""
    friction, V = 0.15, 1 / (1 - ratio**2)
    of = rubbing(ratio, friction)
    orbit = find_orbit(of, {"x_m": 0.0, "v_m": ratio * V}, 1)
    assert orbit.spelled == "rr"
    x = sqrt(V**2 - (friction * sin(pi / ratio) / (ratio * (1 + cos(pi / ratio)))) ** 2)
    np.testing.assert_allclose(np.sort(orbit.end.carried.states[:, 0]), [-x, x], rtol=1e-12)
    product = np.prod(reversal_factors(of, orbit))
    assert np.linalg.det(orbit.end.derivative) == pytest.approx(product, rel=1e-12)


def test_a_stick_arc_across_the_section():
    """Wherever the phase of the section cuts the orbit of the capsule, multipliers and word are the same; at
    its own phase the capsule sticks there, to the bit.
    """
    case = load_case("gallery/drifting-capsule")
    first = vibsim.orbit(case)
    assert first.X[2] == 0.0 and first.multipliers[-1] == 0
    starts = set()
    for phase in (40, 110, 200, 300):
        moved = {"push.phase": f"{phase} deg", "reaction.phase": f"{180 + phase} deg"}
        other = vibsim.orbit(case, moved)
        assert other.word == first.word and other.multipliers[-1] == 0
        np.testing.assert_allclose(other.multipliers, first.multipliers, rtol=0, atol=1e-11)
        assert other.drift["capsule"] == pytest.approx(first.drift["capsule"], rel=1e-10)
        starts.add(other.X[2] == 0.0)
    assert starts == {True, False}


def bilinear(amplitude, more=""):
    return scene_of(f"""
bodies: {{m: 1 kg}}
links: {{spring: {{between: [m, ground], k: 1 N/m, c: 0.1 N s/m}}}}
stops: {{wall: {{between: [m, ground], gap: 0 m, acts: compression, k: 8 N/m}}}}
forces: {{drive: {{on: m, A: {amplitude} N, omega: 0.35 Hz}}}}
{more}""")


def test_a_bilinear_oscillator_without_a_gap():
    """It has no length of its own: orbits grow with the force, multipliers do not; their product is
    exp(-c T), since contact begins and ends without a jump.
    """
    small = find_orbit(bilinear(1.0), {"x_m": 0.1, "v_m": 0.1}, 1)
    large = find_orbit(bilinear(64.0), {"x_m": 6.0, "v_m": 7.0}, 1)
    np.testing.assert_allclose(large.X, 64 * small.X, rtol=1e-13)
    np.testing.assert_allclose(large.multipliers, small.multipliers, rtol=0, atol=1e-13)
    for orbit in (small, large):
        assert np.prod(orbit.multipliers).real == pytest.approx(np.exp(-0.1 / 0.35), rel=1e-13)


def test_two_masses_obey_liouville_through_impacts():
    """The paper's machine without friction: exp(-c T (1/m1 + 1/m2)) is the product."""
    orbit = vibsim.orbit("I-C", {"friction": "none", "coupling.c": "0.5 N s/m", "run.t_end": "60 s"})
    rate = 0.5 * (1 / 0.297 + 1 / 2.94)
    assert np.prod(orbit.multipliers).real == pytest.approx(np.exp(-rate * orbit.period), rel=1e-12)
    assert max(orbit.multipliers.real) == pytest.approx(1.0, abs=1e-12)  # a steady speed of both


def test_eighteen_periods():
    """I-B: divisors of 18 are tried, and none of them is an orbit."""
    orbit = vibsim.orbit("I-B", period=36)
    assert orbit.n == 18 and orbit.stable and len(orbit.points) == 18


def test_limits_that_are_watched_stop_no_orbit():
    limit = "clearances: {room: {between: [m, ground], distance: 1 mm}}\nrun: {on_violation: stop}"
    of, watched = bilinear(1.0), bilinear(1.0, limit)
    orbit = find_orbit(watched, {"x_m": 0.1, "v_m": 0.1}, 1)
    assert orbit.spelled == find_orbit(of, {"x_m": 0.1, "v_m": 0.1}, 1).spelled


@pytest.mark.parametrize(("k", "least"), [(1000, 25), (10000, 75)])
def test_large_multipliers(k, least):
    """A soft impact on a stiff wall: an orbit that runs leave by a factor of 29, or 79, in each period; from
    starts on all sides of it the same one, its multipliers multiply to exp(-c T / m).
    """
    changes = {"stops.wall.k": f"{k} N/m", "forces.drive.A": "0.362 N"}
    starts = [{"x_mass": x, "v_mass": v} for x, v in ((1.0, 0.1), (1.0, 0.02), (0.95, 0.3))]
    orbits = [vibsim.orbit("gallery/bilinear-oscillator", changes, start=start, period=1) for start in starts]
    for orbit in orbits:
        assert abs(orbit.multipliers[0]) > least and orbit.residual <= orbit.solution.tolerance
        assert np.prod(orbit.multipliers).real == pytest.approx(np.exp(-0.02 * orbit.period), rel=1e-11)
        np.testing.assert_allclose(orbit.X, orbits[0].X, rtol=0, atol=1e-13)


def test_an_orbit_that_chatters_forgets_everything():
    """Behind an infinite sequence of impacts the body rests, whatever its start: multipliers of 0."""
    orbit = vibsim.orbit("gallery/chattering-oscillator", {"run.t_end": "60 s"})
    assert orbit.n == 1 and orbit.multipliers.tolist() == [0, 0] and orbit.stable
    assert {"chatter", "rest_begin", "rest_end"} <= {kind for kind, _ in orbit.events}


def test_the_least_period_of_ten_thousand():
    """Times of 80,000 s have a rounding in which the motion goes on by more than that of its state."""
    assert vibsim.orbit("gallery/bilinear-oscillator", period=10_000).n == 2

"""What has no orbit, or one without a derivative, is told in clear words."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from tests.command_line.made import call, refused, told
from vibsim.cases import UnknownKeyError, load_case
from vibsim.command_line.commands.orbit import _turns
from vibsim.orbits import ReturnMap, find_orbit
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.plan import BranchError
from vibsim.orbits.coordinates import NotConverged, OrbitError
from vibsim.orbits.newton import growing
from vibsim.orbits.search import orbit

DRIVEN = """
name: driven
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1 N/m, c: 0.1 N s/m}}
forces:
  one: {on: m, A: 1 N, omega: 1.3 rad/s}
run: {t_end: 200 s, every: 0.5 s}
"""
TWO = (
    "  two: {on: m, A: 0.5 N, omega: 1.838477631085024 rad/s}\nrun"  # sqrt(2) of the other, but for rounding
)
MOTOR = "motor: {on: m, m3: 0.1 kg, e: 50 mm, J: 0.001 kg m^2, M0: 0.1 N m, Omega0: 0.7 Hz}\nrun"


@pytest.mark.parametrize("command", ["orbit", "continue"])
@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (TWO, "the frequencies of forces and base have no common period"),
        (MOTOR, "a motor whose speed is free and a force or base of its own frequency have no common period"),
    ],
)
def test_scenes_without_a_period(command, changed, message, tmp_path):
    (tmp_path / "driven.yaml").write_text(DRIVEN.replace("run", changed))
    range_of = ["--param", "spring.k=0.9:1.1"] if command == "continue" else []
    assert message in refused(command, tmp_path / "driven.yaml", *range_of)


def test_a_scene_that_drifts(tmp_path):
    """The orbit of a capsule that moves on is one up to a drift, which is told."""
    shown = told("orbit", "gallery/drifting-capsule", "-o", tmp_path / "capsule.h5")
    assert "drift" in shown and "per period" in shown
    both = "forces.push.A=forces.reaction.A=0.49:0.51N"
    branch = told("continue", tmp_path / "capsule.h5", "--param", both, "-o", tmp_path / "b.h5")
    assert "holds everywhere" in branch


RESTING = """
name: grazing
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1 N/m, c: 0.1 N s/m}}
stops: {wall: {between: [m, ground], gap: 1 m, acts: compression, law: rigid, e: 0.8}}
forces: {drive: {on: m, A: 0.1 N, omega: 1 rad/s, phase: 90 deg}}
initial: {m: {v: 1 m/s}}
run: {t_end: 100 s, every: 0.5 s}
"""


def test_an_orbit_that_grazes_a_rigid_stop():
    """At A = 0.1 N the motion x = sin t just reaches the stop. From it there is no derivative, which is told;
    from in front of it Newton's method finds it, without the touch.
    """
    case = load_case(RESTING)
    with pytest.raises(NotConverged, match=r"has no derivative: at 1\.5708 s it grazes a rigid stop"):
        find_orbit(case.scene(), {"x_m": 0.0, "v_m": 1.0}, 1)
    orbit = find_orbit(case.scene(), {"x_m": 0.0, "v_m": 1.0 - 1e-6}, 1)
    assert orbit.spelled == "" and orbit.X.tolist() == pytest.approx([0.0, 1.0], abs=1e-13)
    assert 0 <= orbit.margin < 1e-12


@pytest.mark.slow
def test_chatter_in_many_digits_is_told_briefly():
    done = call("orbit", "gallery/chattering-oscillator", "--digits", "20")
    assert done.exit_code != 0 and "impacts" in done.stderr and len(done.stderr) < 400


TWO_ON_A_BELT = """
name: two-on-a-belt
bodies: {a: 1 kg, b: 1 kg}
links:
  to_a: {between: [a, ground], k: 1 N/m}
  to_b: {between: [b, ground], k: 1 N/m}
  across: {between: [a, b], k: 1.2 N/m}
friction:
  fa: {between: [a, ground], law: stribeck hyperbolic, N: 1 N, mu_s: 1, mu_d: 0.1, d: 3 s/m, belt: 99.5mm/s}
  f2: {between: [b, ground], law: stribeck hyperbolic, N: 1.3 N, mu_s: 1, mu_d: 0.1, d: 3 s/m, belt: 99.5mm/s}
initial: {a: {x: 0.3 m}, b: {x: -0.2 m}}
run: {t_end: 60 s, every: 0.1 s}
"""


STRING = """
name: string
bodies: {top: 2 kg, bit: 0.3 kg}
links: {s: {between: [top, bit], k: 12 N/m}, drive: {between: [top, ground], c: 4 N s/m}}
friction: {f: {between: [bit, ground], N: 3 N, mu: 0.3, static: 1.5}}
forces: {torque: {on: top, F0: 1.8 N}}
run: {t_end: 40 s, every: 0.1 s}
"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        # Galvanetto's blocks: at the end of a trial of Newton's method the first sticks
        (TWO_ON_A_BELT, "the run does not come near itself"),
        # the top of a drill string is turned on for good while its bit sticks and slips
        (STRING, "found where top turns round; on this run it comes to rest"),
    ],
)
def test_a_motion_that_comes_to_no_orbit(text, message, tmp_path):
    (tmp_path / "case.yaml").write_text(text)
    assert message in refused("orbit", tmp_path / "case.yaml", code=4)


def test_what_nothing_feeds_comes_to_rest():
    said = refused("orbit", "gallery/two-balls-and-a-spring", code=4)
    assert "nothing feeds this scene, which comes to rest in the end" in said


BESIDE_A_WALL = """
name: beside-a-wall
bodies: {hammer: 100 g, capsule: 500 g}
links:
  spring: {between: [hammer, capsule], k: 100 N/m, c: 0.1 N s/m}
stops:
  anvil: {between: [hammer, capsule], gap: 2 mm, acts: compression, k: 5 kN/m}
  wall: {between: [capsule, ground], gap: 5 mm, acts: extension, k: 5 kN/m}
friction:
  floor: {between: [capsule, ground], N: 5.886 N, mu: 0.1}
forces:
  push: {on: hammer, A: 0.5 N, omega: 5 Hz}
  reaction: {on: capsule, A: 0.5 N, omega: 5 Hz, phase: 180 deg}
run: {t_end: 20 s, every: 1 ms}
"""


def test_a_body_that_drifts_away_from_what_could_hold_it():
    """A stop makes its place one that matters; without it there is an orbit up to the drift told."""
    with pytest.raises(OrbitError) as error:
        orbit(BESIDE_A_WALL)
    drift = float(re.search(r"in each period it changes x_capsule by (\S+) m;", str(error.value))[1])
    assert "it drifts away from the stop wall; leave it out" in str(error.value)
    free = orbit(BESIDE_A_WALL, {"wall": "none"})
    assert free.drift["capsule"] == pytest.approx(drift, rel=1e-3)


def test_a_body_that_is_blown_away_speeds_up():
    """1 kg under a mean force of -2 N gains -1 m/s in each half second."""
    with pytest.raises(OrbitError, match="in each period it changes v_mass by -1 m/s; it speeds up for ever"):
        orbit("gallery/drifting-oscillator", {"drive.F0": "-2 N"})


def test_what_settles_grows_not():
    """A slow spiral, and a chaotic course, whose ends lie apart."""
    return_map = ReturnMap(load_case("II-B").scene(), 1)
    rng, periods = np.random.default_rng(3), np.arange(256)[:, None]
    at, m = return_map.coordinates, return_map.coordinates.count
    assert growing(np.exp(-0.01 * periods) * np.ones(m), at) is None
    assert growing(rng.normal(size=(256, m)).cumsum(axis=0), at) is None
    assert "it changes" in growing(1.0 + 1e-3 * periods * np.ones(m), at)


@pytest.mark.parametrize(
    ("key", "span", "message"),
    [
        ("excitation.Omega0", "7:8 Hz", "the orbit is at excitation.Omega0 = 5.5 Hz, outside the range 7:8"),
        ("excitation.Omega0", "5:5 Hz", "the range 5:5 is empty"),
        ("run.t_end", "1:50 s", "no orbit depends on run.t_end"),
        ("mu", "-1:1", "friction.mu must be >= 0, got -1"),
        ("excitation.omega", "1:5 Hz", "excitation.omega is no number of case II-B"),
    ],
)
def test_what_cannot_be_followed_is_told_before_an_orbit_is_looked_for(key, span, message, monkeypatch):
    def looked_for(*_, **__):
        raise AssertionError("an orbit is looked for")

    monkeypatch.setattr("vibsim.orbits.search.orbit", looked_for)
    with pytest.raises((BranchError, UnknownKeyError), match=re.escape(message)):
        continue_branch("II-B", key, span)
    assert message in refused("continue", "II-B", "--param", f"{key}={span}")


def test_whole_turns_of_an_orbit_have_a_body_and_a_direction():
    """What the command printed as "-1 turns of x_rod"."""
    bodies = [SimpleNamespace(name="rod", columns=("x_rod", "v_rod"))]
    for turns, words in ((-1, "rod 1 turn backwards per period"), (2, "rod 2 turns forwards per period")):
        orbit = SimpleNamespace(scene=SimpleNamespace(bodies=bodies), turns={"x_rod": turns})
        assert _turns(orbit) == [("turns", words)]

"""A multiplier that is exactly 1 because orbits come in families: no fold is told of."""

import math

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call
from vibsim.cases import load_case
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.continuing import continue_branch

STUCK = """
name: family
bodies: {m: 1 kg, b: 1 kg}
links:
  spring: {between: [m, ground], k: 1 N/m, c: 0.1 N s/m}
  weak: {between: [b, ground], k: 0.5 N/m}
  tie: {between: [m, b], k: 0.1 N/m}
friction: {rub: {between: [b, ground], mu: 0.8}}
forces: {drive: {on: m, A: 1 N, omega: 1.3 rad/s}}
initial: {b: {x: 0.2 m}}
run: {t_end: 400 s, every: 0.5 s}
"""


def test_a_body_that_sticks_anywhere():
    """Body b sticks on its friction, anywhere within a band: at each amplitude orbits are a family."""
    branch = continue_branch(load_case(STUCK), "A", "0.5:2 N")
    assert branch.specials == [] and branch.ends == ("end of the range", "end of the range")
    assert np.abs(branch["multipliers"] - 1).min(axis=1).max() < 1e-12
    assert (branch["v_b"] == 0).all() and branch["residual"].max() < 1e-12


RUBBING = """
name: rubbing
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1 N/m}}
friction: {floor: {between: [m, ground], N: 0.1 N, mu: 1}}
forces: {drive: {on: m, A: 1 N, omega: 0.5 rad/s}}
run: {t_end: 400 s, every: 0.5 s}
"""


@pytest.mark.parametrize(("key", "span"), [("A", "0.97:1.5 N"), ("friction.floor.N", "0.05:0.104 N")])
def test_the_family_of_csernak_stepan_and_shaw(key, span):
    """At half the natural frequency orbits that never stick form a family (Csernak, Stepan and Shaw 2007): in
    half a period the body moves by 2 A / (1 - 1/4), wherever it is. One multiplier is 1 all along, and is no
    fold; nor does its rounding count as a change of the index.
    """
    case = load_case(RUBBING)
    orbit = find_orbit(case.scene(), {"x_m": 0.0, "v_m": 2 / 3}, 1, case=case)
    branch = continue_branch(orbit, key, span)
    assert branch.specials == [] and branch.ends == ("end of the range", "end of the range")
    assert np.abs(branch["multipliers"] - 1).min(axis=1).max() < 1e-12 and set(branch["word"]) == {"rr"}
    force = branch["parameter"] if key == "A" else 1.0
    np.testing.assert_allclose(branch["v_m"], 2 / 3 * force, rtol=1e-12)
    np.testing.assert_allclose(branch["x_m"], 0.0, atol=1e-6)  # the shortest steps keep where it is
    assert not branch["index"].any() and not branch["stable"].any()


def test_a_branch_ends_where_nothing_damps_a_resonance():
    """While the second mass sticks the first swings without damping, at sqrt(2) rad/s: at a third and a fifth
    of it orbits of any such vibration exist, and the branch comes to them. It wandered about among them until
    Python had no more room.
    """
    branch = continue_branch("gallery/two-masses-with-friction", "drive.omega", "0.1:2 rad/s")
    family = "orbits come in a family at this value, in which more than one number is free"
    assert set(branch.ends) == {family}
    ends = branch["parameter"][[0, -1]]
    np.testing.assert_allclose(ends, [np.sqrt(2) / 5, np.sqrt(2) / 3], rtol=1e-11)
    assert [one.kind for one in branch.specials] == ["sticking"] * 4
    assert branch.specials[0].before == branch.specials[-1].after == ()


@pytest.mark.parametrize(
    ("begun", "span"), [("0.956 N", "0.9545:0.956 N"), pytest.param("1 N", "0.9:1 N", marks=pytest.mark.slow)]
)
def test_a_slip_that_comes_up_slowly_is_told_once(begun, span):
    """The second mass begins to slip where k x1 = A / (2 - w^2) reaches the limit of 0.5 N, as a power of
    what is beyond it: 36 places were told between which rounding says whether it slips.
    """
    case = load_case("gallery/two-masses-with-friction", {"drive.A": begun})
    branch = continue_branch(case, "drive.A", span)
    (special,) = branch.specials
    assert special.parameter == pytest.approx(0.5 * (2 - 0.3**2), abs=1e-6)
    assert special.before == () and special.after != () and special.jump == 0 and special.kind == "sticking"


# Where free vibrations shrink to a state of rest: Hopf points, against closed forms.


KEY = "friction.belt.belt"


EXPONENTIAL = "stribeck exponential, N: 1 N, mu_s: 1, mu_d: 0.5, v0: 0.5 m/s"
HYPERBOLIC = "stribeck hyperbolic, N: 1 N, mu_s: 1, mu_d: 0.5, d: 2 s/m"
TEXT = """
bodies: {block: 1 kg}
links: {spring: {between: [block, ground], k: 1 N/m, c: 0.1 N s/m}}
friction: {belt: {between: [block, ground], belt: 1.3 m/s, law: LAW}}
initial: {block: {v: 1.3 m/s}}
run: {t_end: 200 s, every: 10 ms}
"""


def branch(law):
    return vibsim.continue_branch(TEXT.replace("LAW", law), KEY, "0.9:1.9 m/s")


@pytest.mark.parametrize(
    ("law", "speed"),
    [
        # the damping c + N mu'(v_belt) of small vibrations about x = mu(v_belt) N / k is zero there
        (EXPONENTIAL, math.log(10) / 2),
        (HYPERBOLIC, (math.sqrt(10) - 1) / 2),
    ],
)
def test_a_stick_slip_cycle_ends_in_a_state_of_rest(law, speed):
    cycles = branch(law)
    hopf = cycles.specials[-1]
    assert [one.kind for one in cycles.specials] == ["corner", "hopf"]
    assert hopf.label == "HO1" and hopf.parameter == pytest.approx(speed, rel=1e-11)
    assert hopf.period == pytest.approx(2 * math.pi, rel=1e-11)  # sqrt(m / k) of the undamped block
    assert cycles.ends == ("end of the range", "shrinks to a state of rest")
    last = cycles.points[-1].orbit
    assert speed < last.parameter < cycles.special("CO1").parameter and last.index == 1


def test_the_command_goes_on_with_what_ended_there(tmp_path):
    path = tmp_path / "b.h5"
    words = ["continue", "gallery/belt-oscillator", "--param", f"{KEY}=1.1:1.9", "-o", path]
    told = call(*words).stdout
    assert "holds everywhere" in told and "HO1  hopf" in told
    assert "HO1  hopf" in call(*words).stdout  # which has nothing to add
    assert vibsim.open_result(path).specials[-1].kind == "hopf"
    for suffix in ("png", "html"):
        assert call("plot", path, "-o", tmp_path / f"b.{suffix}").exit_code == 0

"""A multiplier that is exactly 1 because orbits come in families: no fold is told of."""

import numpy as np
import pytest

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


def test_a_body_that_sticks_anywhere(tmp_path):
    """Body b sticks on its friction, anywhere within a band: at each amplitude orbits are a family."""
    (tmp_path / "family.yaml").write_text(STUCK)
    branch = continue_branch(load_case(str(tmp_path / "family.yaml")), "A", "0.5:2 N")
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
def test_the_family_of_csernak_stepan_and_shaw(key, span, tmp_path):
    """At half the natural frequency orbits that never stick form a family (Csernak, Stepan and Shaw 2007): in
    half a period the body moves by 2 A / (1 - 1/4), wherever it is. One multiplier is 1 all along, and is no
    fold; nor does its rounding count as a change of the index.
    """
    (tmp_path / "rubbing.yaml").write_text(RUBBING)
    case = load_case(str(tmp_path / "rubbing.yaml"))
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
    assert set(branch.ends) == {
        "orbits come in a family at this value, in which more than one number is free"
    }
    ends = branch["parameter"][[0, -1]]
    np.testing.assert_allclose(ends, [np.sqrt(2) / 5, np.sqrt(2) / 3], rtol=1e-11)
    assert [one.kind for one in branch.specials] == ["sticking"] * 4
    assert branch.specials[0].before == branch.specials[-1].after == ()


@pytest.mark.parametrize(
    ("begun", "span"),
    [("0.956 N", "0.9545:0.956 N"), pytest.param("1 N", "0.9:1 N", marks=pytest.mark.slow)],
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

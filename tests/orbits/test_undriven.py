"""Orbits of scenes that nothing drives: looked at where a body on a spring turns round."""

from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vibsim
from tests.command_line.made import refused, told
from tests.engine.runs import scene_of
from tests.orbits.truths import landing
from vibsim.cases import load_case
from vibsim.orbits import ReturnMap, find_orbit
from vibsim.orbits.coordinates import NotConverged
from vibsim.orbits.orbit_digits import refine


@pytest.fixture(scope="module")
def cycle():
    return vibsim.orbit("gallery/block-on-belt")


def test_stick_slip_on_a_belt(cycle):
    """V16 (Leine): period, duration of the stick and place of the release by an independent solver."""
    assert cycle.spelled == "su" and cycle.n == 1 and cycle.stable
    assert cycle.period == pytest.approx(12.001031294830, rel=1e-13)
    begin, end = cycle.end.carried.times
    assert end - begin == pytest.approx(7.705031769350, rel=1e-12)
    assert cycle.end.carried.states[1, 0] == pytest.approx(1.0, rel=1e-14)
    assert cycle.multipliers.tolist() == [0]  # the stick forgets; the shift along the orbit is taken out
    assert cycle.state["v_block"] == 0.0


def test_it_is_met_from_beside_it_without_a_time(cycle):
    """The time of return comes from the turns of the body."""
    near = {"x_block": cycle.X[0] * 1.001, "v_block": 0.0}
    again = find_orbit(cycle.scene, near, 1)
    assert again.period == pytest.approx(cycle.period, rel=1e-13) and again.word == cycle.word
    twice = find_orbit(cycle.scene, near, 2)
    assert twice.n == 1 and twice.period == pytest.approx(cycle.period, rel=1e-13)


def test_its_digits(cycle):
    few, many = refine(cycle, 30), refine(cycle, 40)
    assert float(few.period) == pytest.approx(12.001031294830, rel=1e-13)
    assert many.period.startswith(few.period.partition("e")[0][:29])


def test_the_stick_slip_cycle_dies_in_a_corner():
    """V18 (bSTAB's case): the cycle lives up to a belt speed of 1.836600972207926 m/s, where its slip touches
    the belt. There the branch turns back to the unstable cycle that slides all the time, the border of what
    comes to rest; by scipy's DOP853 too x'' + 0.1 x' + x = 0.5 + 0.5 exp(-(belt - x') / 0.5) has it.
    """
    branch = vibsim.continue_branch("gallery/belt-oscillator", "belt.belt", "1.45:1.9 m/s")
    assert branch.ends == ("end of the range", "end of the range")
    (corner,) = branch.specials
    assert (corner.label, corner.kind, corner.jump) == ("CO1", "corner", 1)
    assert corner.parameter == pytest.approx(1.836600972207926, rel=1e-11)
    assert branch.spelled(corner.before) == "su" and branch.spelled(corner.after) == ""
    assert branch["parameter"].max() < corner.parameter * (1 + 1e-12) and branch["residual"].max() < 1e-12
    slides = branch["word"] == ""
    assert branch["stable"].tolist() == (~slides).tolist() and slides.sum() > 8
    belt, x, T = (branch[name][-1] for name in ("parameter", "x_block", "period"))

    def rates(t, y):
        return y[1], 0.5 + 0.5 * np.exp((y[1] - belt) / 0.5) - y[0] - 0.1 * y[1]

    end = solve_ivp(rates, (0, T), (x, 0.0), method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    assert belt == pytest.approx(1.45, rel=1e-15) and np.abs(end - (x, 0.0)).max() < 1e-10


@pytest.mark.slow
def test_the_corner_from_the_other_side():
    """From the unstable cycle, which slides, up to the touch and back along the stable one, which sticks."""
    case = load_case("gallery/belt-oscillator", {"friction.belt.belt": "1.752241325203216 m/s"})
    sliding = find_orbit(case.scene(), {"x_block": -1.0736665, "v_block": 0.0}, 1, case=case)
    assert sliding.spelled == "" and not sliding.stable
    branch = vibsim.continue_branch(sliding, "belt.belt", "1.75:1.9 m/s")
    (corner,) = branch.specials
    assert corner.parameter == pytest.approx(1.836600972207926, rel=1e-11) and corner.jump == -1
    assert set(branch["word"][branch["stable"]]) == {"su"} and branch["stable"][-1]
    assert branch["residual"].max() < 1e-12


BILINEAR = """
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1 N/m}}
stops: {wall: {between: [m, ground], gap: 0 m, acts: compression, k: 8 N/m}}
friction: {floor: {between: [m, ground], N: 0.1 N, mu: 0}}
run: {t_end: 30 s}
"""


def test_a_free_oscillator_belongs_to_a_family():
    """Without a loss every swing of a bilinear oscillator without a gap takes pi (1 + 1/3); the multiplier of
    its energy is 1.
    """
    orbit = find_orbit(scene_of(BILINEAR), {"x_m": -0.5, "v_m": 0.0}, 1)
    assert orbit.period == pytest.approx(pi * 4 / 3, rel=1e-13) and orbit.spelled in ("be", "eb")
    assert abs(orbit.multipliers[0] - 1) < 1e-12 and not orbit.stable
    assert orbit.X[0] == pytest.approx(-0.5, rel=1e-12)


def test_a_slope_of_the_section():
    """P' = M - f m_p / f_p, by difference quotients: a block on a falling friction that never sticks."""
    case = vibsim.load_case("gallery/belt-oscillator")
    return_map = ReturnMap(case.scene())
    X, h = np.array([-0.4]), 1e-6
    T = return_map.time_of_return(X)
    ends = [landing(return_map, X + step, T) for step in (h, -h)]
    for _ in range(5):
        end = return_map(X, T)
        T -= end.ahead / end.tilt[1]
    assert (ends[0] - ends[1])[0] / (2 * h) == pytest.approx(end.derivative[0, 0], abs=1e-7)


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (
            ["gallery/belt-oscillator", "-s", "block.v=0"],
            4,
            "nothing swings: Newton's method came to a state",
        ),
        (["gallery/bouncing-ball"], 2, "or a spring that brings a body back; the scene has neither"),
        (["gallery/three-balls"], 2, "an orbit needs a periodic source"),
    ],
)
def test_what_has_none(words, code, message):
    assert message in refused("orbit", *words, code=code)


def test_a_run_that_comes_to_rest():
    """A block that rubs itself to rest turns round no more."""
    of = scene_of(BILINEAR, {"gap": "10 cm", "mu": 1})
    with pytest.raises(vibsim.OrbitError, match=r"does not turn round|turns round|nothing swings"):
        find_orbit(of, {"x_m": 0.05, "v_m": 0.0}, 1)


def test_the_command(tmp_path):
    """Stored, told of, gone on from, drawn."""
    path, branch = tmp_path / "cycle.h5", tmp_path / "branch.h5"
    shown = told("orbit", "gallery/block-on-belt", "-o", path)
    assert "1 swing of block" in shown and "v_block = 0, at the least displacement of block" in shown
    followed = told("continue", path, "--param", "belt.belt=0.19:0.21", "-o", branch)
    assert "orbits of 1 swing over friction.belt.belt" in followed and "holds everywhere" in followed
    told("plot", branch, "-o", tmp_path / "branch.png")
    told("run", path, "--t-end", "30s", "-o", tmp_path / "on.h5")


TRIPLE = """
name: triple
bodies: {a: 1 kg, b: 0.63 kg, c: 0.86 kg}
links:
  held: {between: [a, ground], k: 1 N/m}
  one: {between: [a, b], k: 2.5 N/m}
  two: {between: [b, c], k: 1.96 N/m}
initial: {a: {x: 0.1 m}}
run: {t_end: 40 s, every: 0.5 s}
"""


def test_a_search_that_comes_to_rest_says_no_more_than_that():
    """From beside a mode Newton's method may shrink to the rest, whose rates no derivative is divided by."""
    case = vibsim.load_case(TRIPLE)
    stiffness = np.array([[3.5, -2.5, 0], [-2.5, 4.46, -1.96], [0, -1.96, 1.96]])
    masses = np.array([1, 0.63, 0.86])
    _, shapes = np.linalg.eigh(stiffness / np.sqrt(np.outer(masses, masses)))
    mode = shapes[:, 1] / np.sqrt(masses)
    mode *= -0.945 / mode[2]
    start = {f"x_{name}": x for name, x in zip("abc", mode, strict=True)} | {"v_a": 0, "v_b": 0, "v_c": 0}
    with pytest.raises(NotConverged, match="no orbit of 1 period near"):
        vibsim.orbit(case, start=start)

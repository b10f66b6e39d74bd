"""Where free vibrations shrink to a state of rest: Hopf points, against closed forms."""

import math

import pytest

import vibsim
from tests.command_line.made import call

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


def branch(law, folder):
    path = folder / "belt.yaml"
    path.write_text(TEXT.replace("LAW", law))
    return vibsim.continue_branch(path, KEY, "0.9:1.9 m/s")


@pytest.mark.parametrize(
    ("law", "speed"),
    [
        # the damping c + N mu'(v_belt) of small vibrations about x = mu(v_belt) N / k is zero there
        (EXPONENTIAL, math.log(10) / 2),
        (HYPERBOLIC, (math.sqrt(10) - 1) / 2),
    ],
)
def test_a_stick_slip_cycle_ends_in_a_state_of_rest(law, speed, tmp_path):
    cycles = branch(law, tmp_path)
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
    assert call("plot", path, "-o", tmp_path / "b.png").exit_code == 0
    assert call("plot", path, "-o", tmp_path / "b.html").exit_code == 0

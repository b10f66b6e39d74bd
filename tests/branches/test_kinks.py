"""A branch has a kink where a sliding velocity comes to touch zero; it goes on behind it."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import vibsim
from vibsim.cases import load_case
from vibsim.orbits import find_orbit

BELT = 0.7235  # [m/s]
SCENE = """
name: kink
bodies: {a: 0.8132 kg, b: 1.509 kg}
links:
  l0: {between: [a, ground], k: 50.56 N/m, c: 0.1555 N s/m}
  l1: {between: [b, a], k: 26.11 N/m, c: 0.3471 N s/m}
stops:
  s0: {between: [b, a], gap: 0.1566 m, acts: extension, k: 559.9 N/m, c: 0.3112 N s/m, release: force}
  s1: {between: [b, ground], gap: -0.04324 m, acts: extension, k: 1264 N/m, c: 1.786 N s/m, release: force}
friction:
  f0: {between: [b, ground], N: 1.24 N, belt: 0.7235 m/s, law: stribeck exponential, mu_s: 0.6452,
    mu_d: 0.2708, v0: 0.7119 m/s}
forces: {p: {on: a, A: 12.3 N, omega: 0.8499 Hz, phase: 46.16 deg}}
run: {t_end: 60 s, every: 20 ms}
"""
STATE = {"x_a": 0.1287625, "v_a": 5.7147503, "x_b": 0.4531174, "v_b": 0.8672522}


@pytest.fixture(scope="module")
def branch(tmp_path_factory):
    path = tmp_path_factory.mktemp("kink") / "kink.yaml"
    path.write_text(SCENE)
    case = load_case(str(path))
    return vibsim.continue_branch(
        find_orbit(case.scene(), STATE, 1, case=case), "bodies.a", "0.813:0.8133 kg"
    )


def test_it_goes_on_behind_a_kink(branch):
    """The tangent turns by 0.45 there: steps across it were refused as too sharp, until none was left."""
    assert dict(branch.lines())["ends"] == "end of the range"
    assert dict(branch.lines())["index check"] == "holds everywhere"
    assert branch["parameter"][-1] == pytest.approx(0.8133, rel=1e-15)
    (stick,) = branch.specials
    assert stick.kind == "sticking" and len(stick.after) == len(stick.before) + 2


def test_there_a_sliding_velocity_touches_zero(branch):
    """On the orbit at the special point, by its least distance from the speed of the belt."""
    (stick,) = branch.specials
    state = dict(zip(branch.names, stick.orbit.state, strict=True))
    case = branch.case.with_values({"bodies.a": f"{stick.parameter!r} kg"})
    run = vibsim.simulate(
        case.with_values(
            {
                f"initial.{name[2:]}.{name[0]}": f"{value!r} {'m' if name[0] == 'x' else 'm/s'}"
                for name, value in state.items()
            }
        )
    )
    times = np.linspace(0.04, 0.08, 9)  # [s]
    at = min(times, key=lambda t: abs(run.at(t)["v_b"] - BELT))
    least = minimize_scalar(
        lambda t: run.at(t)["v_b"] - BELT,
        bounds=(at - 0.01, at + 0.01),
        method="bounded",
        options={"xatol": 1e-9},
    )
    assert abs(least.fun) < 1e-8

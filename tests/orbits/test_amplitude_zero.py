"""Derivatives by the amplitude of a base that rests: those of a base that is about to move."""

import numpy as np
import pytest

import vibsim
from vibsim.cases import load_case
from vibsim.engine.modes.parametric_rows import differences
from vibsim.orbits.coordinates import OrbitError

CASE = """
bodies: {block: 1 kg}
links: {spring: {between: [block, base], k: 40 N/m, c: 0.2 N s/m}}
stops: {wall: {between: [block, base], gap: 5 mm, acts: compression, k: 2 kN/m}}
friction: {floor: {between: [block, ground], N: 0.12 N, mu: 1}%s}
forces: {drive: {on: block, A: 0.3 N, omega: 0.8 Hz}}
base: {a: 0 m, omega: 1.3 Hz, phase: 30 deg}
run: {t_end: 3 s}
"""
START, END = {"x_block": 0.004, "v_block": 0.05}, 3.0


@pytest.fixture
def case(tmp_path):
    def load(friction=""):
        path = tmp_path / "case.yaml"
        path.write_text(CASE % friction)
        return load_case(path)

    return load


def test_derivative_by_an_amplitude_of_zero(case):
    """Against motions with small amplitudes; what their quotient leaves out is of the second order."""
    still = case()
    derivative = vibsim.monodromy(still, state=START, T=END, parameters=["base.a"])
    assert {"contact_begin", "stick_begin", "stick_end"} <= {kind for kind, _ in derivative.events}

    def quotient(amplitude):
        moving = vibsim.monodromy(still.replace({"base.a": f"{amplitude} m"}), state=START, T=END)
        return np.array([moving.state[name] - derivative.state[name] for name in START]) / amplitude

    limit = 2 * quotient(1e-9) - quotient(2e-9)
    slope = np.asarray(derivative.by_parameter["base.a"])
    assert np.abs(slope - limit).max() < 1e-5 * np.abs(slope).max()


def test_body_that_holds_on_to_ground_and_base_has_none(case):
    with pytest.raises(OrbitError, match=r"base\.a is 0, which leaves open how far to change it"):
        vibsim.monodromy(
            case(", grip: {between: [block, base], N: 0.12 N, mu: 1}"),
            state=START,
            T=END,
            parameters=["base.a"],
        )


def test_modes_of_a_base_that_rests_are_not_those_of_one_that_moves(case):
    still = case()
    rests, moves = still.scene(), still.replace({"base.a": "1 mm"}).scene()
    assert differences(rests, moves) is None
    assert differences(moves, rests) is None

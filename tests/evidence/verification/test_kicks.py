"""Kicks have the size of the rounding that they stand for, and spare what is exact."""

from random import Random

import pytest

import vibsim
from vibsim.engine.errors import State
from vibsim.evidence.verification.checks import (
    NUMBERS,
    SCENE_UNITS,
    START,
    STATE_UNITS,
    UNIT,
    kicked_scene,
    kicked_state,
)
from vibsim.evidence.verification.truth_making import TruthPlan, run_digits, states_apart
from vibsim.physics.precision import number_kit


@pytest.fixture
def kit():
    return number_kit(30)


def relative(kit, kicked, value):
    """Size of a kick in units of round-off, with its sign."""
    return float((kicked - value) / (value * kit.number(UNIT)))


@pytest.mark.parametrize("name", ["I-A", "II-B", "hard/contact-lost-as-it-sticks"])
def test_every_number_of_a_scene_is_kicked(kit, name):
    scene = vibsim.load_case(name).exact_two_blocks(kit.number, kit.pi)
    kicked = kicked_scene(scene, kit, Random(1))
    signs = []
    for field in NUMBERS + START:
        value, moved = getattr(scene, field), getattr(kicked, field)
        if value is None or value == 0:
            assert moved is None or moved == 0
        else:
            signs.append(relative(kit, moved, value))
            assert abs(signs[-1]) == pytest.approx(SCENE_UNITS, rel=1e-9)
    assert min(signs) < 0 < max(signs)
    assert (kicked.cycles, kicked.t_end) == (scene.cycles, scene.t_end)


def test_states_are_kicked_by_the_size_of_the_motion(kit):
    t, x1, x2, v1, v2, phase, turns, w = (kit.number(value) for value in (1, 3, 2, -4, 0, 0.5, 7, 9))
    state = State(t, [x1, x2], [v1, v2], phase, turns, w)
    kicked = kicked_state(state, kit, Random(2))
    size = STATE_UNITS * UNIT
    pairs = [*zip(kicked.x, state.x, strict=True), (kicked.v[0], v1), (kicked.phase, phase), (kicked.w, w)]
    for (moved, value), scale in zip(pairs, (3, 3, 4, 1, 9), strict=True):
        assert abs(float(moved - value)) == pytest.approx(scale * size, rel=1e-9)
    assert (kicked.t, kicked.turns, kicked.v[1]) == (t, turns, 0)


def test_stray_is_what_conditioning_says(kit):
    """A block that slides and stops: x2 at rest is v0^2 / (2 mu g), so it strays by 5 numbers of 4 units each
    at most, and by the 16 of the state twice over.
    """
    case = vibsim.load_case(
        "I-A",
        {
            "stop": "none",
            "excitation": "none",
            "coupling.k1": "0 N/m",
            "coupling.c": "0 N s/m",
            "initial.v2": "0.05 m/s",
            "run.t_end": "10 s",
            "run.every": "1 s",
        },
    )
    how = TruthPlan(case, 1)
    truth = run_digits(how, "closed_form", 40)
    way = 0.05**2 / (2 * 0.001 * 9.81)
    assert float(truth.states["x2"][-1]) == pytest.approx(way, rel=1e-15)
    strays = [
        states_apart(truth, [run_digits(how, "closed_form", 30, seed)])["x2"][-1] / (way * UNIT)
        for seed in range(6)
    ]
    assert all(1 < stray <= 5 * SCENE_UNITS + 3 * STATE_UNITS for stray in strays)
    assert len(set(strays)) > 1

"""Bodies between rigid stops without room: they come to rest, or the run says that no motion is possible."""

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.optimize import linprog

from tests.engine.random_parts import rigid_scenes
from tests.engine.runs import run
from vibsim.engine.errors import EngineError
from vibsim.engine.flows.motion import value_and_rate
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import COMPRESSION, EXTENSION, GROUND, Body, RigidStop, Scene

TOUCHING = 1e-12  # m, of depths whose terms are some 0.01 m


def between(bodies, e, other):
    """Stops on both sides between the first body and the second, or the ground."""
    partner = 1 if len(bodies) > 1 else GROUND
    stops = (
        RigidStop("left", 0, partner, 0.0, EXTENSION, e, True),
        RigidStop("right", 0, partner, 0.0, COMPRESSION, other, True),
    )
    return Scene(tuple(bodies), stops=stops, t_end=0.5, every_den=20)


@pytest.mark.parametrize("engine", ["c", "python"])
@pytest.mark.parametrize(("e", "other"), [(0.5, 0.8), (0.8, 0.5), (0.0, 0.8), (0.3, 0.3)])
@pytest.mark.parametrize("v", [1.0, -1.0])
def test_body_without_room_stands(engine, e, other, v):
    """Impacts at one instant take v, e v, e e' v, ... : nothing is left of the speed."""
    result = run(between([Body("m", 2.0, 0.0, v)], e, other), engine, ledger=True, momentum=True)
    assert not result.samples["x_m"].any()
    assert not result.samples["v_m"][1:].any()
    assert result.totals["impulse_ground"] == pytest.approx(-2.0 * v, rel=1e-14)
    assert result.totals["loss_stops"] == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("v", [1.0, -1.0])
def test_bodies_without_room_go_on_together(v):
    bodies = [Body("a", 2.0, 0.0, v), Body("b", 1.0, 0.0, 0.0)]
    result = run(between(bodies, 0.5, 0.8), ledger=True, momentum=True)
    for name in ("v_a", "v_b"):
        assert result.samples[name][1:] == pytest.approx(2 / 3 * v, rel=1e-15)
    assert abs(result.totals["momentum_residual"]) < 1e-15


def is_jammed(scene, state):
    """Whether no velocities of the bodies keep all stops that touch from closing, by linear programming."""
    n = len(scene.bodies)
    X, V = value_and_rate(Doubles, scene.base, state.t)
    places, rates = [*state.x, X, 0.0], {-1: 0.0, -2: V}  # BASE is -2, GROUND -1
    rows, limits = [], []
    for _, stop in scene.rigid_stops:
        if -(stop.sense * (places[stop.P] - places[stop.Q])) - stop.gap > -TOUCHING:
            row, limit = np.zeros(n), 0.0
            for end, sign in ((stop.P, -stop.sense), (stop.Q, stop.sense)):
                if end >= 0:
                    row[end] += sign
                else:
                    limit -= sign * rates[end] / abs(V or 1.0)
            rows.append(row)
            limits.append(limit)
    slack = linprog(
        [0.0] * n + [1.0],
        A_ub=np.hstack([np.array(rows), -np.ones((len(rows), 1))]),
        b_ub=limits,
        bounds=[(None, None)] * n + [(0.0, None)],
    )
    return slack.fun > 1e-9  # shares of the base's speed


def assert_solved_or_jammed(scene):
    try:
        run(scene, "auto", most=2000)
    except EngineError as error:
        assert error.reason == "crushed"
        assert is_jammed(scene, error.state)
        assert sum(stop.name in str(error) for _, stop in scene.rigid_stops) >= 2


@settings(max_examples=40)
@given(rigid_scenes())
def test_errors_are_of_jammed_bodies(scene):
    assert_solved_or_jammed(scene)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=3000)
@given(rigid_scenes())
def test_many_errors_are_of_jammed_bodies(scene):
    assert_solved_or_jammed(scene)

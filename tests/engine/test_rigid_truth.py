"""Runs with rigid stops against the exact flow in 40 digits: none missed, none invented where certified."""

from math import sqrt

import pytest
from hypothesis import given, settings

from tests.engine.impacts import GRAVITY, ball, times
from tests.engine.many_digits import exact_parts, truth
from tests.engine.random_parts import rigid_scenes
from tests.engine.runs import Run, outcome, run
from tests.engine.whole_truth import faults
from vibsim.physics.parts import (
    AT_GAP,
    COMPRESSION,
    EVENT_KINDS,
    EXTENSION,
    GROUND,
    Body,
    Friction,
    Link,
    RigidStop,
    Scene,
    Stop,
)

pytest.importorskip("flint")
IMPACT = EVENT_KINDS["impact"]


@settings(max_examples=12)
@given(rigid_scenes(radians=4.0))
def test_doubles_follow_the_truth(scene):
    doubles = outcome(scene, "auto")
    if not isinstance(doubles, Run) or doubles.totals["uncertified"]:
        return  # rounding may decide, and the run says so
    assert faults(scene, doubles) == []


@pytest.mark.slow
@pytest.mark.timeout(7200)
@settings(max_examples=4000)
@given(rigid_scenes(radians=4.0))
def test_doubles_follow_the_truth_often(scene):
    test_doubles_follow_the_truth.hypothesis.inner_test(scene)


def test_a_ball_comes_to_rest_in_many_digits():
    """After 9 sqrt(2 h / g) at e = 0.8, in as many digits as are asked for; in doubles to their rounding."""
    case = ball(0.8, t_end=5.0)
    _, events, _, totals = truth(exact_parts(case), 40)
    rest = events["t"][events["kind"] == EVENT_KINDS["rest_begin"]]
    assert rest == pytest.approx([sqrt(2 / GRAVITY) * 9], rel=2e-16)
    assert totals["chatter_time"] < 1e-38
    assert abs(times(run(case), "rest_begin")[0] - rest[0]) < 4e-14


def test_bodies_at_rest_on_each_other_meet_the_wall_in_many_digits():
    """They went through it: the friction between bodies that rest on each other has no sliding velocity,
    which was zero only within the radius of a ball; no step is known to be shorter than what that allows.
    """
    a, b = Body("a", 0.75, 0.01, 0.06), Body("b", 0.95, 0.0, 0.0)
    stops = (
        RigidStop("wall", 1, GROUND, 0.001, EXTENSION, 0.5, False),
        Stop("soft", GROUND, 0, 0.0, EXTENSION, 109.0, 0.0, AT_GAP, False),
        RigidStop("between", 1, 0, -0.01, COMPRESSION, 0.5, True),
    )
    links, frictions = (Link("l", 1, 0, 56.6, 0.0),), (Friction("f", 1, 0, 0.27, 0.27, 0.0, 0.27, 0.35),)
    scene = Scene((a, b), links, stops, frictions, t_end=0.12, every_num=1, every_den=200)
    doubles, (samples, events, *_) = outcome(scene, "auto"), truth(exact_parts(scene), 40)
    walls = [
        table["t"][(table["kind"] == IMPACT) & (table["part"] == 0)] for table in (doubles.events, events)
    ]
    assert len(walls[0]) == len(walls[1]) == 1
    assert abs(walls[0] - walls[1]) < 1e-12
    assert samples["x_b"].min() >= -0.001

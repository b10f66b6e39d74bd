"""Random scenes of all parts: a peer that shares no line with the engine comes to the same motion."""

from math import pi, sin

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings

from tests.engine.random_parts import part_scenes, rigid_scenes
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.solvers import EventSolver, TimeLimit
from vibsim.physics.parts import EVENT_NAMES, GROUND, Body, Force, Friction, Harmonic, Scene
from vibsim.results.columns import tables_of

AGREE = 1e-7  # of the largest displacement: rtol 1e-11 over some hundred steps, grown by less than 100
DRAWN = settings(
    max_examples=100,
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)
NOT_UNIQUE = "their forces are not unique"  # which these peers do not split


def assert_same_motion(scene):
    ends = [frozenset((stop.P, stop.Q)) for stop in scene.stops]
    assume(len(set(ends)) == len(ends))  # of two stops that let go at one instant the solver sees one
    rubbing = [frozenset((one.P, one.Q)) for one in scene.frictions]
    holds_more = any(one.drops(sense) for one in scene.frictions for sense in (1, -1))
    # of two frictions between the same ends at rest the solver lets one slip, with less than it would hold
    assume(len(set(rubbing)) == len(rubbing) or not holds_more)
    trajectory = open_trajectory(scene)
    try:
        blocks = list(trajectory.blocks())
    except EngineError:
        assume(False)  # held from both sides while they close
    assume(not trajectory.totals["uncertified"])  # rounding may decide, and the run says so
    columns = tables_of(scene).displacements
    x = np.column_stack([np.concatenate([block.samples[name] for block in blocks]) for name in columns])
    times = np.array([scene.sample_time(i) for i in range(scene.sample_count)])
    assume(len(times) > 1)
    try:
        attempt = EventSolver(scene, "DOP853", 1e-11, looks=True).run(times, TimeLimit())
    except ArithmeticError as error:
        assert str(error).endswith(NOT_UNIQUE)
        assume(False)
    largest = max(float(np.abs(x).max()), 1e-3)
    np.testing.assert_allclose(attempt.states[:, : 2 * x.shape[1] : 2], x, rtol=0, atol=AGREE * largest)


def test_a_slip_between_two_steps_of_a_body_at_rest_is_seen():
    """0.394 sin 6.70 t + 0.087 sin(8.28 t + 0.5) N passes 0.381 N from 0.126 s on: a step of a body that
    rests ends where the force is below that again.
    """
    rates = ((0.3944, 6.7016, 0.0), (0.0865, 8.2829, 0.5))
    force = Force("f", 0, 0.0, tuple(Harmonic(a, w, w / (2 * pi), 0.0, phase) for a, w, phase in rates))
    friction = Friction("on", 0, GROUND, 0.3814, 0.3814, 0.0)
    scene = Scene((Body("m", 1.0, 0.0, 0.0),), forces=(force,), frictions=(friction,), t_end=3.0)
    times = np.linspace(0, 3, 31)
    seen = EventSolver(scene, "DOP853", 1e-11, looks=True).run(times, TimeLimit())
    blind = EventSolver(scene, "DOP853", 1e-11).run(times, TimeLimit())
    t, kind = seen.events[0]
    assert EVENT_NAMES[kind] == "stick_end"
    assert sum(a * sin(w * t + phase) for a, w, phase in rates) == pytest.approx(0.3814, abs=1e-9)
    assert (
        not blind.events or blind.events[0][0] > t + 0.1
    )  # else steps are shorter now, and this shows nothing


@pytest.mark.slow
@DRAWN
@given(part_scenes())
def test_elastic_stops(scene):
    assert_same_motion(scene)


@pytest.mark.slow
@DRAWN
@given(rigid_scenes())
def test_rigid_stops(scene):
    assert_same_motion(scene)

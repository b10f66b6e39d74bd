"""Random scenes of all parts: a peer that shares no line with the engine comes to the same motion."""

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings

from tests.engine.random_parts import part_scenes, rigid_scenes
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.solvers import EventSolver, TimeLimit
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
    trajectory = open_trajectory(scene, "c")
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
        attempt = EventSolver(scene, "DOP853", 1e-11).run(times, TimeLimit())
    except ArithmeticError as error:
        assert str(error).endswith(NOT_UNIQUE)
        assume(False)
    largest = max(float(np.abs(x).max()), 1e-3)
    np.testing.assert_allclose(attempt.states[:, : 2 * x.shape[1] : 2], x, rtol=0, atol=AGREE * largest)


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

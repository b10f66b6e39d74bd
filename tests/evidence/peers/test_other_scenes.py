"""Scenes that lack something or begin in motion: the peers know them as the engine does."""

from importlib.util import find_spec

import numpy as np
import pytest

from tests.scenes import fixed_block, harmonic, motor, scene
from tests.trajectories import run
from vibsim.evidence.peers.solvers import EVERY_KIND, EventlessSolver, EventSolver, TimeLimit
from vibsim.physics.parts import EVENT_KINDS

RUN = {"t_end": 3.0, "every_num": 1, "every_den": 20}
SCENES = {
    "mirrored stop": scene(motor(5.5), stop_sign=-1, phi=1.0, **RUN),
    "no stop": scene(harmonic(3.5, 0.3), k2=None, G=None, **RUN),
    "no friction": scene(harmonic(3.5, 0.3, 0.01), N=None, **RUN),
    "block 2 fixed": fixed_block(harmonic(3.5, 0.5), k2=12400.0, c=0.5, **RUN),
    "motor on a fixed block": fixed_block(motor(3.5), **RUN),
    "no source, begun in contact": scene(x2=2e-3, v2=-0.01, v1=0.3, **RUN),
}
CODES = [EVENT_KINDS[name] for name in EVERY_KIND]


def reference(made):
    """Displacements (n, 2) and kinds of the events by the engine."""
    done = run(made)
    columns = [done.samples[name] for name in ("x1", "x2") if name in done.samples]
    kinds = done.events["kind"]
    return np.column_stack(columns), kinds[np.isin(kinds, CODES)].tolist()


def displaced(attempt, displacements):
    """The columns of displacements in the states of an attempt."""
    return attempt.states[:, : 2 * displacements.shape[1] : 2]


def instants(made):
    return np.array([made.sample_time(i) for i in range(made.sample_count)])


@pytest.mark.parametrize("name", SCENES)
def test_with_events(name):
    displacements, kinds = reference(SCENES[name])
    attempt = EventSolver(SCENES[name].as_parts(), "DOP853", 1e-11).run(instants(SCENES[name]), TimeLimit())
    assert [kind for _, kind in attempt.events] == kinds
    np.testing.assert_allclose(displaced(attempt, displacements), displacements, rtol=0, atol=1e-9)


@pytest.mark.skipif(find_spec("heyoka") is None, reason="needs heyoka")
@pytest.mark.parametrize("name", SCENES)
def test_heyoka(name):
    from vibsim.evidence.peers.heyoka_events import HeyokaEvents

    displacements, kinds = reference(SCENES[name])
    attempt = HeyokaEvents(SCENES[name].as_parts(), 1e-15).run(instants(SCENES[name]), TimeLimit())
    assert [kind for _, kind in attempt.events] == kinds
    np.testing.assert_allclose(displaced(attempt, displacements), displacements, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", SCENES)
def test_without_events(name):
    displacements, _ = reference(SCENES[name])
    attempt = EventlessSolver(SCENES[name].as_parts(), "LSODA", 1e-9, 1e-12, 1e-7).run(
        instants(SCENES[name]), TimeLimit()
    )
    np.testing.assert_allclose(displaced(attempt, displacements), displacements, rtol=0, atol=1e-5)

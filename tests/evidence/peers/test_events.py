"""Peers with events against the truth: every event found, errors as the tolerance has them."""

from importlib.util import find_spec

import numpy as np
import pytest

from tests.evidence.peers.made import error, known
from vibsim.evidence.peers.solvers import EventSolver, TimeLimit

CASES = [("I-A", "8 s"), ("II-B", "8 s")]


def solved(truth, method, rtol):
    return EventSolver(truth.scene, method, rtol).run(truth.times, TimeLimit())


def allowed(truth, attempt, rtol):
    """Bound of the error [m]: every step errs by rtol |state| + atol at most, and all of that grows."""
    size = np.abs(attempt.states[:, :4]).max()
    return attempt.steps * rtol * (size + 1e-3) * truth.growth


@pytest.mark.parametrize(("name", "t_end"), CASES)
@pytest.mark.parametrize(("method", "rtol"), [("DOP853", 1e-11), ("LSODA", 1e-10), ("Radau", 1e-7)])
def test_events_and_errors(name, t_end, method, rtol):
    truth = known(name, t_end)
    attempt = solved(truth, method, rtol)
    assert len(attempt.events) == len(truth.events) > 30
    assert [kind for _, kind in attempt.events] == truth.events[:, 1].tolist()
    assert error(attempt, truth) < allowed(truth, attempt, rtol)
    assert attempt.evaluations > attempt.steps and attempt.t_reached == truth.times[-1]


def test_the_scenes_stick_and_strike():
    assert set(known("I-A", "8 s").events[:, 1]) == {1, 2, 3, 4, 5}
    assert set(known("II-B", "8 s").events[:, 1]) == {1, 2, 3, 5}


def test_errors_fall_with_the_tolerance():
    truth = known("II-B", "8 s")
    errors = [error(solved(truth, "DOP853", rtol), truth) for rtol in (1e-7, 1e-10, 1e-13)]
    assert errors[0] > 30 * errors[1] > 900 * errors[2]


@pytest.mark.skipif(find_spec("heyoka") is None, reason="needs heyoka")
@pytest.mark.parametrize(("name", "t_end"), CASES)
def test_heyoka(name, t_end):
    from vibsim.evidence.peers.heyoka_events import HeyokaEvents

    truth = known(name, t_end)
    peer = HeyokaEvents(truth.scene, 2.0**-52)
    for _ in range(2):  # a second run begins anew
        attempt = peer.run(truth.times, TimeLimit())
        assert [kind for _, kind in attempt.events] == truth.events[:, 1].tolist()
        assert error(attempt, truth) < allowed(truth, attempt, 2.0**-52)

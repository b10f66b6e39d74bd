"""Every peer stops where it is told to, and says how far it came."""

from importlib.util import find_spec

import numpy as np
import pytest

from tests.scenes import paper
from vibsim.evidence.peers.solvers import EventlessSolver, EventSolver, OutOfTime, RungeKutta4, TimeLimit

TIMES = np.linspace(0, 50.0, 1001)
PEERS = {
    "events": lambda made: EventSolver(made, "DOP853", 1e-9),
    "eventless": lambda made: EventlessSolver(made, "RK45", 1e-3, 1e-6),
    "rk4": lambda made: RungeKutta4(made, 1e-3),
}


def looks(count):
    """going_on that says yes `count` times."""
    left = iter([True] * count)
    return lambda: next(left, False)


@pytest.mark.parametrize("name", PEERS)
def test_what_was_computed_is_kept(name):
    peer = PEERS[name](paper("I-C").as_parts())
    whole = peer.run(TIMES[:41], TimeLimit())
    attempt = peer.run(TIMES, TimeLimit(going_on=looks(40)))
    assert attempt.stopped and 0 < attempt.t_reached <= TIMES[-1] / 2
    assert 1 < len(attempt.states) <= np.searchsorted(TIMES, attempt.t_reached, side="right")
    shared = min(len(attempt.states), len(whole.states))
    np.testing.assert_allclose(attempt.states[:shared], whole.states[:shared], rtol=1e-12, atol=1e-14)


@pytest.mark.skipif(find_spec("heyoka") is None, reason="needs heyoka")
def test_heyoka():
    from vibsim.evidence.peers.heyoka_events import PIECE, HeyokaEvents

    attempt = HeyokaEvents(paper("I-C").as_parts(), 1e-9).run(TIMES, TimeLimit(going_on=looks(1)))
    assert attempt.stopped and len(attempt.states) == 2 * PIECE + 1
    assert attempt.t_reached == TIMES[2 * PIECE]


def test_the_clock_counts():
    limit = TimeLimit(0.0)
    with pytest.raises(OutOfTime):
        limit.check()
    TimeLimit(60.0).check()

"""Peers with events against the truth: every event found, errors as the tolerance has them."""

from dataclasses import replace
from importlib.util import find_spec
from math import sin
from types import SimpleNamespace

import numpy as np
import pytest

from tests.evidence.peers.made import error, known
from tests.scenes import paper
from vibsim.cases import load_case
from vibsim.evidence.peers.automaton import Instant, _impulses, consistent_states, impact
from vibsim.evidence.peers.equations import Compiled, start_of
from vibsim.evidence.peers.solvers import EventlessSolver, EventSolver, OutOfTime, RungeKutta4, TimeLimit
from vibsim.physics.parts import COMPRESSION, GROUND, RigidStop

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


# Impacts by the Newton-Moreau law: closed forms, and what it keeps.


def at(scene, state):
    return Instant(Compiled(scene), 0.0, state)


def test_one_ball_meets_two_that_touch():
    instant = at(load_case("gallery/three-balls").scene(), [0.1, 1.0, 0.0, 0.0, 0.0, 0.0])
    impulses = impact(instant, [0, 1], [instant.rate(0), instant.rate(1)])
    assert instant.state[1::2] == pytest.approx([-1 / 3, 2 / 3, 2 / 3], rel=1e-14)
    assert impulses == pytest.approx([4 / 3, 2 / 3], rel=1e-14)


def test_one_stop_turns_the_rate_round():
    instant = at(load_case("gallery/pile-driver").scene(), [1.0, 4.0, 0.0, 1.0])
    before = instant.rate(0)
    impact(instant, [0], [before])
    assert instant.rate(0) == pytest.approx(-0.6 * before, rel=1e-14)
    assert 250 * instant.state[1] + 750 * instant.state[3] == pytest.approx(250 * 4 + 750, rel=1e-14)


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_a_rotor_takes_part_by_its_mass_matrix(e):
    """The impulse acts on the body alone: J' w - m3 e sin(phi) v is kept; at e = 1 the energy is, too."""
    stop = RigidStop("wall", 0, GROUND, 0.0, COMPRESSION, e)
    scene = replace(paper("II-B").as_parts(), stops=(stop,))
    p, phi = scene.motor, 0.7
    inertia, coupling = p.J + p.m3 * p.e**2, p.m3 * p.e * sin(phi)
    instant = at(scene, [0.0, 2.0, 0.1, -1.0, phi, 30.0])

    def kept():
        _, v1, _, _, _, w = instant.state
        return inertia * w - coupling * v1

    def energy():
        _, v1, _, _, _, w = instant.state
        masses = np.array([[scene.bodies[0].m + p.m3, -coupling], [-coupling, inertia]])
        return float(np.array([v1, w]) @ masses @ np.array([v1, w]) / 2)

    before, full = kept(), energy()
    impact(instant, [0], [2.0])
    assert instant.state[1] == pytest.approx(-e * 2.0, abs=1e-15) and instant.state[3] == -1.0
    assert kept() == pytest.approx(before, rel=1e-14)
    lost = 1 - energy() / full
    if e == 1:
        assert abs(lost) < 1e-13
    else:
        assert lost > 0


def test_a_body_held_from_both_sides_is_refused():
    scene = load_case("gallery/impact-pair").scene()
    instant = at(scene, start_of(scene))
    with pytest.raises(ArithmeticError, match="no impulses obey the law"):
        impact(instant, [0, 1], [1.0, 1.0])


def test_no_more_is_tried_than_can_be():
    """Of thirty frictions at rest, 3^30 combinations; of thirteen stops that touch, 2^13 sets."""
    friction = SimpleNamespace(states=("stick", "forward", "backward"), part=None)
    at = SimpleNamespace(switches=[friction] * 30)
    with pytest.raises(ArithmeticError, match="205891132094649 combinations of the parts at rest, of which"):
        consistent_states(at, ["stick"] * 30, range(30))
    with pytest.raises(ArithmeticError, match="13 stops touch at once"):
        _impulses(np.eye(13), np.ones(13), np.zeros(13))


# Every peer stops where it is told to, and says how far it came.


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
def test_heyoka_within_a_time():
    from vibsim.evidence.peers.heyoka_events import PIECE, HeyokaEvents

    attempt = HeyokaEvents(paper("I-C").as_parts(), 1e-9).run(TIMES, TimeLimit(going_on=looks(1)))
    assert attempt.stopped and len(attempt.states) == 2 * PIECE + 1
    assert attempt.t_reached == TIMES[2 * PIECE]


def test_the_clock_counts():
    limit = TimeLimit(0.0)
    with pytest.raises(OutOfTime):
        limit.check()
    TimeLimit(60.0).check()

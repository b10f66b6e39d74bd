"""Scenes of parts: the peers, written apart from the engine, know them as the engine does."""

from importlib.util import find_spec
from math import sin

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings

from tests.engine.random_parts import part_scenes, rigid_scenes
from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.solvers import (
    EventlessSolver,
    EventSolver,
    RungeKutta4,
    TimeLimit,
    eventless_motion,
    kinds_of,
)
from vibsim.physics.parts import EVENT_NAMES
from vibsim.results.columns import tables_of

# without chatter, over a span in which something happens; chaos multiplies errors by less than 1e3 there
SPANS = {
    "gallery/ball-on-shaken-table": "1 s",
    "gallery/belt-oscillator": "20 s",
    "gallery/bilinear-oscillator": "20 s",
    "gallery/block-on-belt": "20 s",
    "gallery/chain-with-gaps": "4 s",
    "gallery/drifting-capsule": "1 s",
    "gallery/energy-sink": "5 s",
    "gallery/friction-oscillator": "20 s",
    "gallery/impact-damper": "8 s",
    "gallery/impact-oscillator": "20 s",
    "gallery/impact-oscillator-coco": "20 s",
    "gallery/impact-pair": "2 s",
    "gallery/percussive-drill": "0.3 s",
    "gallery/stack-of-blocks": "1 s",
    "gallery/three-balls": "0.3 s",
    "gallery/two-masses-with-friction": "40 s",
    "II-B": "3 s",
}
CHATTERING = {
    "gallery/bouncing-ball": "10 s",
    "gallery/drifting-oscillator": "1.5 s",
    "gallery/pile-driver": "1 s",
}
NOT_COMPARED = ("start", "end", "transmitted", "chatter")


# of the paper's machine: what it lacks, or how it begins
OTHERS = {
    "mirrored stop": {"stop.acts": "compression", "phi": "1 rad"},
    "no stop": {"stop": "none", "excitation": "none", "x1": "1 mm"},
    "no friction": {"friction": "none"},
    "block 2 fixed": {"m2": "fixed", "friction": "none", "c": "0.5 N s/m"},
    "motor on a fixed block": {"m2": "fixed", "friction": "none", "stop": "none", "Omega0": "3.5 Hz"},
    "no source, begun in contact": {"excitation": "none", "x2": "2 mm", "v2": "-1 cm/s", "v1": "0.3 m/s"},
}


def reference(scene):
    """Instants, displacements (n, bodies) and names of the events by the engine."""
    return of_trajectory(scene, open_trajectory(scene))


def of_trajectory(scene, trajectory):
    blocks = list(trajectory.blocks())
    columns = tables_of(scene).displacements
    x = np.column_stack([np.concatenate([block.samples[name] for block in blocks]) for name in columns])
    kinds = [EVENT_NAMES[int(kind)] for block in blocks for kind in block.events["kind"]]
    return sample_times(scene), x, [kind for kind in kinds if kind not in NOT_COMPARED]


def sample_times(scene):
    return np.array([scene.sample_time(i) for i in range(scene.sample_count)])


def displaced(attempt, x):
    """The columns of displacements in the states of an attempt."""
    return attempt.states[:, : 2 * x.shape[1] : 2]


def solved(peer, name, changes):
    """Largest error of the displacements, names of events of the peer and of the engine, without order at one
    instant."""
    scene = load_case(name, changes).scene()
    times, x, kinds = reference(scene)
    attempt = peer(scene).run(times, TimeLimit())
    assert attempt.kinds == kinds_of(scene) and not attempt.stopped
    error = float(np.abs(displaced(attempt, x) - x).max())
    return error, sorted(EVENT_NAMES[kind] for _, kind in attempt.events), sorted(kinds)


def dop853(scene):
    """solve_ivp looks at events at the ends of its steps alone, and where these fall is left to rounding.

    The capsule would slide back for 1.7 ms only where it sticks first: steps of up to 6 ms pass over it here
    and there, steps of 0.8 ms have two ends in it wherever they begin.
    """
    peer = EventSolver(scene, "DOP853", 1e-12)  # at 1e-11 it may lose an event between two of its steps
    if [body.name for body in scene.bodies] == ["hammer", "capsule"]:
        peer.settings["max_step"] = min(peer.settings["max_step"], 0.8e-3)
    return peer


def heyoka(scene):
    from vibsim.evidence.peers.heyoka_events import HeyokaEvents

    return HeyokaEvents(scene, 2.0**-52)


INSTALLED = pytest.mark.skipif(find_spec("heyoka") is None, reason="needs heyoka")
PEERS = [pytest.param(dop853, 1e-8, id="dop853"), pytest.param(heyoka, 1e-12, id="heyoka", marks=INSTALLED)]


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
@pytest.mark.parametrize("name", SPANS)
def test_events_and_displacements(name, peer, allowed):
    error, kinds, expected = solved(peer, name, {"run.t_end": SPANS[name]})
    assert kinds == expected and kinds
    assert error < allowed


@pytest.mark.parametrize("peer", [pytest.param(*one.values[:1], id=one.id, marks=one.marks) for one in PEERS])
@pytest.mark.parametrize("name", OTHERS)
def test_scenes_that_lack_something_or_begin_in_motion(name, peer):
    error, kinds, expected = solved(peer, "II-B", {**OTHERS[name], "run.t_end": "3 s"})
    assert kinds == expected
    assert error < 1e-9


@pytest.mark.parametrize("name", OTHERS)
def test_those_without_events_come_near(name):
    scene = load_case("II-B", {**OTHERS[name], "run.t_end": "3 s"}).scene()
    times, x, _ = reference(scene)
    attempt = EventlessSolver(scene, "LSODA", 1e-9, 1e-12, 1e-7).run(times, TimeLimit())
    assert np.abs(displaced(attempt, x) - x).max() < 1e-5


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
@pytest.mark.parametrize("name", CHATTERING)
def test_chatter_ends_in_rest(name, peer, allowed):
    """Where the last hops are left out differs; rests are the same."""
    error, kinds, expected = solved(peer, name, {"run.t_end": CHATTERING[name]})
    assert kinds.count("rest_begin") == expected.count("rest_begin") >= 1
    assert kinds.count("rest_end") == expected.count("rest_end")
    assert kinds.count("impact") > 5
    assert error < allowed


def test_runge_kutta_without_events_comes_near():
    scene = load_case("gallery/drifting-capsule", {"run.t_end": "0.5 s"}).scene()
    times, x, _ = reference(scene)
    attempt = RungeKutta4(scene, 1e-5).run(times, TimeLimit())
    assert np.abs(displaced(attempt, x) - x).max() < 1e-5  # a body that should stick creeps instead


def test_a_stop_that_lets_go_by_force_does_not_pull_without_events_either():
    scene = load_case("gallery/percussive-drill").scene()
    motion, gap, stop = eventless_motion(scene), scene.stops[0].gap, scene.stops[0]
    deep = [gap + 1e-6, 0.0, 0.0, 0.0]
    apart = [*deep[:1], -2 * stop.k * 1e-6 / stop.c, *deep[2:]]  # k g + c g' < 0
    free = motion(0.0, [0.0] * 4)[1]
    assert motion(0.0, deep)[1] == pytest.approx(free - stop.k * 1e-6 / scene.bodies[0].m, rel=1e-9)
    assert motion(0.0, apart)[1] == free


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
def test_a_body_that_starts_at_its_stop_and_comes_back(peer, allowed):
    """Its depth is exactly 0 at the start; v0 / (g / 2) later it meets the stop again."""
    text = """
    bodies: {ball: 1 kg}
    stops: {floor: {between: [ball, ground], gap: 0 m, acts: extension, k: 100 N/m}}
    forces: {weight: {on: ball, F0: -10 N}}
    initial: {ball: {v: 1 m/s}}
    run: {t_end: 0.3 s, every: 10 ms}
    """
    scene = load_case_text(text, name="thrown").scene()
    times = sample_times(scene)
    attempt = peer(scene).run(times, TimeLimit())
    assert [EVENT_NAMES[kind] for _, kind in attempt.events] == ["contact_begin"]
    assert attempt.events[0][0] == pytest.approx(0.2, abs=1e-10)
    late = times[times > 0.2] - 0.2  # the spring at work: x = -g/w^2 (1 - cos wt) - v/w sin wt, w = 10 / s
    expected = -0.1 * (1 - np.cos(10 * late)) - 0.1 * np.sin(10 * late)
    assert np.abs(attempt.states[times > 0.2, 0] - expected).max() < allowed


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
def test_a_body_without_forces_is_a_scene_too(peer, allowed):
    text = "bodies: {a: 1 kg, b: 1 kg}\ninitial: {a: {v: 1 m/s}}\nrun: {t_end: 1 s, every: 0.1 s}"
    scene = load_case_text(text, name="free").scene()
    attempt = peer(scene).run(np.linspace(0, 1, 11), TimeLimit())
    assert attempt.states[-1] == pytest.approx([1, 1, 0, 0], abs=allowed)


def test_ties_whose_forces_are_not_unique_are_refused():
    scene = load_case("hard/pressed-on-a-stop", {"run.t_end": "2 s"}).scene()
    with pytest.raises(ArithmeticError, match="hold the same bodies at once: their forces are not unique"):
        dop853(scene).run(np.linspace(0, 2, 11), TimeLimit())


# Random scenes of all parts: a peer that shares no line with the engine comes to the same motion.


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
        times, x, _ = of_trajectory(scene, trajectory)
    except EngineError:
        assume(False)  # held from both sides while they close
    assume(not trajectory.totals["uncertified"])  # rounding may decide, and the run says so
    assume(len(times) > 1)
    try:
        attempt = EventSolver(scene, "DOP853", 1e-11, looks=True).run(times, TimeLimit())
    except ArithmeticError as error:
        assert str(error).endswith(NOT_UNIQUE)
        assume(False)
    largest = max(float(np.abs(x).max()), 1e-3)
    np.testing.assert_allclose(displaced(attempt, x), x, rtol=0, atol=AGREE * largest)


SLIPS = """
bodies: {m: 1 kg}
friction: {floor: {between: [m, ground], N: 1 N, mu: 0.3814}}
forces:
  slow: {on: m, A: 0.3944 N, omega: 6.7016 rad/s}
  fast: {on: m, A: 0.0865 N, omega: 8.2829 rad/s, phase: 0.5 rad}
run: {t_end: 3 s, every: 0.1 s}
"""


def test_a_slip_between_two_steps_of_a_body_at_rest_is_seen():
    """The force passes 0.3814 N from 0.126 s on: a step of a body that rests ends where it is below again."""
    scene = load_case_text(SLIPS).scene()
    seen, blind = (
        EventSolver(scene, "DOP853", 1e-11, looks=looks).run(sample_times(scene), TimeLimit())
        for looks in (True, False)
    )
    t, kind = seen.events[0]
    assert EVENT_NAMES[kind] == "stick_end"
    assert 0.3944 * sin(6.7016 * t) + 0.0865 * sin(8.2829 * t + 0.5) == pytest.approx(0.3814, abs=1e-9)
    # else steps are shorter now, and this shows nothing
    assert not blind.events or blind.events[0][0] > t + 0.1


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

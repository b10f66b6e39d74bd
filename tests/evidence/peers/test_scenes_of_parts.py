"""Scenes of parts: the peers, written apart from the engine, know them as the engine does."""

from importlib.util import find_spec

import numpy as np
import pytest

from vibsim.cases import load_case
from vibsim.cases.case import load_case_text
from vibsim.engine.trajectory import open_trajectory
from vibsim.evidence.peers.solvers import EventSolver, RungeKutta4, TimeLimit, eventless_motion, kinds_of
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


def reference(name, t_end):
    """The scene, its instants, displacements (n, bodies) and names of the events by the engine."""
    scene = load_case(name, {"run.t_end": t_end}).scene()
    blocks = list(open_trajectory(scene).blocks())
    columns = tables_of(scene).displacements
    x = np.column_stack([np.concatenate([block.samples[name] for block in blocks]) for name in columns])
    kinds = [EVENT_NAMES[int(kind)] for block in blocks for kind in block.events["kind"]]
    times = np.array([scene.sample_time(i) for i in range(scene.sample_count)])
    return scene, times, x, [kind for kind in kinds if kind not in NOT_COMPARED]


def solved(peer, name, t_end):
    """Largest error of the displacements, names of events of the peer and of the engine, without order at one
    instant."""
    scene, times, x, kinds = reference(name, t_end)
    attempt = peer(scene).run(times, TimeLimit())
    assert attempt.kinds == kinds_of(scene) and not attempt.stopped
    error = float(np.abs(attempt.states[:, : 2 * x.shape[1] : 2] - x).max())
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
    error, kinds, expected = solved(peer, name, SPANS[name])
    assert kinds == expected and kinds
    assert error < allowed


@pytest.mark.parametrize(("peer", "allowed"), PEERS)
@pytest.mark.parametrize("name", CHATTERING)
def test_chatter_ends_in_rest(name, peer, allowed):
    """Where the last hops are left out differs; rests are the same."""
    error, kinds, expected = solved(peer, name, CHATTERING[name])
    assert kinds.count("rest_begin") == expected.count("rest_begin") >= 1
    assert kinds.count("rest_end") == expected.count("rest_end")
    assert kinds.count("impact") > 5
    assert error < allowed


def test_runge_kutta_without_events_comes_near():
    scene, times, x, _ = reference("gallery/drifting-capsule", "0.5 s")
    attempt = RungeKutta4(scene, 1e-5).run(times, TimeLimit())
    assert np.abs(attempt.states[:, :4:2] - x).max() < 1e-5  # a body that should stick creeps instead


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
    times = np.array([scene.sample_time(i) for i in range(scene.sample_count)])
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

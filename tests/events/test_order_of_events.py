"""Two events closer than rounding tells apart are in doubt; all others come in their order."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.runs import run, scene_of
from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, MOTORS, fixed_block, paper, scene
from vibsim.physics.parts import EVENT_NAMES

METHODS = ("closed_form", "taylor")
everywhere = pytest.mark.parametrize("method", METHODS)

# block 2 sticks until the spring of k1 is compressed by N / k1, contact begins at G: one place to 1e-17 m;
# 40 digits find the release 1.1e-16 s before the contact
G = 0.05043153077373398
TWO_AT_ONCE = {
    "m1": 0.5386799582547112,
    "m2": 0.31715090043652544,
    "k1": 9.201611417216393,
    "c": 0.0,
    "k2": 66.06531424243455,
    "G": G,
    "stop_sign": -1,
    "N": 0.14915268771244272 * 0.31715090043652544 * 9.81,
    "x1": 0.02072768885370705,
    "v1": -0.5906976950018936,
    "x2": 0.07413870767124531,
    "v2": 0.25881273829257717,
    "t_end": 6.8985,
}


@everywhere
def test_two_events_at_once_are_in_doubt(method):
    result = run(scene(**TWO_AT_ONCE, method=method))
    happened = pairwise(zip(result.kinds, result.times, strict=True))
    assert [{a, b} for (a, s), (b, t) in happened if t - s < 1e-14] == [{"stick_end", "contact_begin"}]
    assert result.totals["uncertified"] in (1, 2)  # the stretch before both, and that between them


@everywhere
@pytest.mark.parametrize("shift", [1e-9, -1e-9])
def test_two_events_in_short_order_are_not(method, shift):
    """The stop moved by 1e-9 m: further than rounding blurs a place of 0.05 m, a million times."""
    case = scene(**{**TWO_AT_ONCE, "G": G + shift}, method=method)
    result = run(case)
    happened = pairwise(zip(result.kinds, result.times, strict=True))
    near = [(a, b) for (a, s), (b, t) in happened if t - s < 1e-6]
    assert near == [("stick_end", "contact_begin") if shift > 0 else ("contact_begin", "stick_end")]
    assert result.totals["uncertified"] == 0


@everywhere
def test_one_place_under_two_names_is_not_in_doubt(method):
    """Two stops at one place are met at one instant by definition: which is told first is no question."""
    case = fixed_block(c=0.0, k1=300.0, k2=5000.0, G=0.01, v1=-0.5, t_end=0.03, method=method)
    scene = case.as_parts()
    twice = replace(scene, stops=(*scene.stops, replace(scene.stops[0], name="again")))
    result = run(twice)
    assert [EVENT_NAMES[code] for code in result.events["kind"][1:3].tolist()] == ["contact_begin"] * 2
    assert result.events["t"][2] - result.events["t"][1] < 1e-15
    assert result.totals["uncertified"] == 0


def test_a_rigid_stop_on_a_base_that_rests_is_one_with_that_on_the_ground():
    """A ball that hops on both at e = 1/2 and 3/4 hops as on the harder one alone, without a doubt."""
    hopping = scene_of("""
bodies: {ball: 1 kg}
stops:
  floor: {between: [ball, ground], gap: 0 m, acts: extension, law: rigid, e: 0.5}
  table: {between: [ball, base], gap: 0 m, acts: extension, law: rigid, e: 0.75}
forces: {weight: {on: ball, F0: -9.81 N}}
base: {a: 0 m, omega: 1 Hz, phase: 0.5 rad}
initial: {ball: {x: 0.1 m}}
run: {t_end: 1.5 s, every: 20 ms}
""")
    both, alone = run(hopping), run(replace(hopping, stops=hopping.stops[1:]))
    assert both.totals["impacts"] == alone.totals["impacts"] > 20
    assert both.totals["uncertified"] == alone.totals["uncertified"] == 0
    assert both.samples["x_ball"].tobytes() == alone.samples["x_ball"].tobytes()


# The grazing margin: the smallest distance from contact at which the gap function turned round.


SAMPLES = 20000


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("c", (0.0, 0.4, 4.0))
def test_a_swing_that_stays_before_the_stop(method, c):
    """Pushed off the stop, block 1 follows x1 = -(v / wd) exp(-a t) sin(wd t) to its second extreme."""
    m1, k1, v, G = 2.0, 98.0, 0.15, 0.08
    swing = fixed_block(m1=m1, k1=k1, c=c, k2=1684.0, G=G, stop_sign=-1, v1=-v, t_end=1.3, method=method)
    a = c / (2 * m1)
    wd = math.sqrt(k1 / m1 - a * a)
    t = (math.atan2(wd, a) + math.pi) / wd
    closest = G + v / wd * math.exp(-a * t) * math.sin(wd * t)
    result = run(swing)
    assert result.kinds == []
    assert result.totals["grazing_margin"] == pytest.approx(closest, rel=1e-12)
    assert result.totals["grazing_time"] == pytest.approx(t, abs=1e-6)


def smallest_turn(scene):
    """Smallest minimum of the distance from contact that samples show, and the largest distance [m]."""
    dense = replace(scene, every_num=1, every_den=max(1, round(SAMPLES / scene.t_end)))
    result = run(dense)
    samples = result.samples
    y = samples["x1"] - samples.get("x2", 0.0)
    distance = scene.stop_sign * y + scene.G
    before, here, after = distance[:-2], distance[1:-1], distance[2:]
    turn = (here < before) & (here <= after) & (samples["contact"][1:-1] == 0)
    events = result.events["t"][1:-1]
    first = np.searchsorted(events, samples["time"][:-2])
    turn &= first == np.searchsorted(events, samples["time"][2:])
    bend = before - 2 * here + after
    turn &= bend > 1e-10 * np.max(np.abs(distance))  # not the last bits of a distance that stays
    shift = np.where(bend > 0, (before - after) ** 2 / (8 * np.where(bend > 0, bend, 1.0)), 0.0)
    return float(np.min((here - shift)[turn], initial=np.inf)), float(np.max(np.abs(distance)))


def assert_margin(scene):
    expected, size = smallest_turn(scene)
    margin = run(scene).totals["grazing_margin"]
    # a turn at an event itself may count or not: only what sampling sees between events must be covered
    if np.isfinite(expected):
        assert margin <= expected + 1e-6 * size
    return margin


@pytest.mark.parametrize("method", ("auto", "taylor"))
@settings(max_examples=60)
@given(scene=scenes(features=False).filter(lambda scene: scene.has_stop))
def test_margins_of_random_scenes(method, scene):
    assert_margin(replace(scene, method=method))


# No missed event: on samples as dense as wanted the state never contradicts the mode it is reported in.
# Samples are read off the flow between the events found, a few thousand per run: if an event were missed,
# the gap function, the sliding velocity or the friction force would leave its mode's range between two
# events.


INSTANTS = 4000
ROUNDING = 1e-12  # relative to the largest value of each kind: some 1e3 events and steps of a few eps each


def dense(scene):
    """The scene with SAMPLES samples over its run."""
    return replace(scene, every_num=1, every_den=max(1, round(INSTANTS / scene.t_end)))


def largest(*arrays):
    return max(float(np.max(np.abs(array), initial=0.0)) for array in arrays)


def violations(scene, samples):
    """Names of the conditions that a sample breaks beyond rounding."""
    x2, v2 = samples.get("x2", np.zeros(1)), samples.get("v2", np.zeros(1))
    y, u = samples["x1"] - x2, samples["v1"] - v2
    contact = samples.get("contact", np.zeros(len(y)))
    broken = set()
    if scene.has_stop:
        gap, room = -scene.stop_sign * y - scene.G, ROUNDING * (largest(samples["x1"], x2) + abs(scene.G))
        broken |= {"free beyond the gap"} if np.any(gap[contact == 0] > room) else set()
        broken |= {"contact within the gap"} if np.any(gap[contact == 1] < -room) else set()
    if scene.has_friction:
        friction = samples["friction"]
        spring = scene.k1 * y + scene.c * u
        if scene.has_stop:
            spring = spring + contact * scene.k2 * (y + scene.stop_sign * scene.G)
        stiffness = scene.k1 + (scene.k2 or 0.0)
        room = ROUNDING * (stiffness * largest(samples["x1"], x2) + scene.c * largest(u) + scene.N)
        broken |= {"slips while held"} if np.any(v2[friction == 0] != 0) else set()
        broken |= (
            {"held beyond the limit"} if np.any(np.abs(spring[friction == 0]) > scene.N + room) else set()
        )
        room = ROUNDING * largest(v2, samples["v1"])
        broken |= {"slips backwards"} if np.any(friction * v2 < -room) else set()
    return broken


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
@pytest.mark.parametrize("name", CASE_NAMES)
def test_papers_cases(name, method):
    if name in MOTORS:
        method = "auto"
    scene = paper(name, method=method, t_end=20.0, every_den=5000)
    result = run(scene)
    assert violations(scene, result.samples) == set()
    assert result.totals["impacts"] > 5


def assert_modes_hold(scene):
    scene = dense(scene)
    assert violations(scene, run(scene).samples) == set()


@pytest.mark.parametrize("method", ("auto", "taylor"))
@settings(max_examples=80)
@given(scene=scenes(radians=100.0))
def test_modes_of_random_scenes_hold(method, scene):
    assert_modes_hold(replace(scene, method=method))


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("method", ("auto", "taylor"))
@settings(max_examples=4000)
@given(scene=scenes(radians=200.0))
def test_modes_of_many_random_scenes_hold(method, scene):
    assert_modes_hold(replace(scene, method=method))


def test_a_missed_event_would_be_seen():
    scene = paper("I-A", t_end=5.0, every_den=1000)
    samples = dict(run(scene).samples)
    assert violations(scene, samples) == set()
    assert violations(scene, {**samples, "contact": 0 * samples["contact"]}) == {"free beyond the gap"}
    assert "slips backwards" in violations(scene, {**samples, "friction": np.abs(samples["friction"])})

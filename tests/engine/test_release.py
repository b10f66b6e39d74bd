"""What ends that rest on each other or stick do where they are let go: what they touch besides closes or
parts there by a zero of higher order, and what rubs beside a rigid stop holds it.
"""

from dataclasses import replace
from math import acos, asin, pi

import numpy as np
import pytest

from tests.engine.impacts import times
from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run, scene_of
from tests.engine.test_restart import assert_restarts
from vibsim.physics.parts import EVENT_NAMES, GROUND, Clearance, RigidStop

A, OMEGA, LIMIT = 2.0, 2 * pi, 0.5  # N, rad/s, N
RELEASE = asin(LIMIT / A) / OMEGA


def names(events):
    """Kinds of events behind the start, with their parts."""
    return [(EVENT_NAMES[kind], part) for kind, part in zip(events["kind"], events["part"], strict=True)][1:]


def untold(scene):
    """The scene without word that its elastic stops are touched at the start: signs have to tell."""
    return replace(
        scene, stops=tuple(replace(stop, at_start=isinstance(stop, RigidStop)) for stop in scene.stops)
    )


# A body that sticks to the ground where a stop begins, and that a growing force tears off.
TOUCHING = """
bodies: {m: 1 kg}
stops: {s: {between: [m, ground], gap: 0 m, acts: compression, k: 100 N/m, release: gap}}
friction: {f: {between: [m, ground], N: 0.5 N, mu: 1, static: 1}}
forces: {F: {on: m, A: 2 N, omega: 1 Hz}}
run: {t_end: 0.2 s, every: 20 ms}
"""


@pytest.mark.parametrize("method", ("auto", "taylor"))
@pytest.mark.parametrize(("c", "release"), [(0.0, "gap"), (3.0, "gap"), (3.0, "force")])
@pytest.mark.parametrize("static", (1, 2))
@pytest.mark.parametrize("acts", ("compression", "extension"))
def test_a_stop_that_a_stuck_body_touches_closes_or_parts_as_it_is_torn_off(acts, static, c, release, method):
    """It moves as (t - t0)^3 from there, or as (t - t0)^2 where the friction drops: in many digits the sign
    of what rounding made of lower orders decided, more than 64 times at one instant.
    """
    changes = {"s.acts": acts, "s.c": c, "s.release": release, "f.static": static}
    room = Clearance("room", 0, GROUND, 0.0, True)  # of 0 m, which no case has
    scene = replace(scene_of(TOUCHING, changes, method=method), clearances=(room,))
    found = run(scene)
    closes = [("contact_begin", 0)] * (acts == "compression")
    events = [("stick_end", 1), *closes, ("violation_begin", 2)]
    assert names(found.events)[: len(events)] == events
    at = asin(static * LIMIT / A) / OMEGA
    assert found.events["t"][1 : 1 + len(events)] == pytest.approx([at] * len(events), rel=1e-15)
    assert found.totals["uncertified"] == 0
    samples, exact, _, totals = truth(exact_parts(scene), 45)
    assert names(exact) == names(found.events) and totals["uncertified"] == 0
    assert np.abs(found.samples["x_m"] - samples["x_m"]).max() < 1e-16
    assert_restarts(scene)


DRAWN = """
bodies: {a: 2.8 kg, b: 1 kg, c: 1.8 kg}
links: {bc: {between: [b, c], k: 20.3 N/m}, drawn: {between: [c, base], k: 65.2 N/m}}
stops:
  ab: {between: [a, b], gap: 0 m, acts: extension, k: 72.3 N/m}
  ac: {between: [a, c], gap: 0 m, acts: extension, law: rigid, e: 0}
  ga: {between: [ground, a], gap: 0 m, acts: extension, k: 39.6 N/m}
base: {a: -6.73 mm, omega: 2 Hz, phase: 0.5 rad}
run: {t_end: 0.1 s, every: 25 ms}
"""


def test_a_spring_between_bodies_that_touch_moves_the_second_by_the_fourth_power():
    """All touch and rest; the base draws c, whose spring to b is slack. So a stop at b parts by t^4, which
    modal coordinates do not tell from rounding: it closed, and steps of 1e-17 s had no end.
    """
    found = run(untold(scene_of(DRAWN)))
    assert names(found.events) == [("end", -1)] and found.totals["uncertified"] == 0
    assert found.totals["evaluations"] < 1000 and not found.samples["x_a"].any()


PRESSED = """
bodies: {m: 1 kg}
stops: {wall: {between: [m, ground], gap: 0 m, acts: compression, law: rigid, e: 0.1}}
friction: {f: {between: [m, ground], N: 0.3 N, mu: 1, static: 3}}
forces: {F: {on: m, A: 2 N, omega: 1 Hz, phase: 90 deg}}
initial: {m: {v: 0.1 m/s}}
run: {t_end: 0.4 s, every: 20 ms}
"""


def test_friction_beside_a_stop_holds_a_body_that_came_to_rest_by_chatter():
    """Pressed to a wall by A cos(omega t) it bounces to rest, where it sticks to the wall as well: it leaves
    where the force pulls with what the friction holds, three times what it slips with, and not before.
    """
    scene = scene_of(PRESSED)
    found = run(scene)
    order = ["chatter", "rest_begin", "stick_end", "rest_end"]
    assert [kind for kind, _ in names(found.events) if kind in order] == order
    assert times(found, "rest_end") == pytest.approx([acos(-0.9 / A) / OMEGA], abs=1e-15)
    assert_restarts(scene)


PLATE = """
bodies: {plate: 1 kg, a: 0.5 kg, b: 0.7 kg}
stops:
  l: {between: [a, plate], gap: 10 mm, acts: compression, law: rigid, e: 0}
  r: {between: [b, plate], gap: 10 mm, acts: compression, law: rigid, e: 0}
forces: {on_plate: {on: plate, F0: -2 N}, on_a: {on: a, F0: 1 N}, on_b: {on: b, F0: 1.2 N}}
initial: {plate: {x: 10 mm}, a: {v: 0.05 m/s}}
run: {t_end: 0.5 s, every: 20 ms}
"""


def test_a_sequence_of_plastic_impacts_at_two_stops_in_turn_ends_as_a_chatter():
    """Two bodies are pressed to one side of a third: each plastic impact of one tears the other off."""
    scene = scene_of(PLATE)
    found = run(scene)
    told = names(found.events)
    assert [kind for kind, _ in told].count("chatter") == found.totals["chatters"] == 1
    assert found.samples["l"][-1] == found.samples["r"][-1] == 3
    _, exact, _, totals = truth(exact_parts(scene), 40)
    assert totals["chatters"] == 1 and len(exact["t"]) > len(found.events["t"])


THREE_STOPS = """
bodies: {m: 0.3 kg}
links: {l: {between: [m, ground], k: 40 N/m, c: 0.3 N s/m}}
stops:
  hard: {between: [ground, m], gap: 0 m, acts: extension, law: rigid, e: 0.5}
  soft: {between: [m, ground], gap: 0 m, acts: compression, k: 123 N/m}
  behind: {between: [m, ground], gap: 1 mm, acts: compression, k: 123 N/m}
forces: {F: {on: m, F0: 0.1 N}}
run: {t_end: 0.15 s, every: 25 ms}
"""


def test_an_elastic_stop_where_a_rigid_one_stands_is_never_pressed():
    """Both functions are one, whose zero rounding told at one stop first, or at the other."""
    for v in (-0.02, 0.02):
        scene = untold(scene_of(THREE_STOPS, {"m.v": v}))
        found = run(scene)
        assert {"impact"} < {kind for kind, _ in names(found.events)}.union({"end"})
        for events in (found.events, truth(exact_parts(scene), 40)[1]):
            assert not {kind for kind, _ in names(events)} & {"contact_begin", "contact_end"}


RUBBED_TWICE = """
bodies: {m: 1 kg}
friction: {f: {between: [m, ground], N: 0.3 N, mu: 1}, g: {between: [ground, m], N: 0.3 N, mu: 1}}
initial: {m: {v: 10 mm/s}}
run: {t_end: 0.1 s, every: 25 ms, method: taylor}
"""


def test_two_frictions_that_come_to_rest_together_are_in_no_doubt_in_many_digits():
    """Between the same ends they have one sliding velocity: of balls with a radius no two are equal."""
    *_, totals = truth(exact_parts(scene_of(RUBBED_TWICE)), 40)
    assert totals["uncertified"] == 0 and totals["sticks"] == 2

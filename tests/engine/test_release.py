"""What ends that rest on each other or stick do where they are let go: what they touch besides closes or
parts there by a zero of higher order, and what rubs beside a rigid stop holds it.
"""

import random
from dataclasses import replace
from fractions import Fraction
from math import acos, asin, pi, sqrt

import numpy as np
import pytest

from tests.engine.impacts import METHODS, times
from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run, scene_of
from tests.engine.test_restart import assert_restarts
from vibsim.engine.events.impacts.newton_moreau import Contact, Masses, impact
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import EVENT_KINDS, EVENT_NAMES, GROUND, Clearance, RigidStop

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
    """It moves as (t - t0)^3 from there, or as (t - t0)^2 where the friction drops."""
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
    """The base draws c, whose spring to b is slack: a stop at b parts by t^4."""
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
    """It leaves the wall where the force pulls with the most that friction holds, three times its slip."""
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


# Impacts of bodies that touch others, or that are struck at several stops.


CRUSHED = """
bodies: {l: 100 kg, ball: 1 kg, r: 100 kg}
stops:
  a: {between: [l, ball], gap: 0 m, acts: compression, law: rigid, e: 0.5}
  b: {between: [ball, r], gap: 0 m, acts: compression, law: rigid, e: 0.5}
initial: {l: {v: 1 m/s}, ball: {x: 0.3 m}, r: {x: 1 m, v: -1 m/s}}
run: {t_end: 3 s, every: 250 ms}
"""


@pytest.mark.parametrize("method", METHODS)
def test_body_crushed_between_walls_that_close(method):
    """e = 0.5: bounces without end in a finite time, then all move as one with the momentum of all."""
    result = run(scene_of(CRUSHED, method=method), ledger=True, momentum=True)
    gaps = result.samples["x_ball"] - result.samples["x_l"], result.samples["x_r"] - result.samples["x_ball"]
    assert min(gap.min() for gap in gaps) > -1e-15
    assert abs(result.totals["momentum_residual"]) < 1e-13
    assert abs(result.totals["energy_residual"]) < 1e-12
    assert result.totals["impacts"] < 200


TWINS = """
bodies: {b0: 0.4219724961127288 kg, b1: 2.0205722265529866 kg}
links: {l0: {between: [b0, ground], k: 3.6852853323265524 N/m}}
stops:
  e0: {between: [b0, ground], gap: 0 m, acts: compression, k: 41.89811667208198 N/m,
       c: 3.0324650071085157 N s/m, release: force}
  r0: {between: [b0, b1], gap: 0.3840759458734341 m, acts: extension, law: rigid, e: 0.6857331400718227}
  r1: {between: [b1, b0], gap: 0.3840759458734341 m, acts: compression, law: rigid, e: 1}
forces:
  F0: {on: b0, F0: 0.3192555741973109 N, terms: [
    {A: 1.757050347108766 N, omega: 0.7522050619787632 rad/s, phase: 1.5564601660430661 rad},
    {A: 0.746216967915518 N, omega: 3.466427862742015 rad/s, phase: 0.6990039361402913 rad}]}
  F1: {on: b1, A: 1.6663167018169944 N, omega: 1.5828024589444487 rad/s, phase: 4.618052510749918 rad}
initial: {b0: {x: -0.3632700009731692 m}, b1: {x: -0.0791940550997351 m, v: 0.48860002047161166 m/s}}
run: {t_end: 2.5 s, every: 0.5 s}
"""


def test_a_stop_that_rounding_leaves_open_where_its_twin_is_struck_is_struck():
    """Two stops with the same ends and gap: the law of impacts takes the larger e."""
    events = run(scene_of(TWINS)).events
    struck = events["kind"] == EVENT_KINDS["impact"]
    behind, before = (
        events[f"{prefix}v_b1"][struck] - events[f"{prefix}v_b0"][struck] for prefix in ("", "before_")
    )
    assert struck.sum() == 1
    assert behind == pytest.approx(-before, rel=1e-13)


def test_a_body_that_stands_at_one_stop_and_is_struck_through_another_does_not_pass():
    """At t = 0 b2 stands at the wall, about to part from it, when b3 strikes it: both stops take part."""
    scene = scene_of("""
bodies: {b0: 0.40644332916521275 kg, b1: 0.3953666200681279 kg,
         b2: 2.2594357702209775 kg, b3: 0.4518559443749224 kg}
links: {l0: {between: [b2, b0], k: 22.354231116646613 N/m}}
stops:
  s0: {between: [b1, b0], gap: -2 mm, acts: extension, k: 74.19245410465113 N/m}
  r0: {between: [b2, b3], gap: -1.8 mm, acts: extension, law: rigid, e: 0.3}
  r2: {between: [b2, ground], gap: 0 m, acts: compression, law: rigid, e: 0.3}
initial: {b0: {x: -1.33 mm}, b3: {x: -1.8 mm, v: 0.01872389221539517 m/s}}
run: {t_end: 0.07957747154594767 s, every: 25 ms}
""")
    assert run(scene).samples["x_b2"].max() < 1e-16


CLOSED = """
bodies: {a: 1 kg, b: 1 kg, c: 1 kg}
stops:
  ab: {between: [b, a], gap: 0 m, acts: compression, k: 40 N/m}
  bc: {between: [c, b], gap: 0 m, acts: compression, law: rigid, e: 0.5}
run: {t_end: 0.5 s, every: 1/32 s}
"""


def closing(side, away, **run):
    """c strikes b from one side, after 0 s or more, as that touches the spring at a, and a limit."""
    text = CLOSED.replace("compression", "extension") if side > 0 else CLOSED
    scene = scene_of(text, {"c.x": side * away, "c.v": -side}, t_end=away + 0.5, **run)
    return replace(scene, clearances=(Clearance("limit", *((GROUND, 1) if side > 0 else (1, GROUND)), 0.0),))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("away", [0.0, 0.125])
@pytest.mark.parametrize("side", [1, -1])
def test_an_impact_closes_what_just_touched(method, away, side):
    """Both go on with half of what b gets and swing about it until they part."""
    speed, rate = 0.75, sqrt(2 * 40.0)
    result = run(closing(side, away, method=method))
    told = [EVENT_NAMES[kind] for kind in result.events["kind"].tolist()]
    assert told == ["start", "impact", "contact_begin", "violation_begin", "contact_end", "end"]
    assert times(result, "contact_begin") == pytest.approx([away], abs=1e-15)
    assert times(result, "contact_end") == pytest.approx([away + pi / rate], rel=1e-13)
    t = np.clip(result.samples["time"] - away, 0, pi / rate)
    late = np.maximum(result.samples["time"] - away - pi / rate, 0)
    b = -side * (speed / 2 * t + speed / 2 / rate * np.sin(rate * t))
    a = -side * (speed / 2 * t - speed / 2 / rate * np.sin(rate * t) + speed * late)
    np.testing.assert_allclose(result.samples["x_b"], b, rtol=0, atol=1e-14)
    np.testing.assert_allclose(result.samples["x_a"], a, rtol=0, atol=1e-14)
    assert result.totals["uncertified"] <= (0 if away == 0 else 2)


def test_a_heavy_body_strikes_a_light_one_before_a_wall_to_rounding():
    """The light one passes large impulses that cancel; the heavy one returns with e of its speed."""
    rng = random.Random(5)
    for _ in range(200):
        light, heavy = rng.uniform(0.05, 0.2), rng.uniform(2, 20)
        e, other, v = rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95), rng.uniform(0.01, 1)
        contacts = [Contact(0, 0, 2, -1, e), Contact(1, 1, 0, -1, other)]
        bodies, before = Masses([1 / light, 1 / heavy, 0.0, 0.0]), [0.0, v, 0.0, 0.0]
        after, _, passed = impact(Doubles, bodies, contacts, before, 0.0)
        assert [one.stop for one in passed] == [0, 1]
        assert abs(Fraction(after[1]) + Fraction(other) * Fraction(v)) <= 2 * Doubles.eps * v
        assert abs(after[0]) <= 2 * Doubles.eps * v


def test_two_frictions_let_go_at_the_instant_at_which_the_limit_of_one_falls_to_their_load():
    """They hold 0.5 N until N0 (1 + sin(w t)) falls below 0.2 N, at w t = pi. What is left there to move the
    body is rounding, and made each of them let go and catch it again, without end.
    """
    result = run(
        scene_of("""
bodies: {b: 1 kg}
links: {l: {between: [b, ground], k: 100 N/m}}
friction:
  falls: {between: [b, ground], N: "N0*(1 + sin(w*t))", N0: 0.2 N, w: 5 rad/s, mu: 1}
  other: {between: [b, ground], N: 0.3 N, mu: 1}
forces: {F: {on: b, F0: 0.8 N}}
initial: {b: {x: 3 mm}}
run: {t_end: 2 s, every: 10 ms}
""")
    )
    assert [kind for kind in result.kinds if kind != "switch"][:4] == ["stick_end"] * 2 + ["stick_begin"] * 2
    t = result.samples["time"]
    s = np.clip(t - np.pi / 5, 0, 2 * np.pi / 15)  # x'' + 100 x = 0.3 N + 0.2 N sin(5 s), from rest to rest
    course = 3e-3 + 0.2 / 75 * (np.sin(5 * s) - np.sin(10 * s) / 2)
    before = t < 1.25
    np.testing.assert_allclose(result.samples["x_b"][before], course[before], rtol=0, atol=1e-15)

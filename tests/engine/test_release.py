"""What ends that rest on each other or stick do where they are let go: what they touch besides closes or
parts there by a zero of higher order, and what rubs beside a rigid stop holds it.
"""

from dataclasses import replace
from math import acos, asin, pi

import numpy as np
import pytest

from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run
from tests.engine.test_restart import assert_restarts
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    EVENT_KINDS,
    EVENT_NAMES,
    EXTENSION,
    GROUND,
    Body,
    Clearance,
    Force,
    Friction,
    Harmonic,
    Link,
    RigidStop,
    Scene,
    Stop,
)

A, OMEGA, LIMIT = 2.0, 2 * pi, 0.5  # N, rad/s, N
RELEASE = asin(LIMIT / A) / OMEGA


def names(events):
    """Kinds of events behind the start, with their parts."""
    return [(EVENT_NAMES[kind], part) for kind, part in zip(events["kind"], events["part"], strict=True)][1:]


def touching(sense, hold=None, c=0.0, release="gap"):
    """A body that sticks to the ground where a stop begins, and that a growing force tears off."""
    return Scene(
        (Body("m", 1.0, 0.0, 0.0),),
        stops=(Stop("s", 0, GROUND, 0.0, sense, 100.0, c, release, True),),
        frictions=(Friction("f", 0, GROUND, LIMIT, LIMIT, 0.0, hold, hold),),
        forces=(Force("F", 0, 0.0, (Harmonic(A, OMEGA, 1.0, 0.0, 0.0),)),),
        clearances=(Clearance("c", 0, GROUND, 0.0, True),),
        t_end=0.2,
        every_num=1,
        every_den=50,
    )


@pytest.mark.parametrize("method", ("auto", "taylor"))
@pytest.mark.parametrize(("c", "release"), [(0.0, "gap"), (3.0, "gap"), (3.0, "force")])
@pytest.mark.parametrize("hold", (None, 1.0))
@pytest.mark.parametrize("sense", (COMPRESSION, EXTENSION))
def test_a_stop_that_a_stuck_body_touches_closes_or_parts_as_it_is_torn_off(sense, hold, c, release, method):
    """It moves as (t - t0)^3 from there, or as (t - t0)^2 where the friction drops: in many digits the sign
    of what rounding made of lower orders decided, more than 64 times at one instant.
    """
    scene = replace(touching(sense, hold, c, release), method=method)
    found = run(scene)
    events = [("stick_end", 1)] + [("contact_begin", 0)] * (sense == COMPRESSION) + [("violation_begin", 2)]
    assert names(found.events)[: len(events)] == events
    at = asin((hold or LIMIT) / A) / OMEGA
    assert found.events["t"][1 : 1 + len(events)] == pytest.approx([at] * len(events), rel=1e-15)
    assert found.totals["uncertified"] == 0
    samples, exact, _, totals = truth(exact_parts(scene), 45)
    assert names(exact) == names(found.events) and totals["uncertified"] == 0
    assert np.abs(found.samples["x_m"] - samples["x_m"]).max() < 1e-16
    assert_restarts(scene)


def test_a_spring_between_bodies_that_touch_moves_the_second_by_the_fourth_power():
    """All touch and rest; the base draws c, whose spring to b is slack. So a stop at b parts by t^4, which
    modal coordinates do not tell from rounding: it closed, and steps of 1e-17 s had no end.
    """
    bodies = (Body("a", 2.8, 0.0, 0.0), Body("b", 1.0, 0.0, 0.0), Body("c", 1.8, 0.0, 0.0))
    links = (Link("bc", 1, 2, 20.3, 0.0), Link("drawn", 2, BASE, 65.2, 0.0))
    stops = (
        Stop("ab", 0, 1, 0.0, EXTENSION, 72.3, 0.0),
        RigidStop("ac", 0, 2, 0.0, EXTENSION, 0.0, True),
        Stop("a", GROUND, 0, 0.0, EXTENSION, 39.6, 0.0),
    )
    base = (Harmonic(-0.00673, 4 * pi, 2.0, 0.0, 0.5),)
    found = run(Scene(bodies, links, stops, base=base, t_end=0.1, every_num=1, every_den=40))
    assert names(found.events) == [("end", -1)] and found.totals["uncertified"] == 0
    assert found.totals["evaluations"] < 1000 and not found.samples["x_a"].any()


def test_friction_beside_a_stop_holds_a_body_that_came_to_rest_by_chatter():
    """Pressed to a wall by A cos(omega t) it bounces to rest, where it sticks to the wall as well: it leaves
    where the force pulls with what the friction holds, three times what it slips with, and not before.
    """
    slip, hold = 0.3, 0.9
    scene = Scene(
        (Body("m", 1.0, 0.0, 0.1),),
        stops=(RigidStop("wall", 0, GROUND, 0.0, COMPRESSION, 0.1, True),),
        frictions=(Friction("f", 0, GROUND, slip, slip, 0.0, hold, hold),),
        forces=(Force("F", 0, 0.0, (Harmonic(A, OMEGA, 1.0, 0.0, pi / 2),)),),
        t_end=0.4,
        every_num=1,
        every_den=50,
    )
    found = run(scene)
    told = names(found.events)
    assert [kind for kind, _ in told if kind in ("chatter", "rest_begin", "rest_end", "stick_end")] == [
        "chatter",
        "rest_begin",
        "stick_end",
        "rest_end",
    ]
    left = found.events["t"][found.events["kind"] == EVENT_KINDS["rest_end"]]
    assert left == pytest.approx([acos(-hold / A) / OMEGA], abs=1e-15)
    assert_restarts(scene)


def test_a_sequence_of_plastic_impacts_at_two_stops_in_turn_ends_as_a_chatter():
    """Two bodies are pressed to one side of a third: each plastic impact of one tears the other off."""
    bodies = (Body("plate", 1.0, 0.01, 0.0), Body("a", 0.5, 0.0, 0.05), Body("b", 0.7, 0.0, 0.0))
    stops = tuple(RigidStop(name, i, 0, 0.01, COMPRESSION, 0.0) for i, name in ((1, "l"), (2, "r")))
    forces = tuple(Force(f"F{i}", i, F, ()) for i, F in enumerate((-2.0, 1.0, 1.2)))
    scene = Scene(bodies, (), stops, (), forces, t_end=0.5, every_num=1, every_den=50)
    found = run(scene)
    told = names(found.events)
    assert [kind for kind, _ in told].count("chatter") == found.totals["chatters"] == 1
    assert found.samples["l"][-1] == found.samples["r"][-1] == 3
    _, exact, _, totals = truth(exact_parts(scene), 40)
    assert totals["chatters"] == 1 and len(exact["t"]) > len(found.events["t"])


def test_an_elastic_stop_where_a_rigid_one_stands_is_never_pressed():
    """Both functions are one, whose zero rounding told at one stop first, or at the other."""
    stops = (
        RigidStop("hard", GROUND, 0, 0.0, EXTENSION, 0.5, True),
        Stop("soft", 0, GROUND, 0.0, COMPRESSION, 123.0, 0.0),
        Stop("behind", 0, GROUND, 0.001, COMPRESSION, 123.0, 0.0),
    )
    link = Link("l", 0, GROUND, 40.0, 0.3)
    force = Force("F", 0, 0.1, ())
    for v in (-0.02, 0.02):
        scene = Scene(
            (Body("m", 0.3, 0.0, v),), (link,), stops, (), (force,), t_end=0.15, every_num=1, every_den=40
        )
        found = run(scene)
        assert {"impact"} < {kind for kind, _ in names(found.events)}.union({"end"})
        for events in (found.events, truth(exact_parts(scene), 40)[1]):
            assert not {kind for kind, _ in names(events)} & {"contact_begin", "contact_end"}


def test_two_frictions_that_come_to_rest_together_are_in_no_doubt_in_many_digits():
    """Between the same ends they have one sliding velocity: of balls with a radius no two are equal."""
    rub = Friction("f", 0, GROUND, 0.3, 0.3, 0.0)
    scene = Scene(
        (Body("m", 1.0, 0.0, 0.01),),
        frictions=(rub, replace(rub, name="g", P=GROUND, Q=0)),
        t_end=0.1,
        every_num=1,
        every_den=40,
        method="taylor",
    )
    *_, totals = truth(exact_parts(scene), 40)
    assert totals["uncertified"] == 0 and totals["sticks"] == 2

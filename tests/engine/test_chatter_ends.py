"""Where infinite sequences of impacts end, against 40 digits, and what doubles cannot tell there."""

from dataclasses import replace

import numpy as np
import pytest

from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run
from vibsim.physics.parts import (
    AT_FORCE,
    BASE,
    COMPRESSION,
    EVENT_KINDS,
    EXTENSION,
    GROUND,
    Body,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    RigidStop,
    Scene,
    Stop,
)

ROUNDED = 1e-14  # m, of displacements below a metre and a handful of stretches behind the chatter


def kinds(table):
    """Which kinds of events a run has."""
    names = {code: name for name, code in EVENT_KINDS.items()}
    return {names[code] for code in table["kind"].tolist()}


def worst(scene):
    """(run, largest error of a displacement [m]) against 40 digits."""
    fast = run(scene)
    samples, *_ = truth(exact_parts(scene), 40)
    columns = [name for name in samples if name.startswith("x_")]
    return fast, max(float(np.abs(fast.samples[name] - samples[name]).max()) for name in columns)


def pressed(frictions=(), motor=None, others=(), v=0.0):
    """Two bodies that forces press onto each other; they move with about v [m/s] and meet at 0.2 m/s."""
    bodies = (Body("a", 1.0, 0.0, v + 0.2), Body("b", 0.6, 0.01, v), *others)
    stop = RigidStop("between", 0, 1, 0.0, COMPRESSION, 0.5)
    forces = (Force("left", 0, 2.0, ()), Force("right", 1, -1.5, ()))
    return Scene(bodies, (), (stop,), frictions, forces, motor=motor, t_end=0.5, every_num=1, every_den=50)


ROTOR = Motor(1, 0.4, 0.02, 4e-4, 0.01, 9.4, 0.5, 3.0)


def test_a_rotor_takes_part_in_the_end_of_a_chatter():
    """Friction turns round at the top of each hop, so the last ones are left out, from 2e-7 m/s on: the
    bodies came to rest on each other as if no rotor hung on one, and were 7e-9 m off half a second later.
    """
    found, error = worst(pressed((Friction("f", 0, 1, 0.05, 0.05, 0.0),), ROTOR))
    assert "reversal" in kinds(found.events) and found.totals["chatters"] == 1
    assert found.totals["chatter_speed"] > 1e-8 and error < ROUNDED


def test_friction_that_goes_on_sliding_ends_no_chatter():
    """It rubs on another body and does not turn round: the sequence was ended 1.5e-7 s early."""
    rubbing = Friction("f", 2, 1, 0.05, 0.05, 0.0)
    found, error = worst(pressed((rubbing,), None, (Body("c", 1.0, 0.0, 2.0),)))
    assert "reversal" not in kinds(found.events) and found.totals["chatters"] == 1
    assert found.totals["chatter_time"] < 8 * np.spacing(0.5) / (1 - 0.5) and error < ROUNDED


def test_a_chatter_that_fades_below_the_rounding_of_velocities_is_one():
    """At 30 m/s the last approaches are nothing but rounding: the rest behind them was told without one."""
    found, error = worst(pressed(v=30.0))
    assert {"chatter", "rest_begin"} < kinds(found.events)
    assert 0 < found.totals["chatter_time"] < 1e-12
    assert error < len(found.events["t"]) * np.spacing(15.0)  # each impact rounds a displacement of 15 m


def test_nothing_else_moves_where_a_stop_is_struck_at_the_start():
    """The other bodies were given what rounding makes of zero, and one that stood at a wall struck it."""
    bodies = (Body("a", 1.3, 0.0, -0.0076), Body("b", 1.8, -0.00499, 0.0), Body("c", 1.26, 0.0, 0.0))
    links = (Link("ab", 1, 2, 76.4, 0.0), Link("ca", 2, 0, 94.0, 0.0))
    stops = (
        RigidStop("left", 0, GROUND, 0.0, EXTENSION, 0.3, True),
        RigidStop("right", GROUND, 1, 0.00499, COMPRESSION, 0.3, True),
    )
    found = run(Scene(bodies, links, stops, t_end=0.1, every_num=1, every_den=50))
    first = {name: column[found.events["t"] == 0][-1] for name, column in found.events.items()}
    assert first["kind"] == EVENT_KINDS["impact"] and first["part"] == 0
    assert first["v_a"] == 0.3 * 0.0076
    assert first["v_b"] == first["v_c"] == first["x_c"] == 0 and first["x_b"] == -0.00499


def test_bodies_without_play_come_to_rest_on_each_other_in_many_digits():
    """Stops on both sides of a body are struck in turn, each impact half as hard, a hundred times at one
    instant: radii grew until none could be told from rest, and the run failed.
    """
    bodies = (Body("a", 2.1, 0.0, -0.0343), Body("b", 1.7, -0.00127, 0.0075))
    stops = (
        RigidStop("left", 1, 0, -0.00127, COMPRESSION, 0.5, True),
        RigidStop("right", 0, 1, 0.00127, COMPRESSION, 0.5, True),
    )
    scene = Scene(bodies, (), stops, t_end=0.1, every_num=1, every_den=50)
    samples, *_ = truth(exact_parts(scene), 40)
    common = pytest.approx((2.1 * -0.0343 + 1.7 * 0.0075) / 3.8, rel=1e-15)
    assert samples["v_a"][-1] == samples["v_b"][-1] == common


def test_a_stop_that_passes_nothing_is_not_struck():
    """A ball meets a wall and a body that touches it on the same side: turned round by the wall it parts from
    the body as the law asks, by no impulse, of which 40 digits made 1e-52 N s and an impact.
    """
    bodies = (Body("body", 0.586, 0.0, 0.0), Body("ball", 0.787, 0.00769, 0.0483))
    stops = tuple(RigidStop(f"stop{P}", P, 1, 0.00769, EXTENSION, 0.5, True) for P in (0, GROUND))
    scene = Scene(bodies, (), stops, motor=replace(ROTOR, phidot=0.0), t_end=0.01, every_num=1, every_den=100)
    for events in (run(scene).events, truth(exact_parts(scene), 40)[1]):
        assert events["part"][events["kind"] == EVENT_KINDS["impact"]].tolist() == [1]


@pytest.mark.parametrize("moved", (0.0, 5e-4))
def test_the_ledgers_have_what_the_end_of_a_chatter_gives_to_the_ground(moved):
    """Friction ends it with 2e-7 m/s to go, at a wall that stands or at one that moves: residuals of the same
    times 0.57 kg were told, as if momentum came from nowhere.
    """
    where = BASE if moved else GROUND
    scene = Scene(
        (Body("b", 0.57, 1.0, 0.04),),
        stops=(RigidStop("wall", 0, where, 1.0, COMPRESSION, 0.8, True),),
        frictions=(Friction("f", 0, where, 0.32, 0.32, 0.0),),
        forces=(Force("F", 0, 0.9, ()),),
        base=(Harmonic(moved, 2.0, 1 / np.pi, 0.0, 0.0),) if moved else (),
        t_end=1.0,
        every_num=1,
        every_den=50,
    )
    fast = run(scene, momentum=True)
    assert fast.totals["chatter_speed"] > 1e-8
    assert abs(fast.totals["momentum_residual"]) < 1e-15 * len(fast.events["t"])
    assert abs(fast.totals["energy_residual"]) < 1e-17 * len(fast.events["t"])


def walls(restitutions, beyond=0.0, friction=0.0):
    """A ball that strikes walls at one place at once, each `beyond` [m] behind the one before; a force
    presses it on.
    """
    stops = tuple(
        RigidStop(f"wall{i}", 0, GROUND, 0.3 + i * beyond, COMPRESSION, e) for i, e in enumerate(restitutions)
    )
    rubbing = (Friction("f", 0, GROUND, friction, friction, 0.0),) if friction else ()
    ball, push = Body("ball", 1.0, 0.0, 0.7), Force("F", 0, 2.0, ())
    return Scene((ball,), (), stops, rubbing, (push,), t_end=4.0, every_num=1, every_den=50)


@pytest.mark.parametrize(
    ("restitutions", "beyond", "doubted"),
    [((0.8, 0.3), np.spacing(0.3), True), ((0.8, 0.8), 0.0, False), ((0.8, 0.3), 0.0, False)],
)
def test_a_impact_is_in_doubt_where_the_order_of_two_makes_a_difference(restitutions, beyond, doubted):
    """Struck one after the other, the first wall tells the speed behind; both at once, the harder one. Walls
    at one place are struck at once, whatever rounding does.
    """
    fast = run(walls(restitutions, beyond))
    assert (fast.totals["uncertified"] > 0) == doubted


CUT_OFF = ("chatters", "chatter_time", "chatter_speed", "chatter_distance")


@pytest.mark.parametrize("friction", (0.0, 0.5))
@pytest.mark.parametrize("softer", ((0.7,), (0.3,), (0.0,), (0.3, 0.7)))
@pytest.mark.parametrize("first", (True, False))
def test_of_stops_at_one_place_the_hardest_decides(softer, first, friction):
    """L >= 0 and g'(after) <= -e g'(before) of all is the law of the greatest e alone. Each impact was a
    doubt, the softest wall ended the sequence early, and what was cut off was counted once a wall.
    """
    restitutions = (0.7, *softer) if first else (*softer, 0.7)
    single = run(walls((0.7,), friction=friction), momentum=True)
    fast = run(walls(restitutions, 0.0, friction), momentum=True)
    assert fast.totals["uncertified"] == 0
    assert {name: fast.totals[name] for name in CUT_OFF} == {name: single.totals[name] for name in CUT_OFF}
    assert np.array_equal(fast.samples["v_ball"], single.samples["v_ball"])
    hardest = restitutions.index(0.7)
    assert fast.totals[f"loss.stops.wall{hardest}"] == single.totals["loss.stops.wall0"]
    for name in ("impact", "chatter"):
        parts = fast.events["part"][fast.events["kind"] == EVENT_KINDS[name]]
        assert set(parts.tolist()) == {hardest} and len(parts) == single.totals[f"{name}s"]
    assert fast.totals["rests"] == len(restitutions)


@pytest.mark.parametrize("e", (0.3, 0.7))
def test_two_stops_at_one_place_act_as_one(e):
    """One passes the impulses; rounding told that the other did not part any more while the bodies moved on
    faster than they hopped: it came to rest 1e-14 s early, without a chatter.
    """
    bodies = (Body("a", 0.8, 0.0, 0.25), Body("b", 0.35, 0.002, 0.2))
    one = RigidStop("one", 0, 1, 0.0, COMPRESSION, e)
    twin = RigidStop("twin", 1, 0, 0.0, EXTENSION, e)
    forces = (Force("left", 0, 2.0, ()), Force("right", 1, -1.5, ()))
    alone = Scene(bodies, (), (one,), (), forces, t_end=0.4, every_num=1, every_den=50)
    scene = replace(alone, stops=(one, twin))
    fast = run(scene)
    single = run(alone)
    for table in (single.events, fast.events, truth(exact_parts(scene), 40)[1]):
        assert table["t"][table["kind"] == EVENT_KINDS["chatter"]].size >= 1
    ends = [r.events["t"][r.events["kind"] == EVENT_KINDS["rest_begin"]] for r in (single, fast)]
    assert len(ends[1]) == 2 and abs(ends[1] - ends[0]).max() < 1e-16
    assert fast.totals["chatter_time"] == single.totals["chatter_time"] > 0
    assert fast.totals["uncertified"] == 0


def test_friction_on_a_body_that_rests_on_the_one_that_hops_ends_the_chatter_too():
    """It turns round at the top of each hop of both: only that of the struck body itself was looked for, and
    hops went on within the rounding of displacements, in doubt, without a chatter.
    """
    bodies = (Body("front", 1.0, 0.99, 0.1), Body("back", 0.7, 0.99, 0.1))
    stops = (
        RigidStop("wall", 0, GROUND, 1.0, COMPRESSION, 0.5),
        RigidStop("pair", 1, 0, 0.0, COMPRESSION, 0.0, True),
    )
    rubbing, push = Friction("f", 1, GROUND, 0.8, 0.8, 0.0), Force("F", 1, 3.0, ())
    scene = Scene(bodies, (), stops, (rubbing,), (push,), t_end=0.6, every_num=1, every_den=50)
    fast = run(scene, most=1000)
    assert fast.totals["chatters"] == 1 and fast.totals["uncertified"] == 0
    _, exact, *_ = truth(exact_parts(scene), 40)
    ends = [table["t"][table["kind"] == EVENT_KINDS["chatter"]][-1] for table in (fast.events, exact)]
    left_out = fast.totals["chatter_time"]
    assert abs(ends[0] + left_out - ends[1]) < left_out / 10


def test_friction_alone_ends_a_chatter_on_a_stop_that_loses_nothing():
    """Each hop rises against push and friction, returns against what friction leaves of the push, and is
    shorter by the root of their ratio: only stops with e < 1 were ended, and the run crept on in hops that
    rounding held at 1e-9 m/s, 1e-7 s of motion a second.
    """
    stops = (RigidStop("wall", 0, GROUND, 0.01, COMPRESSION, 1.0),)
    rubbing, push = Friction("f", 0, GROUND, 0.5, 0.5, 0.0), Force("F", 0, 1.5, ())
    body = Body("a", 1.0, 0.0, 0.0)
    scene = Scene((body,), (), stops, (rubbing,), (push,), t_end=1.0, every_num=1, every_den=50)
    fast = run(scene, most=1000)
    assert fast.totals["chatters"] == 1 and fast.totals["uncertified"] == 0
    end = fast.events["t"][fast.events["kind"] == EVENT_KINDS["chatter"]][-1]
    share = np.sqrt((1.5 - 0.5) / (1.5 + 0.5))  # of the speed that a hop of 1 kg keeps
    speed = np.sqrt(2 * 0.01 * (1.5 - 0.5))
    exact = speed + speed * (1 / 2 + share) / (1 - share)  # the fall at 1 m/s^2, then hops against 2 and back
    assert abs(end + fast.totals["chatter_time"] - exact) < fast.totals["chatter_time"] / 10
    assert fast.totals["chatter_time"] < 1e-6 and fast.events["kind"][-1] == EVENT_KINDS["end"]


@pytest.mark.parametrize("c", [0.1, 0.4, 2.0])
def test_a_chatter_ends_where_an_elastic_stop_lets_go(c):
    """An elastic stop closes with each hop and lets go within it, so the motion started anew from rounded
    displacements: hops of two of their units went on for ever, or were lost in one step, 8e-7 s early.
    """
    wall, cushion = (
        RigidStop("wall", 0, GROUND, 0.3, COMPRESSION, 0.8),
        Stop("cushion", 0, GROUND, -0.3, EXTENSION, 5.0, c, AT_FORCE),
    )
    scene = Scene(
        (Body("a", 1.0, 0.29, 0.1),), (), (wall, cushion), forces=(Force("F", 0, 1.5, ()),),
        t_end=2.0, every_num=1, every_den=50,
    )  # fmt: skip
    fast = run(scene, most=1000)
    samples, exact, *_ = truth(exact_parts(scene), 40)
    assert fast.totals["chatters"] == 1 and fast.totals["uncertified"] == 0
    ends = [table["t"][table["kind"] == EVENT_KINDS["chatter"]][-1] for table in (fast.events, exact)]
    left_out = fast.totals["chatter_time"]
    assert abs(ends[0] + left_out - ends[1]) < left_out / 10
    assert np.abs(fast.samples["x_a"] - samples["x_a"]).max() < ROUNDED + fast.totals["chatter_distance"]


@pytest.mark.parametrize("e", [0.5, 0.8])
def test_a_chatter_ends_that_begins_with_the_run_on_a_moving_base(e):
    """Near t = 0 a unit of time is some 1e-21 s, but the velocity of the base is known to the rounding of its
    angle only: 5e-15 m/s, in which hops of 4e-18 s went on for ever. The base falls from its top, which
    closes the stop with A omega^2 to the order of (omega t)^2 = 2e-7.
    """
    omega, top, leap = 2 * np.pi * 7.3, 0.5, 1e-3
    base = (Harmonic(top, omega, 7.3, 0.0, np.pi / 2),)
    ball, stop = Body("ball", 0.01, top, -leap), RigidStop("table", 0, BASE, 0.0, COMPRESSION, e)
    scene = Scene((ball,), (), (stop,), base=base, t_end=1.0, every_num=1, every_den=50)
    fast = run(scene, most=1000)
    assert fast.totals["uncertified"] == 0 and fast.totals["chatters"] >= 1
    end = fast.events["t"][fast.events["kind"] == EVENT_KINDS["chatter"]][0]
    assert end == pytest.approx(2 * leap / (top * omega**2) / (1 - e), rel=1e-6)

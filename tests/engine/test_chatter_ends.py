"""Where infinite sequences of impacts end, against 40 digits, and what doubles cannot tell there."""

from dataclasses import replace

import numpy as np
import pytest

from tests.engine.impacts import times
from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import run, scene_of
from tests.engine.test_chatter import PRESSED
from vibsim.physics.parts import EVENT_KINDS

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


def test_a_rotor_takes_part_in_the_end_of_a_chatter():
    """Friction turns round at the top of each hop: those from 2e-7 m/s on are left out."""
    rotor = """
friction: {f: {between: [a, b], N: 0.05 N, mu: 1}}
motor: {on: b, m3: 0.4 kg, e: 2 cm, J: 4e-4 kg m^2, M0: 0.01 N m, Omega0: 9.4 rad/s}
"""
    found, error = worst(
        scene_of(PRESSED + rotor, {"initial.motor.phi": "0.5 rad", "initial.motor.phidot": "3 rad/s"})
    )
    assert "reversal" in kinds(found.events) and found.totals["chatters"] == 1
    assert found.totals["chatter_speed"] > 1e-8 and error < ROUNDED


def test_friction_that_goes_on_sliding_ends_no_chatter():
    """It rubs on another body and does not turn round: the sequence was ended 1.5e-7 s early."""
    rubbing = "friction: {f: {between: [c, b], N: 0.05 N, mu: 1}}\n"
    of = scene_of(PRESSED.replace("b: 0.6 kg", "b: 0.6 kg, c: 1 kg") + rubbing, {"c.v": "2 m/s"})
    found, error = worst(of)
    assert "reversal" not in kinds(found.events) and found.totals["chatters"] == 1
    assert found.totals["chatter_time"] < 8 * np.spacing(0.5) / (1 - 0.5) and error < ROUNDED


def test_a_chatter_that_fades_below_the_rounding_of_velocities_is_one():
    """At 30 m/s the last approaches are nothing but rounding: the rest behind them was told without one."""
    found, error = worst(scene_of(PRESSED, {"a.v": "30.2 m/s", "b.v": "30 m/s"}))
    assert {"chatter", "rest_begin"} < kinds(found.events)
    assert 0 < found.totals["chatter_time"] < 1e-12
    assert error < len(found.events["t"]) * np.spacing(15.0)  # each impact rounds a displacement of 15 m


def test_nothing_else_moves_where_a_stop_is_struck_at_the_start():
    """The other bodies were given what rounding makes of zero, and one that stood at a wall struck it."""
    scene = scene_of("""
bodies: {a: 1.3 kg, b: 1.8 kg, c: 1.26 kg}
links: {ab: {between: [b, c], k: 76.4 N/m}, ca: {between: [c, a], k: 94 N/m}}
stops:
  left: {between: [a, ground], gap: 0 m, acts: extension, law: rigid, e: 0.3}
  right: {between: [ground, b], gap: 4.99 mm, acts: compression, law: rigid, e: 0.3}
initial: {a: {v: -7.6 mm/s}, b: {x: -4.99 mm}}
run: {t_end: 0.1 s, every: 20 ms}
""")
    found = run(scene)
    first = {name: column[found.events["t"] == 0][-1] for name, column in found.events.items()}
    assert first["kind"] == EVENT_KINDS["impact"] and first["part"] == 0
    assert first["v_a"] == 0.3 * 0.0076
    assert first["v_b"] == first["v_c"] == first["x_c"] == 0 and first["x_b"] == -0.00499


def test_bodies_without_play_come_to_rest_on_each_other_in_many_digits():
    """Stops on both sides are struck in turn, each impact half as hard, a hundred times at one instant."""
    scene = scene_of("""
bodies: {a: 2.1 kg, b: 1.7 kg}
stops:
  left: {between: [b, a], gap: -1.27 mm, acts: compression, law: rigid, e: 0.5}
  right: {between: [a, b], gap: 1.27 mm, acts: compression, law: rigid, e: 0.5}
initial: {a: {v: -0.0343 m/s}, b: {x: -1.27 mm, v: 7.5 mm/s}}
run: {t_end: 0.1 s, every: 20 ms}
""")
    samples, *_ = truth(exact_parts(scene), 40)
    common = pytest.approx((2.1 * -0.0343 + 1.7 * 0.0075) / 3.8, rel=1e-15)
    assert samples["v_a"][-1] == samples["v_b"][-1] == common


def test_a_stop_that_passes_nothing_is_not_struck():
    """Turned round by a wall, a ball parts as the law asks from a body that it touches: by no impulse."""
    scene = scene_of("""
bodies: {body: 0.586 kg, ball: 0.787 kg}
stops:
  touched: {between: [body, ball], gap: 7.69 mm, acts: extension, law: rigid, e: 0.5}
  wall: {between: [ground, ball], gap: 7.69 mm, acts: extension, law: rigid, e: 0.5}
motor: {on: ball, m3: 0.4 kg, e: 2 cm, J: 4e-4 kg m^2, M0: 0.01 N m, Omega0: 9.4 rad/s}
initial: {ball: {x: 7.69 mm, v: 48.3 mm/s}, motor: {phi: 0.5 rad}}
run: {t_end: 10 ms, every: 10 ms}
""")
    for events in (run(scene).events, truth(exact_parts(scene), 40)[1]):
        assert events["part"][events["kind"] == EVENT_KINDS["impact"]].tolist() == [1]


@pytest.mark.parametrize(("wall", "moved"), (("ground", ""), ("base", "base: {a: 0.5 mm, omega: 2 rad/s}")))
def test_the_ledgers_have_what_the_end_of_a_chatter_gives_to_the_ground(wall, moved):
    """Friction ends it with 2e-7 m/s to go, at a wall that stands or at one that moves."""
    scene = scene_of(f"""{moved}
bodies: {{b: 0.57 kg}}
stops: {{wall: {{between: [b, {wall}], gap: 1 m, acts: compression, law: rigid, e: 0.8}}}}
friction: {{f: {{between: [b, {wall}], N: 0.32 N, mu: 1}}}}
forces: {{F: {{on: b, F0: 0.9 N}}}}
initial: {{b: {{x: 1 m, v: 4 cm/s}}}}
run: {{t_end: 1 s, every: 20 ms}}
""")
    fast = run(scene, momentum=True)
    assert fast.totals["chatter_speed"] > 1e-8
    assert abs(fast.totals["momentum_residual"]) < 1e-15 * len(fast.events["t"])
    assert abs(fast.totals["energy_residual"]) < 1e-17 * len(fast.events["t"])


def walls(restitutions, beyond=0.0, friction=0.0):
    """A ball that strikes walls at one place at once, each `beyond` [m] behind the one before; a force
    presses it on.
    """
    each = "wall{}: {{between: [ball, ground], gap: {} m, acts: compression, law: rigid, e: {}}}"
    stops = [each.format(i, 0.3 + i * beyond, e) for i, e in enumerate(restitutions)]
    return scene_of(f"""
bodies: {{ball: 1 kg}}
stops: {{{", ".join(stops)}}}
friction: {{f: {{between: [ball, ground], N: {friction} N, mu: 1}}}}
forces: {{F: {{on: ball, F0: 2 N}}}}
initial: {{ball: {{v: 0.7 m/s}}}}
run: {{t_end: 4 s, every: 20 ms}}
""")


@pytest.mark.parametrize(
    ("restitutions", "beyond", "doubted"),
    [((0.8, 0.3), np.spacing(0.3), True), ((0.8, 0.8), 0.0, False), ((0.8, 0.3), 0.0, False)],
)
def test_an_impact_is_in_doubt_where_the_order_of_two_makes_a_difference(restitutions, beyond, doubted):
    """Of walls struck in turn the first tells the speed behind; those at one place are struck at once."""
    fast = run(walls(restitutions, beyond))
    assert (fast.totals["uncertified"] > 0) == doubted


CUT_OFF = ("chatters", "chatter_time", "chatter_speed", "chatter_distance")


@pytest.mark.parametrize("friction", (0.0, 0.5))
@pytest.mark.parametrize("softer", ((0.7,), (0.3,), (0.0,), (0.3, 0.7)))
@pytest.mark.parametrize("first", (True, False))
def test_of_stops_at_one_place_the_hardest_decides(softer, first, friction):
    """L >= 0 and g'(after) <= -e g'(before) of all is the law of the greatest e alone."""
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
    """One passes the impulses, while rounding may tell that the other parts or not."""
    scene = scene_of(f"""
bodies: {{a: 0.8 kg, b: 0.35 kg}}
stops:
  one: {{between: [a, b], gap: 0 m, acts: compression, law: rigid, e: {e}}}
  twin: {{between: [b, a], gap: 0 m, acts: extension, law: rigid, e: {e}}}
forces: {{left: {{on: a, F0: 2 N}}, right: {{on: b, F0: -1.5 N}}}}
initial: {{a: {{v: 0.25 m/s}}, b: {{x: 2 mm, v: 0.2 m/s}}}}
run: {{t_end: 0.4 s, every: 20 ms}}
""")
    fast, single = run(scene), run(replace(scene, stops=scene.stops[:1]))
    for table in (single.events, fast.events, truth(exact_parts(scene), 40)[1]):
        assert table["t"][table["kind"] == EVENT_KINDS["chatter"]].size >= 1
    ends = [times(result, "rest_begin") for result in (single, fast)]
    assert len(ends[1]) == 2 and abs(ends[1] - ends[0]).max() < 1e-16
    assert fast.totals["chatter_time"] == single.totals["chatter_time"] > 0
    assert fast.totals["uncertified"] == 0


def test_friction_on_a_body_that_rests_on_the_one_that_hops_ends_the_chatter_too():
    """It turns round at the top of each hop of both, not at the struck body itself."""
    scene = scene_of("""
bodies: {front: 1 kg, back: 0.7 kg}
stops:
  wall: {between: [front, ground], gap: 1 m, acts: compression, law: rigid, e: 0.5}
  pair: {between: [back, front], gap: 0 m, acts: compression, law: rigid, e: 0}
friction: {f: {between: [back, ground], N: 0.8 N, mu: 1}}
forces: {F: {on: back, F0: 3 N}}
initial: {front: {x: 0.99 m, v: 0.1 m/s}, back: {x: 0.99 m, v: 0.1 m/s}}
run: {t_end: 0.6 s, every: 20 ms}
""")
    fast = run(scene, most=1000)
    assert fast.totals["chatters"] == 1 and fast.totals["uncertified"] == 0
    _, exact, *_ = truth(exact_parts(scene), 40)
    ends = [table["t"][table["kind"] == EVENT_KINDS["chatter"]][-1] for table in (fast.events, exact)]
    left_out = fast.totals["chatter_time"]
    assert abs(ends[0] + left_out - ends[1]) < left_out / 10


def test_friction_alone_ends_a_chatter_on_a_stop_that_loses_nothing():
    """e = 1: each hop is shorter by the root of what rises against and what friction leaves of the push."""
    scene = scene_of("""
bodies: {a: 1 kg}
stops: {wall: {between: [a, ground], gap: 1 cm, acts: compression, law: rigid, e: 1}}
friction: {f: {between: [a, ground], N: 0.5 N, mu: 1}}
forces: {F: {on: a, F0: 1.5 N}}
run: {t_end: 1 s, every: 20 ms}
""")
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
    """An elastic stop closes with each hop and lets go within it: the motion starts anew from roundings."""
    scene = scene_of(f"""
bodies: {{a: 1 kg}}
stops:
  wall: {{between: [a, ground], gap: 0.3 m, acts: compression, law: rigid, e: 0.8}}
  cushion: {{between: [a, ground], gap: -0.3 m, acts: extension, k: 5 N/m, c: {c} N s/m, release: force}}
forces: {{F: {{on: a, F0: 1.5 N}}}}
initial: {{a: {{x: 0.29 m, v: 0.1 m/s}}}}
run: {{t_end: 2 s, every: 20 ms}}
""")
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
    scene = scene_of(f"""
bodies: {{ball: 10 g}}
stops: {{table: {{between: [ball, base], gap: 0 m, acts: compression, law: rigid, e: {e}}}}}
base: {{a: {top} m, omega: 7.3 Hz, phase: 90 deg}}
initial: {{ball: {{x: {top} m, v: {-leap} m/s}}}}
run: {{t_end: 1 s, every: 20 ms}}
""")
    fast = run(scene, most=1000)
    assert fast.totals["uncertified"] == 0 and fast.totals["chatters"] >= 1
    end = fast.events["t"][fast.events["kind"] == EVENT_KINDS["chatter"]][0]
    assert end == pytest.approx(2 * leap / (top * omega**2) / (1 - e), rel=1e-6)

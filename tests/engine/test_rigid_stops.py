"""Impacts on rigid stops and what follows them, against mechanics."""

from math import acos, cos, log, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.impacts import GRAVITY, METHODS, SHAKEN, ball, column, times
from tests.engine.random_parts import rigid_scenes
from tests.engine.runs import outcome, run, scene_of
from tests.engine.test_restart import assert_restarts
from vibsim.engine.columns import state_columns
from vibsim.engine.modes.status import RESTING
from vibsim.engine.tangent.error_growth import _kick
from vibsim.physics.parts import EVENT_KINDS


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("e", (0.0, 0.3, 0.5, 0.8, 0.95))
def test_ball_on_a_table_comes_to_rest(e, method):
    """After sqrt(2 h / g) (1 + e) / (1 - e), all energy m g h lost in the stop, and m g t of momentum to the
    ground, at rest or not.

    Each event time is rounded to the grid, and each rounding of a later one adds; what is left out is at most
    `chatter_time`.
    """
    end = sqrt(2 / GRAVITY) * (1 + e) / (1 - e)
    result = run(ball(e, method=method, t_end=1.2 * end), ledger=True, momentum=True)
    totals, rest = result.totals, times(result, "rest_begin")
    unit, count = np.spacing(end), totals["impacts"]
    assert len(rest) == totals["rests"] == 1
    assert abs(rest[0] - end) <= totals["chatter_time"] + (8 + 4 * sqrt(count) / (1 - e)) * unit
    assert totals["chatter_time"] <= 8 * unit + 2 * unit / (1 - e)
    assert totals["chatters"] == (e > 0)
    if e > 0:  # a speed e^n v, down to where 2 v / g is below the resolution of time
        v = sqrt(2 * GRAVITY)
        least = log(max(2, 8 * (1 - e)) * unit * GRAVITY / (2 * v)) / log(e)
        assert abs(count - least) <= 1 + 0.7 / abs(log(e))
        assert column(result, "impact", "before_v_ball") == pytest.approx(
            -v * e ** np.arange(count), rel=1e-13
        )
        assert totals["chatter_distance"] == pytest.approx(
            totals["chatter_speed"] ** 2 / (2 * GRAVITY), rel=1e-6
        )
        assert totals["chatter_speed"] ** 2 < 2.0**-53 * 2 * GRAVITY
    assert result.samples["x_ball"].min() >= -1e-15
    assert (result.samples["x_ball"][result.samples["time"] > end] == 0).all()
    assert (result.samples["floor"][result.samples["time"] > end] == 3).all()
    rounding = 4 * count * 2.0**-53  # of a sum of as many losses
    for name in ("loss.stops.floor", "work.forces.weight"):
        assert totals[name] == pytest.approx(2 * GRAVITY, rel=rounding)
    assert totals["impulse.ground"] == pytest.approx(2 * GRAVITY * 1.2 * end, rel=rounding)
    assert totals["energy_end"] == totals["momentum_end"] == totals["uncertified"] == 0
    assert abs(totals["energy_residual"]) < 1e-13
    assert abs(totals["momentum_residual"]) < 1e-12


BETWEEN_WALLS = """
bodies: {m: 1 kg}
stops:
  left: {between: [m, ground], gap: 1 m, acts: extension, law: rigid, e: 0.3}
  right: {between: [m, ground], gap: 1 m, acts: compression, law: rigid, e: 0.3}
friction: {f: {between: [m, ground], N: 0.5 N, mu: 1}}
initial: {m: {v: 5 m/s}}
run: {t_end: 10 s, every: 250 ms}
"""


@pytest.mark.parametrize("method", METHODS)
def test_mass_between_two_stops_with_dry_friction(method):
    """e = 0.3, friction 0.5 N, free way 2 m: v^2 falls by 2 mu s per way, v by e per impact."""
    result = run(scene_of(BETWEEN_WALLS, method=method), ledger=True)
    first = sqrt(25 - 2 * 0.5)
    second = sqrt((0.3 * first) ** 2 - 2 * 0.5 * 2)
    assert column(result, "impact", "before_v_m") == pytest.approx([first, -second], rel=1e-14)
    assert times(result, "stick_begin") == pytest.approx(
        [(5 - first) / 0.5 + (0.3 * first - second) / 0.5 + 0.3 * second / 0.5]
    )
    assert result.totals["loss.friction.f"] == pytest.approx(0.5 * (1 + 2 + (0.3 * second) ** 2 / (2 * 0.5)))
    assert abs(result.totals["energy_residual"]) < 1e-14


def test_rotor_takes_part_in_an_impact():
    """Energy is kept at e = 1 and the momentum of the rotor's angle: the impact acts along the line alone."""
    scene = scene_of("""
bodies: {m: 2 kg}
stops: {wall: {between: [m, ground], gap: 5 cm, acts: compression, law: rigid, e: 1}}
motor: {on: m, m3: 0.3 kg, e: 5 cm, J: 0.002 kg m^2, M0: 0 N m, Omega0: 50 rad/s}
initial: {m: {v: 0.5 m/s}, motor: {phi: 1 rad, phidot: 20 rad/s}}
run: {t_end: 2 s, every: 250 ms}
""")
    result = run(scene, ledger=True, momentum=True)
    assert result.totals["impacts"] >= 1
    names = ("before_phidot", "phidot", "phase", "before_v_m")
    before, after, phase, v = (column(result, "impact", name)[0] for name in names)
    inertia, coupling = 0.002 + 0.3 * 0.05**2, 0.3 * 0.05 * sin(phase)
    assert after == pytest.approx(before + coupling / inertia * (-2 * v), rel=1e-13)
    assert result.totals["loss.stops.wall"] == pytest.approx(0.0, abs=1e-15)
    assert abs(result.totals["energy_residual_relative"]) < 1e-14
    assert abs(result.totals["momentum_residual_relative"]) < 1e-14


def test_struck_body_that_stuck_slips_at_once():
    """The hammer strikes a block at rest on the floor: e = 0.5, the block slides v^2 / (2 mu g)."""
    scene = scene_of("""
bodies: {hammer: 1 kg, block: 3 kg}
stops: {face: {between: [hammer, block], gap: 0 m, acts: compression, law: rigid, e: 0.5}}
friction: {floor: {between: [block, ground], N: 3 N, mu: 1}}
initial: {hammer: {x: -0.5 m, v: 2 m/s}}
run: {t_end: 3 s, every: 250 ms}
""")
    result = run(scene, ledger=True)
    v = 1.5 * 2.0 / 4
    kinds = [EVENT_KINDS[kind] for kind in ("impact", "stick_end", "stick_begin")]
    assert result.events["kind"][1:4].tolist() == kinds
    assert result.events["v_block"][1] == pytest.approx(v, rel=1e-15)
    assert result.samples["x_block"][-1] == pytest.approx(v * v / 2, rel=1e-14)


def test_start_that_closes_is_struck_at_once():
    scene = scene_of("""
bodies: {m: 1 kg}
stops: {floor: {between: [ground, m], gap: 0 m, acts: compression, law: rigid, e: 0.5}}
initial: {m: {v: -2 m/s}}
run: {t_end: 1 s, every: 250 ms}
""")
    result = run(scene)
    assert times(result, "impact").tolist() == [0.0]
    assert result.samples["x_m"][-1] == 1.0
    assert result.events["v_m"][0] == -2.0 and result.events["v_m"][1] == 1.0


def test_a_run_with_chatter_rest_and_release_goes_on_from_each_event():
    scene = scene_of(SHAKEN, {"table.e": 0.3, "ball.x": "1 cm"})
    result = run(scene)
    assert result.totals["chatters"] > 0 and len(times(result, "rest_end")) > 1
    assert_restarts(scene)


@settings(max_examples=25)
@given(rigid_scenes())
def test_random_scenes_keep_out_of_rigid_stops_and_close_their_ledgers(scene):
    # some hop through 1e8 impacts in a tenth of a second, and then nothing is said of the rest
    result = outcome(scene, most=2000, ledger=True, momentum=True)
    if isinstance(result, str):
        assert "caught between rigid stops" in result
        return
    t = result.samples["time"]
    places = [result.samples[f"x_b{i}"] for i in range(len(scene.bodies))]
    places += [sum((h.amplitude * np.sin(h.omega * t + h.phase) for h in scene.base), 0 * t), 0 * t]
    for _, stop in scene.rigid_stops:
        depth = stop.sense * (places[stop.Q] - places[stop.P]) - stop.gap
        assert depth.max() < 1e-14
    assert abs(result.totals["energy_residual"]) < 1e-13  # rounding of joules and newton seconds, which are
    assert abs(result.totals["momentum_residual"]) < 1e-13  # about 1 here, in some hundred stretches


# Bodies that rest on rigid stops: where rest begins, what moves with them, and where they leave.


@pytest.mark.parametrize("method", METHODS)
def test_rest_ends_where_the_table_falls_faster_than_the_ball(method):
    """X = a sin(nu t): rest ends where -X'' = g, sin(nu t) = g / (a nu^2); then free flight."""
    a, nu = 0.02, 30.0
    result = run(scene_of(SHAKEN, method=method), ledger=True, momentum=True)
    release = np.arcsin(GRAVITY / (a * nu * nu)) / nu
    assert times(result, "rest_end")[0] == pytest.approx(release, rel=1e-13)
    t = times(result, "impact")[0] - release
    height = a * sin(nu * release) + a * nu * cos(nu * release) * t - GRAVITY * t * t / 2
    assert height == pytest.approx(a * sin(nu * times(result, "impact")[0]), abs=1e-15)
    assert abs(result.totals["energy_residual"]) < 1e-14
    assert abs(result.totals["momentum_residual"]) < 1e-14
    assert result.totals["uncertified"] == 0


THROWN_UP = """
bodies: {low: 1 kg, high: 1 kg}
links: {s: {between: [low, high], k: 500 N/m}}
stops: {floor: {between: [ground, low], gap: 0 m, acts: compression, law: rigid, e: 0.5}}
forces: {w_low: {on: low, F0: -9.81 N}, w_high: {on: high, F0: -9.81 N}}
initial: {high: {x: -8 cm}}
run: {t_end: 0.3 s, every: 50 ms}
"""


@pytest.mark.parametrize("method", METHODS)
def test_ball_thrown_up_by_its_spring_leaves_the_floor_with_it(method):
    """Two balls on a spring, the lower on the floor: it is lifted where the spring pulls by its weight."""
    result = run(scene_of(THROWN_UP, method=method), ledger=True)
    w, still = sqrt(500.0), -GRAVITY / 500.0  # high oscillates about `still` until k x = m g
    lift = acos((GRAVITY / 500.0 - still) / (-0.08 - still)) / w
    assert times(result, "rest_end")[0] == pytest.approx(lift, rel=1e-14)
    assert abs(result.totals["energy_residual"]) < 1e-14


PUSHED = """
bodies: {a: 1 kg, b: 3 kg}
stops: {touch: {between: [a, b], gap: 0 m, acts: compression, law: rigid, e: 0}}
forces: {F: {on: a, A: 4 N, omega: 2 rad/s, phase: 90 deg}}
run: {t_end: 1.5 s, every: 250 ms}
"""


@pytest.mark.parametrize("method", METHODS)
def test_touching_bodies_move_as_one_while_they_are_pushed(method):
    """A force pushes a, which pushes b: one body of both masses; b leaves where the force changes sign."""
    result, omega = run(scene_of(PUSHED, method=method), momentum=True, ledger=True), 2.0
    assert times(result, "rest_end") == pytest.approx([pi / 2 / omega], rel=1e-14)
    t = result.samples["time"]
    together = t < pi / 2 / omega
    expected = 1.0 / omega**2 * (1 - np.cos(omega * t))
    assert np.abs(result.samples["x_a"] - expected)[together].max() < 1e-15
    assert np.array_equal(result.samples["x_a"][together], result.samples["x_b"][together])
    assert result.samples["v_b"][-1] == pytest.approx(1.0 / omega, rel=1e-14)
    assert abs(result.totals["momentum_residual"]) < 1e-15


@pytest.mark.parametrize(("load", "code"), ((-1.0, 3), (1.0, 0), (0.0, 3)))
def test_start_on_a_stop_is_rest_or_flight_by_its_load(load, code):
    scene = scene_of(f"""
bodies: {{m: 1 kg}}
stops: {{floor: {{between: [ground, m], gap: 0 m, acts: compression, law: rigid, e: 0.7}}}}
forces: {{F: {{on: m, F0: {load} N}}}}
run: {{t_end: 1 s, every: 250 ms}}
""")
    result = run(scene)
    assert result.samples["floor"].tolist()[0] == code
    assert result.samples["x_m"][-1] == pytest.approx(max(load, 0) / 2)
    assert result.totals["impacts"] == 0


def test_two_stacked_balls_come_to_rest():
    scene = scene_of("""
bodies: {low: 1 kg, high: 0.4 kg}
stops:
  floor: {between: [ground, low], gap: 0 m, acts: compression, law: rigid, e: 0.6}
  between: {between: [low, high], gap: -10 cm, acts: compression, law: rigid, e: 0.7}
forces: {w_low: {on: low, F0: -9.81 N}, w_high: {on: high, F0: -3.924 N}}
initial: {low: {x: 0.5 m}, high: {x: 0.8 m}}
run: {t_end: 8 s, every: 50 ms}
""")
    result = run(scene, ledger=True, momentum=True)
    assert result.samples["floor"][-1] == result.samples["between"][-1] == 3
    assert result.samples["x_low"][-1] == 0.0
    assert result.samples["x_high"][-1] == pytest.approx(0.1, abs=1e-15)
    assert abs(result.totals["energy_residual"]) < 1e-13


def test_no_kick_pushes_a_body_through_the_stop_that_it_rests_on():
    """How errors grow is told by kicks at events: a resting body keeps the velocity of what it rests on."""
    case = ball(0.5, t_end=5.0)
    result = run(case)
    row = {name: column[-1] for name, column in result.events.items()}
    scale = {name: float(np.abs(result.events[name]).max()) for name in state_columns(case)}
    assert row["floor"] == RESTING and scale["v_ball"] > 1
    assert list(_kick(case, row, scale)) == ["x_ball"]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("e", (0.0, 0.5))
def test_letting_go_is_no_grazing(method, e):
    """A ball on a table that shakes harder than gravity holds it down: where it leaves there is no turn."""
    shaken = {
        "ball.x": "6 cm",
        "ball.v": 0,
        "base.a": "5 cm",
        "base.omega": "2.6 Hz",
        "base.phase": "0.5 rad",
    }
    found = run(scene_of(SHAKEN, {**shaken, "table.e": e}, method=method, t_end=3))
    assert len(times(found, "rest_end")) > 4
    assert np.isnan(found.totals["grazing_margin"])


SEATED = """
bodies: {seated: 1 kg, ball: 1 kg}
stops:
  seat: {between: [seated, base], gap: 0 m, acts: extension, law: rigid, e: 0}
  floor: {between: [ground, ball], gap: 0 m, acts: compression, law: rigid, e: 0.95}
forces: {w_seated: {on: seated, F0: -9.81 N}, w_ball: {on: ball, F0: -9.81 N}}
base: {a: 2 cm, omega: 7 rad/s}
initial: {seated: {v: 0.14 m/s}, ball: {x: 0.3 m}}
run: {t_end: 12 s, every: 250 ms}
"""


@pytest.mark.parametrize("e", (0.0, 0.5))
@pytest.mark.parametrize("method", METHODS)
def test_what_rests_on_a_shaken_base_is_not_struck_where_an_impact_falls_elsewhere(method, e):
    """Velocities of base and body are computed apart: what they differ by is rounding, not an approach."""
    result = run(scene_of(SEATED, {"seat.e": e}, method=method))
    assert len(times(result, "impact", 0)) == len(times(result, "transmitted")) == 0
    assert len(times(result, "impact", 1)) > 100 and len(times(result, "chatter")) == 1
    assert result.totals["rests"] == 1 and result.totals["uncertified"] == 0

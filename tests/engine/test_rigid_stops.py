"""Impacts on rigid stops and what follows them, against mechanics."""

from math import log, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.impacts import GRAVITY, METHODS, SHAKEN, ball, column, times
from tests.engine.random_parts import rigid_scenes
from tests.engine.runs import outcome, run, scene_of
from tests.engine.test_restart import assert_restarts
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

"""Impacts on rigid stops and what follows them, against mechanics and published numbers."""

from math import log, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.impacts import GRAVITY, METHODS, ball, column, cosine, floor, scene, times, weights
from tests.engine.random_parts import rigid_scenes
from tests.engine.runs import outcome, run
from vibsim.physics.parts import (
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
)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("e", (0.0, 0.3, 0.8, 0.95))
def test_ball_on_a_table_comes_to_rest(e, method):
    """After sqrt(2 h / g) (1 + e) / (1 - e), all energy m g h lost in the stop.

    Each event time is rounded to the grid, and each rounding of a later one adds; what is left out is at most
    `chatter_time`.
    """
    end = sqrt(2 / GRAVITY) * (1 + e) / (1 - e)
    result = run(ball(e, method=method, t_end=1.2 * end), ledger=True, momentum=True)
    rest = times(result, "rest_begin")
    unit, count = np.spacing(end), result.totals["impacts"]
    assert len(rest) == result.totals["rests"] == 1
    assert abs(rest[0] - end) <= result.totals["chatter_time"] + (8 + 4 * sqrt(count) / (1 - e)) * unit
    assert result.totals["chatter_time"] <= 8 * unit + 2 * unit / (1 - e)
    assert result.totals["chatters"] == (e > 0)
    if e > 0:  # a speed e^n v, down to where 2 v / g is below the resolution of time
        v = sqrt(2 * GRAVITY)
        least = log(max(2, 8 * (1 - e)) * unit * GRAVITY / (2 * v)) / log(e)
        assert abs(count - least) <= 1 + 0.7 / abs(log(e))
        assert column(result, "impact", "before_v_ball") == pytest.approx(
            -v * e ** np.arange(count), rel=1e-13
        )
    assert result.samples["x_ball"].min() >= -1e-15
    assert (result.samples["x_ball"][result.samples["time"] > end] == 0).all()
    assert (result.samples["floor"][result.samples["time"] > end] == 3).all()
    assert result.totals["loss.stops.floor"] == pytest.approx(2 * GRAVITY, rel=1e-14)
    assert abs(result.totals["energy_residual"]) < 1e-13
    assert abs(result.totals["momentum_residual"]) < 1e-12
    assert result.totals["uncertified"] == 0


def test_no_loss_keeps_energy_over_ten_thousand_impacts():
    h = 1e-3
    period = 2 * sqrt(2 * h / GRAVITY)
    result = run(ball(1.0, h, t_end=10_000 * period, every_den=1))
    assert result.totals["impacts"] == 10_000
    speeds = np.abs(column(result, "impact", "v_ball"))
    assert np.ptp(speeds) == 0.0 or np.ptp(speeds) / speeds[0] < 1e-12
    assert speeds[-1] == pytest.approx(sqrt(2 * GRAVITY * h), rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_two_balls_and_a_spring(method):
    """First bounces by an independent solver: nosnoc's example, m = 1 kg, k = 10 kN/m, e = 0.8."""
    bodies = [Body("low", 1.0, 0.0, 0.0), Body("high", 1.0, 0.0, 0.0)]
    parts = {"links": (Link("s", 0, 1, 1e4, 0.0),), "stops": (floor(0, 0.8, radius=-0.8),)}
    result = run(scene(bodies, method, forces=weights(bodies), t_end=1.0, **parts), ledger=True)
    assert times(result, "impact")[:2] == pytest.approx([0.4038550218769, 0.4233169688147], abs=1e-13)
    assert abs(result.totals["energy_residual"]) < 1e-12


def budd_dux(sigma, method="auto", omega=3.7, e=0.8, periods=200):
    T = 2 * 2 * pi / omega
    return scene(
        [Body("m", 1.0, 0.0, 0.0)],
        method,
        links=(Link("s", 0, GROUND, 1.0, 0.0),),
        stops=(RigidStop("wall", 0, GROUND, sigma, COMPRESSION, e),),
        forces=(Force("F", 0, 0.0, (cosine(1.0, omega),)),),
        t_end=periods * T,
        every_den=1,
    )


@pytest.mark.parametrize("method", METHODS)
def test_one_impact_in_two_periods_of_budd_and_dux(method):
    """x'' + x = cos(3.7 t), stop at 0, e = 0.8; speed by their closed form, contracting by e per impact."""
    result = run(budd_dux(0.0, method))
    assert column(result, "impact", "before_v_m")[-5:] == pytest.approx(5 * [0.66569335283999], abs=1e-13)
    assert result.totals["uncertified"] == 0


def test_oscillator_of_recipes_for_continuation():
    """Example 15.2: x'' + 0.1 x' + x = cos t, stop at 1, e = 0.8: speed and phase of the impact."""
    parts = {
        "links": (Link("s", 0, GROUND, 1.0, 0.1),),
        "stops": (RigidStop("wall", 0, GROUND, 1.0, COMPRESSION, 0.8),),
        "forces": (Force("F", 0, 0.0, (cosine(1.0, 1.0),)),),
    }
    result = run(scene([Body("m", 1.0, 0.0, 0.0)], t_end=600.0, every_den=1, **parts))
    assert column(result, "impact", "before_v_m")[-3:] == pytest.approx(3 * [1.695732937594882], abs=1e-13)
    phase = times(result, "impact")[-1] % (2 * pi)
    assert phase == pytest.approx(0.0759521649383, abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_mass_between_two_stops_with_dry_friction(method):
    """e = 0.3, friction 0.5 N, free way 2 m: v^2 falls by 2 mu s per way, v by e per impact."""
    stops = (
        RigidStop("left", 0, GROUND, 1.0, EXTENSION, 0.3),
        RigidStop("right", 0, GROUND, 1.0, COMPRESSION, 0.3),
    )
    parts = {"stops": stops, "frictions": (Friction("f", 0, GROUND, 0.5, 0.5, 0.0),)}
    result = run(scene([Body("m", 1.0, 0.0, 5.0)], method, **parts), ledger=True)
    first = sqrt(25 - 2 * 0.5)
    second = sqrt((0.3 * first) ** 2 - 2 * 0.5 * 2)
    assert column(result, "impact", "before_v_m") == pytest.approx([first, -second], rel=1e-14)
    assert times(result, "stick_begin") == pytest.approx(
        [(5 - first) / 0.5 + (0.3 * first - second) / 0.5 + 0.3 * second / 0.5]
    )
    assert result.totals["loss.friction.f"] == pytest.approx(0.5 * (1 + 2 + (0.3 * second) ** 2 / (2 * 0.5)))
    assert abs(result.totals["energy_residual"]) < 1e-14


def test_rotor_takes_part_in_a_impact():
    """Energy is kept at e = 1 and the momentum of the rotor's angle: the impact acts along the line alone."""
    motor = Motor(0, 0.3, 0.05, 0.002, 0.0, 50.0, 1.0, 20.0)
    wall = RigidStop("wall", 0, GROUND, 0.05, COMPRESSION, 1.0)
    result = run(
        scene([Body("m", 2.0, 0.0, 0.5)], stops=(wall,), motor=motor, t_end=2.0), ledger=True, momentum=True
    )
    assert result.totals["impacts"] >= 1
    rows = result.events["kind"] == EVENT_KINDS["impact"]
    before, after = result.events["before_phidot"][rows][0], result.events["phidot"][rows][0]
    phase, v = result.events["phase"][rows][0], result.events["before_v_m"][rows][0]
    inertia, coupling = 0.002 + 0.3 * 0.05**2, 0.3 * 0.05 * sin(phase)
    assert after == pytest.approx(before + coupling / inertia * (-2 * v), rel=1e-13)
    assert result.totals["loss.stops.wall"] == pytest.approx(0.0, abs=1e-15)
    assert abs(result.totals["energy_residual_relative"]) < 1e-14
    assert abs(result.totals["momentum_residual_relative"]) < 1e-14


def test_struck_body_that_stuck_slips_at_once():
    """The hammer strikes a block at rest on the floor: e = 0.5, the block slides v^2 / (2 mu g)."""
    bodies = [Body("hammer", 1.0, -0.5, 2.0), Body("block", 3.0, 0.0, 0.0)]
    stops = (RigidStop("face", 0, 1, 0.0, COMPRESSION, 0.5),)
    rub = (Friction("floor", 1, GROUND, 3.0, 3.0, 0.0),)
    result = run(scene(bodies, stops=stops, frictions=rub, t_end=3.0), ledger=True)
    v = 1.5 * 2.0 / 4
    assert [int(k) for k in result.events["kind"][1:4]] == [
        EVENT_KINDS[k] for k in ("impact", "stick_end", "stick_begin")
    ]
    assert result.events["v_block"][1] == pytest.approx(v, rel=1e-15)
    assert result.samples["x_block"][-1] == pytest.approx(v * v / 2, rel=1e-14)


def test_start_that_closes_is_struck_at_once():
    result = run(scene([Body("m", 1.0, 0.0, -2.0)], stops=(floor(0, 0.5),), t_end=1.0))
    assert times(result, "impact").tolist() == [0.0]
    assert result.samples["x_m"][-1] == 1.0
    assert result.events["v_m"][0] == -2.0 and result.events["v_m"][1] == 1.0


def test_parts_of_a_run_join_bit_for_bit():
    """Going on from each event of a run with chatter, rest and release gives the rest of it."""
    a, nu = 0.02, 30.0
    bodies = [Body("ball", 1.5, 0.01, a * nu)]
    base = (Harmonic(a, nu, nu / (2 * pi), 0.0, 0.0),)
    table = RigidStop("table", BASE, 0, 0.0, COMPRESSION, 0.3)
    whole = scene(bodies, stops=(table,), forces=weights(bodies), base=base, t_end=1.0)
    result = run(whole)
    assert result.totals["chatters"] > 0 and len(times(result, "rest_end")) > 1
    names = list(result.events)
    starts = [i for i, t in enumerate(result.events["t"]) if t not in result.events["t"][i + 1 :]][:-1]
    for i in starts[:: max(1, len(starts) // 12)]:
        t = result.events["t"][i]
        rows = [
            {name: result.events[name][k] for name in names} for k in np.flatnonzero(result.events["t"] == t)
        ]
        again = run(whole, resume=rows)
        for name in names:
            assert np.array_equal(again.events[name][1:], result.events[name][i + 1 :]), (name, i)


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

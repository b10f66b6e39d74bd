"""Rigid stops: impacts, rest and the ends of infinite sequences of impacts, against mechanics and published
numbers.
"""

from dataclasses import replace
from math import acos, cos, log, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.random_parts import rigid_scenes
from tests.engine.runs import outcome, run
from vibsim.cases import load_case
from vibsim.engine.columns import state_columns
from vibsim.engine.modes.status import RESTING
from vibsim.engine.tangent.error_growth import _kick
from vibsim.physics.modes import EVENT_KINDS, EVENT_NAMES
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    EXTENSION,
    GROUND,
    Body,
    Clearance,
    Force,
    Friction,
    Harmonic,
    Link,
    Motor,
    RigidStop,
    Scene,
    Stop,
)
from vibsim.results.simulation import simulate

METHODS = ("auto", "taylor")
GRAVITY = 9.81


def scene(bodies, method="auto", **parts):
    return Scene(tuple(bodies), method=method, **{"t_end": 10.0, "every_den": 4, **parts})


def weights(bodies):
    return tuple(Force(f"w_{b.name}", i, -b.m * GRAVITY, ()) for i, b in enumerate(bodies))


def floor(i, e, name="floor", radius=0.0):
    return RigidStop(name, GROUND, i, -radius, COMPRESSION, e)


def cosine(amplitude, omega):
    return Harmonic(amplitude, omega, omega / (2 * pi), 0.0, pi / 2)


def times(result, kind, part=None):
    rows = result.events["kind"] == EVENT_KINDS[kind]
    return result.events["t"][rows if part is None else rows & (result.events["part"] == part)]


def column(result, kind, name):
    return result.events[name][result.events["kind"] == EVENT_KINDS[kind]]


def ball(e, h=1.0, method="auto", **parts):
    bodies = [Body("ball", 2.0, h, 0.0)]
    return scene(bodies, method, stops=(floor(0, e),), forces=weights(bodies), **parts)


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
def test_three_balls(method):
    """One ball meets two that touch: (1, 0, 0) becomes (-1/3, 2/3, 2/3) by the Newton-Moreau law."""
    bodies = [Body("a", 1.0, -1.0, 1.0), Body("b", 1.0, 0.0, 0.0), Body("c", 1.0, 0.0, 0.0)]
    stops = (RigidStop("ab", 0, 1, 0.0, COMPRESSION, 1.0), RigidStop("bc", 1, 2, 0.0, COMPRESSION, 1.0))
    result = run(scene(bodies, method, stops=stops, t_end=3.0), ledger=True, momentum=True)
    assert result.events["kind"].tolist() == [0, EVENT_KINDS["impact"], EVENT_KINDS["transmitted"], 8]
    after = [result.samples[f"v_{name}"][-1] for name in "abc"]
    assert after == pytest.approx([-1 / 3, 2 / 3, 2 / 3], rel=1e-15)
    assert after[1] == after[2]
    assert result.totals["transmitted"] == 1 and result.totals["rests"] == 0
    assert result.events["before_v_a"][1] == 1.0
    assert abs(result.totals["energy_residual"]) < 1e-15


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


@pytest.mark.parametrize("method", METHODS)
def test_rest_ends_where_the_table_falls_faster_than_the_ball(method):
    """X = a sin(nu t): rest ends where -X'' = g, sin(nu t) = g / (a nu^2); then free flight."""
    a, nu = 0.02, 30.0
    bodies = [Body("ball", 1.5, 0.0, a * nu)]
    base = (Harmonic(a, nu, nu / (2 * pi), 0.0, 0.0),)
    table = RigidStop("table", BASE, 0, 0.0, COMPRESSION, 0.0)
    result = run(
        scene(bodies, method, stops=(table,), forces=weights(bodies), base=base, t_end=1.0),
        ledger=True,
        momentum=True,
    )
    release = np.arcsin(GRAVITY / (a * nu * nu)) / nu
    assert times(result, "rest_end")[0] == pytest.approx(release, rel=1e-13)
    t = times(result, "impact")[0] - release
    height = a * sin(nu * release) + a * nu * cos(nu * release) * t - GRAVITY * t * t / 2
    assert height == pytest.approx(a * sin(nu * times(result, "impact")[0]), abs=1e-15)
    assert abs(result.totals["energy_residual"]) < 1e-14
    assert abs(result.totals["momentum_residual"]) < 1e-14
    assert result.totals["uncertified"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_ball_thrown_up_by_its_spring_leaves_the_floor_with_it(method):
    """Two balls on a spring, the lower on the floor: it is lifted where the spring pulls by its weight."""
    k, m = 500.0, 1.0
    squeeze = 0.08
    bodies = [Body("low", m, 0.0, 0.0), Body("high", m, -squeeze, 0.0)]
    parts = {"links": (Link("s", 0, 1, k, 0.0),), "stops": (floor(0, 0.5),)}
    result = run(scene(bodies, method, forces=weights(bodies), t_end=0.3, **parts), ledger=True)
    w, still = sqrt(k / m), -m * GRAVITY / k  # high oscillates about `still` until k x = m g
    lift = acos((m * GRAVITY / k - still) / (-squeeze - still)) / w
    assert times(result, "rest_end")[0] == pytest.approx(lift, rel=1e-14)
    assert abs(result.totals["energy_residual"]) < 1e-14


@pytest.mark.parametrize("method", METHODS)
def test_touching_bodies_move_as_one_while_they_are_pushed(method):
    """A force pushes a, which pushes b: one body of both masses; b leaves where the force changes sign."""
    bodies = [Body("a", 1.0, 0.0, 0.0), Body("b", 3.0, 0.0, 0.0)]
    omega = 2.0
    drive = Force("F", 0, 0.0, (cosine(4.0, omega),))
    touch = RigidStop("touch", 0, 1, 0.0, COMPRESSION, 0.0)
    result = run(
        scene(bodies, method, stops=(touch,), forces=(drive,), t_end=1.5), momentum=True, ledger=True
    )
    assert times(result, "rest_end") == pytest.approx([pi / 2 / omega], rel=1e-14)
    t = result.samples["time"]
    together = t < pi / 2 / omega
    expected = 1.0 / omega**2 * (1 - np.cos(omega * t))
    assert np.abs(result.samples["x_a"] - expected)[together].max() < 1e-15
    assert np.array_equal(result.samples["x_a"][together], result.samples["x_b"][together])
    assert result.samples["v_b"][-1] == pytest.approx(1.0 / omega, rel=1e-14)
    assert abs(result.totals["momentum_residual"]) < 1e-15


def test_rotor_takes_part_in_a_blow():
    """Energy is kept at e = 1 and the momentum of the rotor's angle: the blow acts along the line alone."""
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


@pytest.mark.parametrize("wall", (False, True))
def test_rotor_takes_part_in_the_end_of_chatter(wall):
    """Friction ends the hops at some 1e-7 m/s, which come to rest: the momentum of the line is kept, or the
    wall takes it (no ledger has what chatter left out), and that of the rotor's angle is kept.
    """
    m, m3, e, J = 0.3, 0.14, 0.02, 2.4e-4
    bodies = [Body("a", m, 0.0, -0.2), Body("b", 0.31, 0.0, 0.3)]
    forces = (Force("A", 0, 1.0, ()), Force("B", 1, 0.0 if wall else -1.0, ()))
    result = run(
        scene(
            bodies,
            stops=(RigidStop("face", 0, GROUND if wall else 1, 0.01, COMPRESSION, 0.5),),
            frictions=(Friction("rub", 0, GROUND if wall else 1, 0.1, 0.1, 0.0),),
            forces=forces,
            motor=Motor(0, m3, e, J, 0.007, 20.0, 1.0, 15.0),
            t_end=0.6,
        ),
        momentum=True,
    )
    ends = {name: column(result, "chatter", name) for name in result.events}
    assert len(ends["t"])
    speed = np.abs(ends["before_v_a"] - (0.0 if wall else ends["before_v_b"]))
    assert (speed > 1e-8).all()  # large against rounding
    inertia, coupling = J + m3 * e * e, m3 * e * np.sin(ends["phase"])
    before, after = (
        inertia * ends[w] - coupling * ends[v]
        for w, v in (("before_phidot", "before_v_a"), ("phidot", "v_a"))
    )
    assert after == pytest.approx(before, abs=1e-15 * inertia * 20)
    assert wall or abs(result.totals["momentum_residual_relative"]) < 1e-14


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


def test_start_on_a_stop_is_rest_or_flight_by_its_load():
    for load, code in ((-1.0, 3), (1.0, 0), (0.0, 3)):
        body = [Body("m", 1.0, 0.0, 0.0)]
        result = run(scene(body, stops=(floor(0, 0.7),), forces=(Force("F", 0, load, ()),), t_end=1.0))
        assert result.samples["floor"].tolist()[0] == code
        assert result.samples["x_m"][-1] == pytest.approx(max(load, 0) / 2)
        assert result.totals["impacts"] == 0


def test_start_that_closes_is_struck_at_once():
    result = run(scene([Body("m", 1.0, 0.0, -2.0)], stops=(floor(0, 0.5),), t_end=1.0))
    assert times(result, "impact").tolist() == [0.0]
    assert result.samples["x_m"][-1] == 1.0
    assert result.events["v_m"][0] == -2.0 and result.events["v_m"][1] == 1.0


@pytest.mark.parametrize("method", METHODS)
def test_body_crushed_between_walls_that_close(method):
    """Two heavy walls close on a light ball, e = 0.5: bounces without end in a finite time, then all move as
    one with the momentum of all.
    """
    bodies = [Body("l", 100.0, 0.0, 1.0), Body("ball", 1.0, 0.3, 0.0), Body("r", 100.0, 1.0, -1.0)]
    stops = (RigidStop("a", 0, 1, 0.0, COMPRESSION, 0.5), RigidStop("b", 1, 2, 0.0, COMPRESSION, 0.5))
    result = run(scene(bodies, method, stops=stops, t_end=3.0), ledger=True, momentum=True)
    gaps = result.samples["x_ball"] - result.samples["x_l"], result.samples["x_r"] - result.samples["x_ball"]
    assert min(gap.min() for gap in gaps) > -1e-15
    assert abs(result.totals["momentum_residual"]) < 1e-13
    assert abs(result.totals["energy_residual"]) < 1e-12
    assert result.totals["impacts"] < 200


def test_two_stacked_balls_come_to_rest():
    bodies = [Body("low", 1.0, 0.5, 0.0), Body("high", 0.4, 0.8, 0.0)]
    stops = (floor(0, 0.6), RigidStop("between", 0, 1, -0.1, COMPRESSION, 0.7))
    result = run(
        scene(bodies, stops=stops, forces=weights(bodies), t_end=8.0, every_den=20),
        ledger=True,
        momentum=True,
    )
    assert result.samples["floor"][-1] == result.samples["between"][-1] == 3
    assert result.samples["x_low"][-1] == 0.0
    assert result.samples["x_high"][-1] == pytest.approx(0.1, abs=1e-15)
    assert abs(result.totals["energy_residual"]) < 1e-13


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


def test_digits_agree_with_doubles():
    from vibsim.engine.truth import open_truth

    case = ball(0.8, t_end=5.0)
    truth = open_truth(lambda number, pi: exact(case, number), 40)
    blocks = list(truth.blocks())
    events = {name: np.concatenate([b.events[name] for b in blocks]) for name in blocks[0].events}
    rest = events["t"][events["kind"] == EVENT_KINDS["rest_begin"]]
    assert rest == pytest.approx([sqrt(2 / GRAVITY) * 9], rel=2e-16)
    assert truth.totals["chatter_time"] < 1e-38
    assert abs(times(run(case), "rest_begin")[0] - rest[0]) < 4e-14


@settings(max_examples=25)
@given(rigid_scenes())
def test_random_scenes_keep_out_of_rigid_stops_and_close_their_ledgers(scene):
    # some hop through 1e8 impacts in a tenth of a second, and then nothing is said of the rest
    result = outcome(scene, "auto", most=2000, ledger=True, momentum=True)
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


def exact(part, number):
    """The scene in another type of number."""
    from dataclasses import fields, is_dataclass

    if is_dataclass(part):
        return replace(part, **{f.name: exact(getattr(part, f.name), number) for f in fields(part)})
    if isinstance(part, tuple):
        return tuple(exact(one, number) for one in part)
    return number(part) if isinstance(part, float) else part


def test_no_kick_pushes_a_body_through_the_stop_that_it_rests_on():
    """How errors grow is told by kicks at events: a resting body keeps the velocity of what it rests on."""
    case = ball(0.5, t_end=5.0)
    result = run(case)
    row = {name: column[-1] for name, column in result.events.items()}
    scale = {name: float(np.abs(result.events[name]).max()) for name in state_columns(case)}
    assert row["floor"] == RESTING and scale["v_ball"] > 1
    assert list(_kick(case, row, scale)) == ["x_ball"]


@pytest.mark.parametrize("engine", ("c", "python"))
@pytest.mark.parametrize("method", ("auto", "taylor"))
@pytest.mark.parametrize("e", (0.0, 0.5))
def test_letting_go_is_no_grazing(engine, method, e):
    """A ball on a table that shakes harder than gravity holds it down: where it leaves there is no turn."""
    omega = 2 * np.pi * 2.6
    of = Scene(
        (Body("ball", 1.0, 0.06, 0.0),),
        stops=(RigidStop("table", BASE, 0, 0.0, COMPRESSION, e),),
        forces=(Force("g", 0, -9.81, ()),),
        base=(Harmonic(0.05, omega, 2.6, 0.0, 0.5),),
        t_end=3.0,
        method=method,
    )
    found = run(of, engine)
    assert found.events["kind"].tolist().count(EVENT_KINDS["rest_end"]) > 4
    assert np.isnan(found.totals["grazing_margin"])


@pytest.mark.parametrize("method", ("auto", "taylor"))
@pytest.mark.parametrize("x", (0.0, 1e-12, 1e-6, 0.00675, 1.0))
def test_chatter_under_friction_ends_and_tells_what_it_left_out(x, method):
    """A body pressed to a wall by F, rubbing with N: it rises against a = (F + N) / m, returns with
    b = (F - N) / m, so speeds shrink by q = e sqrt(b / a), and rest begins after
    e v (1 / a + 1 / sqrt(a b)) / (1 - q). Rounding of x hides the last hops; at x = 0 there is none, and by
    Taylor series returns were 1e-9 s late in hops lower than 1e-15 of the way of the step that they were in.
    Closed form finds returns within 32 roundings of x, in hops of 1024 or more: that is 32 / (4 * 1024) of
    the last hop's time, and 1 / (1 - q) = 2.2 times that of all.
    """
    F, N, m, v, e = 0.9, 0.32, 0.57, 0.04, 0.8
    of = Scene(
        (Body("b", m, x, v),),
        stops=(RigidStop("wall", 0, GROUND, x, COMPRESSION, e, True),),
        frictions=(Friction("f", 0, GROUND, N, N, 0.0),),
        forces=(Force("F", 0, F, ()),),
        t_end=1.0,
        method=method,
    )
    found = run(of, "c", most=1000)
    a, b = (F + N) / m, (F - N) / m
    expected = e * v * (1 / a + 1 / sqrt(a * b)) / (1 - e * sqrt(b / a))
    left_out = found.totals["chatter_time"]
    unit = np.spacing(expected)
    late = left_out * (0.01 if method == "taylor" else 0.01 + 2.2 * 32 / (4 * 1024))
    assert times(found, "rest_begin") + left_out == pytest.approx([expected], abs=late + 16 * unit)
    assert 0 < left_out < 10 * sqrt(2 * 1024 * 2.0**-53 * 2 * x / a) + 16 * unit
    assert found.totals["uncertified"] == 0


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


def test_a_stop_that_rounding_leaves_open_where_its_twin_is_struck_is_struck(tmp_path):
    """Two stops with the same ends and gap: the law of impacts takes the larger e. The closed form tells the
    first zero with a depth of 9e-15 m, and the other stop was taken to be open by as much.
    """
    path = tmp_path / "twins.yaml"
    path.write_text(TWINS)
    events = simulate(load_case(path), trust=False).events
    struck = events["kind"] == EVENT_KINDS["impact"]
    behind, before = (
        events[f"{prefix}v_b1"][struck] - events[f"{prefix}v_b0"][struck] for prefix in ("", "before_")
    )
    assert struck.sum() == 1
    assert behind == pytest.approx(-before, rel=1e-13)


def carried(x, e, m, mu, F, method):
    """A body of 1 kg that hops on the ground at x, with 1 m/s at first, and one of m rubbing on it (4 N, mu)
    that a force F presses down.
    """
    return Scene(
        (Body("a", 1.0, x, -1.0), Body("b", m, x, -1.0)),
        stops=(RigidStop("floor", GROUND, 0, -x, COMPRESSION, e, True),),
        frictions=(Friction("f", 0, 1, 4 * mu, 4 * mu, 0.0),),
        forces=(Force("F", 1, -F, ()),),
        t_end=10.0,
        method=method,
    )


@pytest.mark.parametrize("method", ("auto", "taylor"))
def test_hops_that_a_friction_stops_on_their_way_end_without_loss_in_the_stop(method):
    """Two equal bodies rub with 2 N, 1 N presses down: the lower one hops against 2 m/s^2, both come to rest
    on each other after 2 w / 3, at the height 2 w^2 / 9, and fall with w / 3 and 1/2 m/s^2: they strike at
    w / sqrt 3, and the sequence ends after 1 + sqrt 3 of its first speed. With e = 1 it went on by rounding.
    """
    found = run(carried(1.0, 1.0, 1.0, 0.5, 1.0, method), "c", most=500)
    left_out = found.totals["chatter_time"]
    assert left_out < 1e-5
    assert times(found, "rest_begin") + left_out == pytest.approx([1 + sqrt(3)], abs=0.02 * left_out)
    assert (found.totals["uncertified"], found.totals["chatters"]) == (0, 1)


@pytest.mark.parametrize(("e", "m", "F"), ((0.05, 0.01, 0.05), (0.2, 0.1, 1.0), (0.2, 0.01, 1.0)))
def test_hops_in_which_a_light_body_is_caught_end_certified(e, m, F):
    """It slips faster than four times the speed of the hop, and comes to rest on the other within it."""
    found = run(carried(1.0, e, m, 0.5, F, "auto"), "c", most=500)
    assert (found.totals["uncertified"], found.totals["chatters"]) == (0, 1)


def test_a_body_that_stands_at_one_stop_and_is_struck_through_another_does_not_pass():
    """At t = 0 b2 stands at the wall, about to part from it, when b3 strikes it: both stops take part."""
    bodies = (
        Body("b0", 0.40644332916521275, -0.00133, 0.0),
        Body("b1", 0.3953666200681279, 0.0, 0.0),
        Body("b2", 2.2594357702209775, 0.0, 0.0),
        Body("b3", 0.4518559443749224, -0.0018, 0.01872389221539517),
    )
    stops = (
        Stop("s0", 1, 0, -0.002, EXTENSION, 74.19245410465113, 0.0),
        RigidStop("r0", 2, 3, -0.0018, EXTENSION, 0.3, True),
        RigidStop("r2", 2, GROUND, 0.0, COMPRESSION, 0.3, True),
    )
    links = (Link("l0", 2, 0, 22.354231116646613, 0.0),)
    scene = Scene(bodies, links, stops, t_end=0.07957747154594767, every_num=1, every_den=40)
    assert run(scene).samples["x_b2"].max() < 1e-16


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("engine", ["c", "python"])
@pytest.mark.parametrize("away", [0.0, 0.125])
@pytest.mark.parametrize("side", [1, -1])
def test_a_blow_closes_what_just_touched(engine, method, away, side):
    """c strikes b, which touches a spring at a: both go on with half of what b gets and swing about it until
    they part. Where the blow was at the start, b went through the spring.
    """
    speed, rate = 0.75, sqrt(2 * 40.0)
    bodies = [Body("a", 1.0, 0.0, 0.0), Body("b", 1.0, 0.0, 0.0), Body("c", 1.0, side * away, -side * 1.0)]
    stops = (Stop("ab", 1, 0, 0.0, side, 40.0, 0.0), RigidStop("bc", 2, 1, 0.0, side, 0.5))
    limit = Clearance("limit", *((GROUND, 1) if side > 0 else (1, GROUND)), 0.0)
    result = run(
        scene(bodies, method, stops=stops, clearances=(limit,), t_end=away + 0.5, every_den=32), engine
    )
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


@pytest.mark.parametrize("e", (0.0, 0.5))
@pytest.mark.parametrize("method", METHODS)
def test_what_rests_on_a_shaken_base_is_not_struck_where_a_blow_falls_elsewhere(method, e):
    """The velocities of base and body are computed apart and differ by rounding, which was taken for an
    approach: impacts and ends of chatter were told at a stop where a body rests all the time.
    """
    base = (Harmonic(0.02, 7.0, 7.0 / (2 * pi), 0.0, 0.0),)
    bodies = Body("seated", 1.0, 0.0, 0.02 * 7.0), Body("ball", 1.0, 0.3, 0.0)
    seat = RigidStop("seat", 0, BASE, 0.0, EXTENSION, e, True)
    parts = {"stops": (seat, floor(1, 0.95)), "forces": weights(bodies), "base": base}
    result = run(scene(bodies, method, t_end=12.0, **parts))
    assert len(times(result, "impact", 0)) == len(times(result, "transmitted")) == 0
    assert len(times(result, "impact", 1)) > 100 and len(times(result, "chatter")) == 1
    assert result.totals["rests"] == 1 and result.totals["uncertified"] == 0

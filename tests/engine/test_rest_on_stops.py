"""Bodies that rest on rigid stops: where rest begins, what moves with them, and where they leave."""

from math import acos, cos, pi, sin, sqrt

import numpy as np
import pytest

from tests.engine.impacts import GRAVITY, METHODS, ball, cosine, floor, scene, times, weights
from tests.engine.runs import run
from vibsim.engine.columns import state_columns
from vibsim.engine.modes.status import RESTING
from vibsim.engine.tangent.error_growth import _kick
from vibsim.physics.parts import (
    BASE,
    COMPRESSION,
    EVENT_KINDS,
    EXTENSION,
    Body,
    Force,
    Harmonic,
    Link,
    RigidStop,
    Scene,
)


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


def test_start_on_a_stop_is_rest_or_flight_by_its_load():
    for load, code in ((-1.0, 3), (1.0, 0), (0.0, 3)):
        body = [Body("m", 1.0, 0.0, 0.0)]
        result = run(scene(body, stops=(floor(0, 0.7),), forces=(Force("F", 0, load, ()),), t_end=1.0))
        assert result.samples["floor"].tolist()[0] == code
        assert result.samples["x_m"][-1] == pytest.approx(max(load, 0) / 2)
        assert result.totals["impacts"] == 0


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
    omega = 2 * np.pi * 2.6
    of = Scene(
        (Body("ball", 1.0, 0.06, 0.0),),
        stops=(RigidStop("table", BASE, 0, 0.0, COMPRESSION, e),),
        forces=(Force("g", 0, -9.81, ()),),
        base=(Harmonic(0.05, omega, 2.6, 0.0, 0.5),),
        t_end=3.0,
        method=method,
    )
    found = run(of)
    assert found.events["kind"].tolist().count(EVENT_KINDS["rest_end"]) > 4
    assert np.isnan(found.totals["grazing_margin"])


@pytest.mark.parametrize("e", (0.0, 0.5))
@pytest.mark.parametrize("method", METHODS)
def test_what_rests_on_a_shaken_base_is_not_struck_where_a_impact_falls_elsewhere(method, e):
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

"""Bodies that rest on rigid stops: where rest begins, what moves with them, and where they leave."""

from math import acos, cos, pi, sin, sqrt

import numpy as np
import pytest

from tests.engine.impacts import GRAVITY, METHODS, SHAKEN, ball, times
from tests.engine.runs import run, scene_of
from vibsim.engine.columns import state_columns
from vibsim.engine.modes.status import RESTING
from vibsim.engine.tangent.error_growth import _kick


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
    """The velocities of base and body are computed apart and differ by rounding, which was taken for an
    approach: impacts and ends of chatter were told at a stop where a body rests all the time.
    """
    result = run(scene_of(SEATED, {"seat.e": e}, method=method))
    assert len(times(result, "impact", 0)) == len(times(result, "transmitted")) == 0
    assert len(times(result, "impact", 1)) > 100 and len(times(result, "chatter")) == 1
    assert result.totals["rests"] == 1 and result.totals["uncertified"] == 0

"""Friction that falls with the speed of slip, against closed forms and numbers that vibsim did not make."""

from dataclasses import replace
from math import exp, log

import numpy as np
import pytest

from tests.engine.runs import run
from tests.scenes import falling
from vibsim.cases import load_case
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_KINDS, EXPONENTIAL, GROUND, HYPERBOLIC, Body, Friction, Link, Scene


def times(result, kind):
    return result.events["t"][result.events["kind"] == EVENT_KINDS[kind]]


FALLS = {
    HYPERBOLIC: ((HYPERBOLIC, 3.0, 2.5), lambda v: (v + 2.5 * v * v / 2) / 3.0),
    EXPONENTIAL: ((EXPONENTIAL, 3.0, 2.5), lambda v: (exp(2.5 * v) - 1) / 2.5 / 3.0),
}


@pytest.mark.parametrize("sign", (1, -1))
@pytest.mark.parametrize("law", FALLS)
def test_a_sliding_block_stops_when_it_should_and_stays(law, sign):
    """m v' = -D f(rate v): the time left is m/D (v + rate v^2 / 2), and m/D (exp(rate v) - 1) / rate."""
    fall, left = FALLS[law]
    mass, start = 2.0, 1.3
    friction = falling(Friction("floor", 0, GROUND, 0.0, 0.0, 0.0), fall)
    scene = Scene((Body("m", mass, 0.0, sign * start),), frictions=(friction,), t_end=12.0, every_den=50)
    result = run(scene, ledger=True)
    assert times(result, "stick_begin") == pytest.approx([mass * left(start)], rel=1e-14)
    v, t = sign * result.samples["v_m"], result.samples["time"]
    for speed, time in zip(v[::20], t[::20], strict=True):
        assert speed == 0 or mass * (left(start) - left(speed)) == pytest.approx(
            time, abs=2e-14 * left(start)
        )
    assert len(times(result, "stick_end")) == 0 and v[-1] == 0
    assert result.totals["loss.friction.floor"] == pytest.approx(mass * start**2 / 2, rel=1e-14)


@pytest.mark.parametrize("law", FALLS)
def test_the_mirrored_scene_moves_mirrored_bit_for_bit(law):
    one, other = (law, 1.2, 3.0), (law, 0.7, 9.0)
    plain = Scene(
        (Body("a", 1.0, 0.0, 0.3), Body("b", 0.5, 0.1, 0.0)),
        links=(Link("k", 0, GROUND, 30.0, 0.1), Link("l", 1, 0, 20.0, 0.0)),
        frictions=(
            falling(Friction("f", 0, GROUND, 0.5, 0.6, 0.3), one, other),
            falling(Friction("g", 1, 0, 0.1, 0.0, 0.0), None, other),
        ),
        t_end=10.0,
        every_den=20,
    )
    mirrored = replace(
        plain,
        bodies=tuple(replace(body, x=-body.x, v=-body.v) for body in plain.bodies),
        frictions=(
            falling(Friction("f", 0, GROUND, 0.6, 0.5, -0.3), other, one),
            falling(Friction("g", 1, 0, 0.0, 0.1, 0.0), other, None),
        ),
    )
    left, right = run(plain), run(mirrored)
    assert left.totals["sticks"] > 2
    assert all((left.samples[name] == -right.samples[name]).all() for name in ("x_a", "v_a", "x_b", "v_b"))
    assert (left.events["t"] == right.events["t"]).all()


def test_a_fall_at_no_rate_is_a_constant():
    """f(0) = 1 throughout: the drop is as good as force."""
    constant = Friction("f", 0, GROUND, 1.0, 1.0, 0.2)
    scene = Scene(
        (Body("m", 1.0, 0.0, 0.0),), (Link("k", 0, GROUND, 9.0, 0.0),), frictions=(constant,),
        t_end=20.0, every_den=20, method="taylor",
    )  # fmt: skip
    falls = falling(replace(constant, forward=0.5, backward=0.5), (HYPERBOLIC, 0.5, 0.0))
    one, other = run(scene), run(replace(scene, frictions=(falls,)))
    assert one.events["kind"].tolist() == other.events["kind"].tolist()
    assert np.abs(one.samples["x_m"] - other.samples["x_m"]).max() < 1e-15


def test_equal_coefficients_are_coulombs_law():
    text = {"friction.belt.mu_d": "1"}
    parts = load_case("gallery/belt-oscillator", text).scene().frictions
    assert parts == (Friction("belt", 0, GROUND, 1.0, 1.0, 1.5),)


@pytest.mark.parametrize("law", FALLS)
def test_steep_laws_are_followed(law):
    """A law that has fallen at 1 um/s: every stretch is proved, and slip is that of what is left."""
    friction = falling(Friction("belt", 0, GROUND, 1.0, 1.0, 0.2), (law, 1.0, 1e6))
    scene = Scene(
        (Body("m", 1.0, 0.0, 0.2),), (Link("k", 0, GROUND, 1.0, 0.0),), frictions=(friction,), t_end=60.0,
        every_den=1,
    )  # fmt: skip
    drop = Friction("belt", 0, GROUND, 1.0, 1.0, 0.2, 2.0, 2.0)
    steep, jump = run(scene), run(replace(scene, frictions=(drop,)))
    assert steep.totals["uncertified"] == 0
    assert times(steep, "stick_end") == pytest.approx(times(jump, "stick_end"), abs=1e-3)
    assert len(times(steep, "stick_end")) == len(times(jump, "stick_end")) >= 3


@pytest.mark.parametrize("many", (20.0, 80.0, 2000.0))
def test_a_fast_block_feels_in_time_what_it_has_left_far_behind(many):
    """m v' = -a - b exp(-v / v0) stops after m (v + v0 ln((a + b exp(-v / v0)) / (a + b))) / a.

    At its start the falling part is as small as exp(-many), and its series says nothing of how it will grow.
    """
    v0, a, b = 0.05, 1.0, 3.5
    friction = falling(Friction("floor", 0, GROUND, a, a, 0.0), (EXPONENTIAL, b, 1 / v0))
    start = many * v0
    left = (start + v0 * log((a + b * exp(-many)) / (a + b))) / a
    result = run(Scene((Body("m", 1.0, 0.0, start),), frictions=(friction,), t_end=left + 1, every_den=1))
    assert times(result, "stick_begin") == pytest.approx([left], rel=4e-15)


def test_disturbances_of_the_belt_oscillator():
    """Rest on a fast belt: both exponents are half the trace, (exp(-2 v) - 0.1) / 2."""
    rest = 0.5 + 0.5 * exp(-3.0)
    changes = {"block.x": rest, "block.v": 0, "run.t_end": 400}
    scene = load_case("gallery/belt-oscillator", changes).scene()
    trajectory = open_trajectory(scene, tangent=2, tangent_from=100.0)
    for _ in trajectory.blocks():
        pass
    rate = (exp(-3.0) - 0.1) / 2
    assert sum(trajectory.totals["exponents"]) == pytest.approx(2 * rate, rel=1e-10)
    assert trajectory.totals["exponents"] == pytest.approx([rate, rate], abs=1e-3)

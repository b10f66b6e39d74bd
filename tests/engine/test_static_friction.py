"""Friction that holds more than it slips with, against closed forms of mechanics."""

from dataclasses import replace
from math import atan, exp, log, pi

import numpy as np
import pytest

import vibsim
from tests.engine.bundles import totals
from tests.engine.impacts import times
from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import differences, run, scene_of
from tests.engine.test_restart import assert_restarts, rows_at_each_instant
from vibsim.cases import load_case
from vibsim.engine.modes.rows import SLIDE
from vibsim.engine.resume import resume_point
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_KINDS, EVENT_NAMES, GROUND, Friction

M, K, BELT = 2.0, 50.0, 0.3
SLIP, HOLD = 4.0, 7.0
RATE = (K / M) ** 0.5


# A block on a spring, carried along by a belt.
CARRIED = """
bodies: {m: 2 kg}
links: {spring: {between: [m, ground], k: 50 N/m}}
friction: {belt: {between: [m, ground], N: 4 N, mu: 1, static: 1.75, belt: 0.3 m/s}}
initial: {m: {v: 0.3 m/s}}
run: {t_end: 12 s, every: 100 ms}
"""
# A block that a growing force tears off the ground, and one that rubs on it.
CARRIAGE = """
bodies: {lower: 1 kg, upper: 0.5 kg}
friction:
  floor: {between: [lower, ground], N: 2 N, mu: 1, static: 4}
  lid: {between: [upper, lower], N: 1.9 N, mu: 1}
forces: {pull: {on: lower, A: 40 N, omega: 0.5 rad/s}}
run: {t_end: 1 s, every: 1 ms}
"""
# A block that holds on to a belt until it meets a damped stop, whose force tears it off.
STRUCK = """
bodies: {m: 1 kg}
stops: {wall: {between: [m, ground], gap: 10 mm, acts: compression, k: 10 N/m, c: 20 N s/m, release: gap}}
friction: {belt: {between: [m, ground], N: 1 N, mu: 1, belt: 0.5 m/s}}
initial: {m: {v: 0.5 m/s}}
run: {t_end: 0.5 s, every: 1 ms}
"""


@pytest.mark.parametrize("sign", (1, -1))
@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_block_on_a_belt(method, sign):
    """Carried to k x = F_s, the block slips about F_k / k with the amplitude of (F_s - F_k) / k and v / rate,
    until it has the speed of the belt again: then rate x is as far below F_k / k as it was above.
    """
    changes = {"belt.belt": sign * BELT, "m.v": sign * BELT}
    result = run(scene_of(CARRIED, changes, method=method), ledger=True)
    drop = (HOLD - SLIP) / K
    slips = (2 * pi - 2 * atan(RATE * drop / BELT)) / RATE
    sticks = 2 * drop / BELT
    ends, begins = times(result, "stick_end"), times(result, "stick_begin")
    assert len(ends) >= 6
    expected = HOLD / K / BELT + (slips + sticks) * np.arange(len(ends))
    assert ends == pytest.approx(expected, rel=1e-14)
    assert begins == pytest.approx(expected[: len(begins)] + slips, rel=1e-14)
    assert sign * result.events["x_m"][result.events["kind"] == EVENT_KINDS["stick_end"]] == pytest.approx(
        HOLD / K, rel=1e-14
    )
    assert result.totals["uncertified"] == 0
    assert abs(result.totals["energy_residual"]) < 1e-13


def test_block_on_a_belt_in_many_digits():
    """The same to 38 digits."""
    flint = pytest.importorskip("flint")
    flint.ctx.dps = 60
    _, events, digits, _ = truth(exact_parts(scene_of(CARRIED)), 40)
    ends = digits["t"][events["kind"] == EVENT_KINDS["stick_end"]]
    assert len(ends) >= 6
    drop = flint.arb(HOLD - SLIP) / K
    belt = flint.arb(BELT)
    period = (2 * flint.arb.pi() - 2 * (5 * drop / belt).atan()) / 5 + 2 * drop / belt
    for n, text in enumerate(ends):
        assert abs(flint.arb(text.decode()) - (flint.arb(HOLD) / K / belt + n * period)) < 1e-37


def test_what_a_release_tears_with_it():
    """Accelerations jump to (F_s - F_k) / (m1 + m2) = 4 m/s^2: a lid that holds less than 2 N slips too."""
    release = np.arcsin(8.0 / 40.0) / 0.5
    torn = run(scene_of(CARRIAGE))
    ends = torn.events["kind"] == EVENT_KINDS["stick_end"]
    assert torn.events["t"][ends] == pytest.approx([release] * 2, rel=1e-14)
    assert (torn.events["floor"][ends].tolist(), torn.events["lid"][ends].tolist()) == ([1, 1], [-1, -1])
    t, v = torn.samples["time"], torn.samples["v_upper"]
    assert v[t > release] == pytest.approx(1.9 / 0.5 * (t[t > release] - release), abs=1e-13)
    held = run(scene_of(CARRIAGE, {"lid.N": 2.1}))
    first = held.events["t"][held.events["kind"] == EVENT_KINDS["stick_end"]]
    assert first[0] == pytest.approx(release, rel=1e-14)
    assert first[1] > release + 1e-3
    assert torn.totals["uncertified"] == held.totals["uncertified"] == 0


def test_a_limit_as_high_as_the_slipping_force_changes_nothing():
    friction = Friction("f", 0, GROUND, 1.0, 0.7, 0.1)
    plain = load_case("gallery/friction-oscillator", {"run.t_end": "100 s"}).scene()
    plain = replace(plain, frictions=(friction,))
    told = replace(plain, frictions=(replace(friction, hold_forward=1.0, hold_backward=0.7),))
    assert differences(run(plain), run(told)) == []


SHAKEN = """
bodies: {m: 1 kg}
friction: {f: {between: [m, base], N: 1 N, plus: {mu: 3, static: 2.5}, minus: {mu: 3, static: 7}}}
base: {a: 10 mm, omega: 30 rad/s}
run: {t_end: 5 s}
"""


def test_limits_of_the_two_directions():
    """A block on a shaken table that lets it slip easily forwards only is carried one way."""
    forwards, backwards = scene_of(SHAKEN), scene_of(SHAKEN, {"f.plus.static": 7, "f.minus.static": 2.5})
    assert run(forwards).samples["x_m"][-1] > 0.05
    assert run(backwards).samples["x_m"][-1] < -0.05


LIMITS_OF_TWO_DIRECTIONS = """
name: limits
bodies: {{a: 1 kg}}
links: {{s: {{between: [a, ground], k: 100 N/m}}}}
friction: {{f: {{between: [a, ground], N: {load}, {sides}}}}}
forces: {{d: {{on: a, A: 5 N, omega: 3 rad/s}}}}
run: {{t_end: 12 s, every: 50 ms}}
"""


@pytest.mark.parametrize(
    "sides",
    ("plus: {mu: 0.1, static: 1.5}, minus: {mu: 0.2}", "plus: {mu: 0.2}, minus: {mu: 0.1, static: 1.5}"),
)
def test_a_load_by_a_formula_keeps_the_limits_of_the_two_directions(sides):
    """The force drops where slip begins in the direction that has a static limit, and in that one alone."""
    formula = "'N0*max(1, t/T)', N0: 10 N, T: 100 s"  # 10 N until 100 s
    plain, by_formula = (
        vibsim.simulate(LIMITS_OF_TWO_DIRECTIONS.format(load=load, sides=sides)) for load in ("10 N", formula)
    )
    assert by_formula.attrs["sticks"] == plain.attrs["sticks"] > 8
    assert list(by_formula.events.words("kind")) == list(plain.events.words("kind"))
    np.testing.assert_allclose(by_formula.events["t"], plain.events["t"], rtol=0, atol=1e-12)
    assert by_formula.attrs["uncertified"] == 0


SCENES = (scene_of(CARRIED), scene_of(CARRIAGE), scene_of(CARRIAGE, {"lid.N": 2.1}), scene_of(STRUCK))


def test_a_run_goes_on_from_a_release():
    for scene in SCENES:
        assert_restarts(scene)


WITHOUT_DROP = scene_of(CARRIED, {"belt.N": HOLD, "belt.static": 1})


@pytest.mark.parametrize(
    ("scene", "orders"),
    list(zip((*SCENES, WITHOUT_DROP), ([1] * 9, [1, 1], [1, 2], [1], [2] * 10), strict=True)),
)
def test_a_release_with_a_jump_leaves_a_simple_zero_of_the_sliding_velocity(scene, orders):
    """One without a jump, as that of the upper block that is held, leaves a double one."""
    found = []
    for rows in rows_at_each_instant(run(scene).events):
        if rows[-1]["t"] < scene.t_end:
            found += [order for (kind, _), order in resume_point(scene, rows)[2].items() if kind == SLIDE]
    assert found == orders


def test_a_damped_stop_tears_a_block_off():
    """Carried at 0.5 m/s against c = 20 N s/m the force jumps by 10 N: slip begins where contact does."""
    result = run(scene_of(STRUCK))
    kinds = [EVENT_NAMES[kind] for kind in result.events["kind"]]
    assert kinds[:3] == ["start", "contact_begin", "stick_end"]
    assert result.events["t"][1] == result.events["t"][2] == pytest.approx(0.02, rel=1e-14)


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_the_stick_slip_cycle_is_found_at_once_and_kept(method):
    """Exponents of a block on a belt: 0, along the motion without drive, and minus infinity."""
    result = totals(scene_of(CARRIED, method=method, t_end=20), begin=5.0)
    assert result["exponents"][0] == pytest.approx(0, abs=1e-12)
    assert result["exponents"][1] == -np.inf


PUSHED = """
bodies: {m: 1 kg}
friction: {floor: {between: [m, ground], N: 4 N, mu: 1, static: 1.75}}
forces: {push: {on: m, F0: 5 N}}
run: {t_end: 1 s}
"""


@pytest.mark.parametrize("speed", (0.6, -0.6, 0.0))
@pytest.mark.parametrize(("force", "sticks"), ((5.0, True), (6.9, True), (7.1, False)))
def test_where_sticking_and_slipping_on_are_both_possible_it_sticks(force, sticks, speed):
    """A push between what it slips with, 4 N, and what it holds, 7 N, against the slip or along it."""
    sense = -1.0 if speed >= 0 else 1.0
    result = run(scene_of(PUSHED, {"m.v": speed, "push.F0": sense * force}))
    stop = abs(speed) / (force + 4.0)
    assert (result.samples["v_m"][-1] == 0) == sticks
    if sticks:
        assert times(result, "stick_begin") == pytest.approx([stop] * (speed != 0), rel=1e-14)
    else:
        v = sense * (force - 4.0) * (1.0 - stop)
        assert result.samples["v_m"][-1] == pytest.approx(v, rel=1e-14)
    assert result.totals["uncertified"] == 0


# A block that is held against any force backwards.
FREEWHEEL = """
bodies: {m: 2 kg}
friction: {wheel: {between: [m, ground], N: 1 N, plus: {mu: 0}, minus: {mu: 1e9}}}
forces: {drive: {on: m, A: 5 N, omega: 1 Hz}}
run: {t_end: 5 s, every: 20 ms}
"""


def test_a_freewheel_without_loss_touches_rest_once_a_period():
    """v = A / (m omega) (1 - cos omega t) touches 0 where the force does: a doubt each, the same motion."""
    result = run(scene_of(FREEWHEEL), ledger=True)
    exact = 5.0 / (M * 2 * pi) * (1 - np.cos(2 * pi * result.samples["time"]))
    assert np.abs(result.samples["v_m"] - exact).max() < 1e-15
    assert result.totals["uncertified"] == 5
    touches = times(result, "stick_begin")
    assert touches == pytest.approx(np.round(touches), abs=1e-7)  # sqrt(eps) of a period
    assert run(scene_of(FREEWHEEL, {"wheel.plus.mu": 1e-6})).totals["uncertified"] == 0


# Friction that falls with the speed of slip, against closed forms and numbers that vibsim did not make.


FALLS = {
    "law: stribeck hyperbolic, mu_s: 3, mu_d: 0, d: 2.5 s/m": lambda v: (v + 2.5 * v * v / 2) / 3.0,
    "law: stribeck exponential, mu_s: 3, mu_d: 0, v0: 0.4 m/s": lambda v: (exp(2.5 * v) - 1) / 2.5 / 3.0,
}
ALONE = """
bodies: {m: 2 kg}
friction: {floor: {between: [m, ground], N: 1 N, LAW}}
run: {t_end: 12 s, every: 20 ms}
"""


@pytest.mark.parametrize("sign", (1, -1))
@pytest.mark.parametrize("law", FALLS)
def test_a_sliding_block_stops_when_it_should_and_stays(law, sign):
    """m v' = -D f(rate v): the time left is m/D (v + rate v^2 / 2), and m/D (exp(rate v) - 1) / rate."""
    left, mass, start = FALLS[law], 2.0, 1.3
    result = run(scene_of(ALONE.replace("LAW", law), {"m.v": sign * start}), ledger=True)
    assert times(result, "stick_begin") == pytest.approx([mass * left(start)], rel=1e-14)
    v, t = sign * result.samples["v_m"], result.samples["time"]
    for speed, time in zip(v[::20], t[::20], strict=True):
        assert speed == 0 or mass * (left(start) - left(speed)) == pytest.approx(
            time, abs=2e-14 * left(start)
        )
    assert len(times(result, "stick_end")) == 0 and v[-1] == 0
    assert result.totals["loss.friction.floor"] == pytest.approx(mass * start**2 / 2, rel=1e-14)


MIRRORED = """
bodies: {a: 1 kg, b: 0.5 kg}
links: {k: {between: [a, ground], k: 30 N/m, c: 0.1 N s/m}, l: {between: [b, a], k: 20 N/m}}
friction:
  f: {between: [a, ground], N: 1 N, LAW, ONE: {mu_s: 1.7, mu_d: 0.5, SLOW},
      OTHER: {mu_s: 1.3, mu_d: 0.6, FAST}, belt: SIGN0.3 m/s}
  g: {between: [b, a], N: 1 N, LAW, ONE: {mu_s: 0.1, mu_d: 0.1, SLOW}, OTHER: {mu_s: 0.7, mu_d: 0, FAST}}
initial: {a: {v: SIGN0.3 m/s}, b: {x: SIGN0.1 m}}
run: {t_end: 10 s, every: 50 ms}
"""


@pytest.mark.parametrize(
    ("law", "slow", "fast"),
    [("stribeck hyperbolic", "d: 3 s/m", "d: 9 s/m"), ("stribeck exponential", "v0: 0.3 m/s", "v0: 0.1 m/s")],
)
def test_the_mirrored_scene_moves_mirrored_bit_for_bit(law, slow, fast):
    text = MIRRORED.replace("LAW", f"law: {law}").replace("SLOW", slow).replace("FAST", fast)
    left, right = (
        run(scene_of(text.replace("ONE", one).replace("OTHER", other).replace("SIGN", sign)))
        for one, other, sign in (("plus", "minus", ""), ("minus", "plus", "-"))
    )
    assert left.totals["sticks"] > 2
    assert all((left.samples[name] == -right.samples[name]).all() for name in ("x_a", "v_a", "x_b", "v_b"))
    assert (left.events["t"] == right.events["t"]).all()


ON_A_BELT = """
bodies: {m: 1 kg}
links: {k: {between: [m, ground], k: 1 N/m}}
friction: {belt: {between: [m, ground], N: 1 N, belt: 0.2 m/s, LAW}}
initial: {m: {v: 0.2 m/s}}
run: {t_end: 60 s, every: 1 s}
"""


def test_equal_coefficients_are_coulombs_law():
    text = {"friction.belt.mu_d": "1"}
    parts = load_case("gallery/belt-oscillator", text).scene().frictions
    assert parts == (Friction("belt", 0, GROUND, 1.0, 1.0, 1.5),)


@pytest.mark.parametrize(
    "law", ["law: stribeck hyperbolic, d: 1e6 s/m", "law: stribeck exponential, v0: 1 um/s"]
)
def test_steep_laws_are_followed(law):
    """A law that has fallen at 1 um/s: every stretch is proved, and slip is that of what is left."""
    steep, jump = (
        run(scene_of(ON_A_BELT.replace("LAW", of))) for of in (f"{law}, mu_s: 2, mu_d: 1", "mu: 1, static: 2")
    )
    assert steep.totals["uncertified"] == 0
    assert times(steep, "stick_end") == pytest.approx(times(jump, "stick_end"), abs=1e-3)
    assert len(times(steep, "stick_end")) == len(times(jump, "stick_end")) >= 3


@pytest.mark.parametrize("many", (20.0, 80.0, 2000.0))
def test_a_fast_block_feels_in_time_what_it_has_left_far_behind(many):
    """m v' = -a - b exp(-v / v0) stops after m (v + v0 ln((a + b exp(-v / v0)) / (a + b))) / a.

    At its start the falling part is as small as exp(-many), and its series says nothing of how it will grow.
    """
    v0, a, b = 0.05, 1.0, 3.5
    start = many * v0
    left = (start + v0 * log((a + b * exp(-many)) / (a + b))) / a
    text = ALONE.replace("LAW", "law: stribeck exponential, mu_s: 4.5, mu_d: 1, v0: 50 mm/s")
    result = run(scene_of(text, {"bodies.m": 1, "m.v": start}, t_end=left + 1, every=1))
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

"""Disturbances through rigid stops: closed forms of mechanics, published multipliers, difference quotients in
40 digits, and Liouville's identity.
"""

from dataclasses import replace
from math import cos, exp, isnan, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import strategies as st

from tests.engine.bundles import PER_PIECE, assert_derivative, totals
from tests.engine.random_parts import rigid_scene, rigid_scenes
from tests.engine.runs import run, scene_of
from tests.random_scenes import Draws, always
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.physics.parts import EVENT_KINDS

G, METHODS = 9.81, ("auto", "taylor")


def ball_over(e, base="", end="ground", **run):
    """A ball that falls onto the ground or a table."""
    return scene_of(
        f"""
bodies: {{ball: 1 kg}}
stops: {{wall: {{between: [{end}, ball], gap: 0 m, acts: compression, law: rigid, e: {e}}}}}
forces: {{g: {{on: ball, F0: {-G} N}}}}
initial: {{ball: {{x: 0.3 m}}}}
{base}""",
        **run,
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_ball_on_a_vibrating_table(method):
    """One bounce: the table moves on while a disturbed ball is late."""
    a, f, e, v0, T = 0.02, 2.5, 0.7, 0.1, 0.4
    w = 2 * pi * f
    of = ball_over(e, f"base: {{a: {a} m, omega: {f} Hz}}", "base", method=method)
    carried = Carrier(of).carry([0.3, v0], T)
    t = 0.2
    for _ in range(50):  # Newton
        t -= (0.3 + v0 * t - G * t * t / 2 - a * sin(w * t)) / (v0 - G * t - a * w * cos(w * t))
    before, table = v0 - G * t, a * w * cos(w * t)
    after, left = (1 + e) * table - e * before, T - t
    late = np.array([1.0, t]) / (table - before)  # of the bounce, by x0 and v0
    d_before = np.array([0.0, 1.0]) - G * late
    d_after = -(1 + e) * a * w * w * sin(w * t) * late - e * d_before
    dx = (table - after + G * left) * late + d_after * left
    assert carried.events == (("impact", 0),)
    np.testing.assert_allclose(carried.matrix, [dx, d_after + G * late], rtol=0, atol=2e-12)
    expected = [a * sin(w * t) + after * left - G * left * left / 2, after - G * left]
    np.testing.assert_allclose(carried.state, expected, rtol=0, atol=1e-13)


def impact_oscillator(c, gap, drive):
    """x'' + c x' + x = A cos(w t) before a wall, at a phase that starts where it says; drive: A, w, phase."""
    amplitude, omega, phase = drive
    return scene_of(f"""
bodies: {{m: 1 kg}}
links: {{l: {{between: [m, ground], k: 1 N/m, c: {c} N s/m}}}}
stops: {{wall: {{between: [m, ground], gap: {gap} m, acts: compression, law: rigid, e: 0.8}}}}
forces: {{F: {{on: m, A: {amplitude} N, omega: {omega} rad/s, phase: {phase + pi / 2} rad}}}}
""")


@pytest.mark.parametrize("sigma", (0.0, 0.2, 0.34))
def test_the_motion_of_budd_and_dux(sigma):
    """One impact in two periods: speed, multipliers as printed (8 digits), their product e^2."""
    w, e = 3.7, 0.8
    gamma, T = 1 / (1 - w * w), 4 * pi / w
    cs, rm = sin(T) * (1 + e) / (1 - cos(T)), (1 - e) / w
    root = 2 * sqrt(gamma * gamma * cs * cs - (sigma * sigma - gamma * gamma) * rm * rm)
    V = (-2 * cs * sigma + root) / (cs * cs + rm * rm)
    # x = p cos t + q sin t + gamma cos(w t + phi) from an impact on, with x(0) = x(T) = sigma, v(T) = V and
    # v(0) = -e V; what drives has the period T
    q = -V * (1 + e) / 2
    p = q * sin(T) / (1 - cos(T))
    phi_cos, phi_sin = (sigma - p) / gamma, (-e * V - q) / (-gamma * w)
    phi = np.arctan2(phi_sin, phi_cos)
    away = 0.4 * T
    turned = w * away + phi
    x = p * cos(away) + q * sin(away) + gamma * cos(turned)
    v = -p * sin(away) + q * cos(away) - gamma * w * sin(turned)
    of = impact_oscillator(0.0, sigma, (1.0, w, float(turned)))
    carried = Carrier(of).carry([x, v], T)
    assert carried.events == (("impact", 0),)
    np.testing.assert_allclose(carried.state, [x, v], rtol=0, atol=1e-13)
    assert np.linalg.det(carried.matrix) == pytest.approx(e * e, abs=1e-13)
    if sigma == 0:
        assert abs(V - 0.66569335283999) < 1e-14
        multiplier = max(np.linalg.eigvals(carried.matrix), key=lambda one: one.imag)
        assert abs(multiplier - (0.44251655 + 0.66646763j)) < 1e-8


def test_the_impact_oscillator_of_recipes_for_continuation():
    """Example 15.2, A = 1: speed and phase of the impact, product of the multipliers e^2 exp(-c T)."""
    speed, phase = 1.695732937594882, 0.0759521649383
    of = impact_oscillator(0.1, 1.0, (1.0, 1.0, phase))
    # behind the impact, then around once: to before the next one, and the same in pieces
    carrier = Carrier(of)
    carried = carrier.carry([1.0, -0.8 * speed], 2 * pi - 0.05)
    assert carried.events == ()
    shifted = impact_oscillator(0.1, 1.0, (1.0, 1.0, phase - 0.05))
    around = Carrier(shifted).carry(carried.state, 2 * pi)
    assert around.events == (("impact", 0),)
    np.testing.assert_allclose(around.state, carried.state, rtol=0, atol=1e-12)
    assert np.linalg.det(around.matrix) == pytest.approx(0.64 * exp(-0.2 * pi), abs=1e-14)
    assert np.linalg.det(around.matrix) == pytest.approx(0.341432378298, abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_chatter_leaves_what_momentum_keeps(method):
    """A ball bounces to rest on a block, pressed by a force between them: both go on with their centre."""
    m, M, F, T = 1.0, 2.5, 6.0, 1.5
    of = scene_of(f"""
bodies: {{ball: {m} kg, block: {M} kg}}
stops: {{wall: {{between: [block, ball], gap: 0 m, acts: compression, law: rigid, e: 0.6}}}}
forces: {{down: {{on: ball, F0: {-F} N}}, up: {{on: block, F0: {F} N}}}}
run: {{method: {method}}}
""")
    carried = Carrier(of).carry([0.2, 0.0, 0.3, -0.1], T)
    assert carried.events[-2:] == (("chatter", 0), ("rest_begin", 0))
    own, other = m / (m + M), M / (m + M)
    row = [own, other, own * T, other * T]
    expected = [row, row, [0, 0, own, other], [0, 0, own, other]]
    np.testing.assert_allclose(carried.matrix, expected, rtol=0, atol=1e-12)
    assert np.isnan(carried.undefined_at)


def test_chatter_on_a_slider_that_sticks_between_the_blows():
    """A mass strikes a slider, which friction stops before each next blow: there the force on the mass parts
    them, and the last approaches are slow beside the first. What the slider goes in all is proportional to
    the square of the first.
    """
    force, v0, x0 = -5.0, 5.0, -0.1
    of = scene_of(f"""
bodies: {{mass: 1 kg, slider: 0.5 kg}}
stops: {{wall: {{between: [mass, slider], gap: 0 m, acts: compression, law: rigid, e: 0.3}}}}
friction: {{rub: {{between: [slider, ground], N: 8 N, mu: 1}}}}
forces: {{f: {{on: mass, F0: {force} N}}}}
initial: {{mass: {{x: {x0} m, v: {v0} m/s}}}}
""")
    carried = Carrier(of).carry([x0, 0.0, v0, 0.0], 1.0)
    gone, square = carried.state[1], v0**2 + 2 * force * -x0
    assert isnan(carried.undefined_at) and gone > 0.1
    moved = carried.vectors[[0, 2], 1]  # of the slider, by place and speed of the mass
    np.testing.assert_allclose(moved, gone / square * np.array([2 * force * -1, 2 * v0]), rtol=1e-6)


def test_a_ball_at_rest_forgets_its_fall():
    carried = Carrier(ball_over(0.5)).carry([0.3, 0.0], 2.0)
    assert carried.events[-1] == ("rest_begin", 0)
    assert carried.matrix.tolist() == [[0.0, 0.0], [0.0, 0.0]]


def in_a_row(e):
    """Three balls that touch."""
    return scene_of(f"""
bodies: {{a: 1 kg, b: 1 kg, c: 1 kg}}
stops:
  wall: {{between: [a, b], gap: 0 m, acts: compression, law: rigid, e: {e}}}
  next: {{between: [b, c], gap: 0 m, acts: compression, law: rigid, e: {e}}}
""")


def test_a_ball_that_strikes_two_that_touch():
    """Newton-Moreau, e = 1: (-1/3, 2/3, 2/3) of its speed goes on. Those at rest are one body."""
    start, share, left = [-1.0, 0.0, 0.0, 1.0, 0.0, 0.0], np.array([-1 / 3, 2 / 3, 2 / 3]), 2.0
    vectors = np.array([[1.0, 0, 0, 0, 0, 0], [0, 0, 0, 1.0, 0, 0], [0, 1.0, 1.0, 0, 0, 0]])
    carried = Carrier(in_a_row(1)).carry(start, 1.0 + left, vectors)
    assert carried.events[0] == ("impact", 0)
    np.testing.assert_allclose(carried.state[3:], share, rtol=0, atol=1e-15)
    jump = share - np.array([1.0, 0, 0])
    expected = [
        [*(vectors[0][:3] + jump), 0, 0, 0],  # 1 s earlier
        [*(np.array([1.0, 0, 0]) + jump + left * share), *share],
        [*(vectors[2][:3] - jump), 0, 0, 0],  # 1 s later
    ]
    np.testing.assert_allclose(carried.vectors, expected, rtol=0, atol=1e-14)


THROWN = """
bodies: {m: 1 kg}
stops: {wall: {between: [m, ground], gap: 1 m, acts: compression, law: rigid, e: 0.8}}
forces: {g: {on: m, F0: -2 N}}
initial: {m: {v: 2 m/s}}
run: {t_end: 1.5 s}
"""


@pytest.mark.parametrize("method", METHODS)
def test_grazing_has_no_derivative(method):
    """2 t - t^2 just comes up to 1 at t = 1, where the approach is 0 to the bit."""
    carrier = Carrier(scene_of(THROWN, method=method))
    grazed = carrier.carry([0.0, 2.0], 1.5)
    assert grazed.undefined_at == pytest.approx(1.0, abs=1e-7) and np.all(np.isnan(grazed.vectors))
    assert np.isnan(carrier.carry([0.0, 1.9], 1.5).undefined_at)
    struck = carrier.carry([0.0, 2.1], 1.5)
    assert struck.events == (("impact", 0),) and np.isnan(struck.undefined_at)
    near = carrier.carry([0.0, 2.0 + 1e-6], 1.5)
    approach = sqrt(4e-6 + 1e-12)  # v^2 = v0^2 - 4: the derivative grows as its inverse does
    assert np.abs(near.matrix).max() == pytest.approx(2 * 1.8 / approach, rel=1e-3)


def test_impacts_from_both_sides_at_once_have_no_derivative():
    """Which comes first decides where the balls go on to."""
    of = in_a_row(0.5)
    carried = Carrier(of).carry([-1.0, 0.0, 1.0, 1.0, 0.0, -1.0], 1.5)
    assert carried.undefined_at == pytest.approx(1.0, abs=1e-14)
    apart = Carrier(of).carry([-1.0, 0.0, 1.25, 1.0, 0.0, -1.0], 1.4)
    assert np.isnan(apart.undefined_at) and len(apart.events) >= 2


def test_exponents_of_grazing_are_none():
    found = totals(scene_of(THROWN))
    assert np.all(np.isnan(found["exponents"])) and np.isnan(found["volume_residual"])
    assert found["undefined_time"] == pytest.approx(1.0, abs=1e-7)


def test_exponents_of_an_impact_oscillator():
    """Their sum is (2 ln e - c T) / T on a motion of one impact per period."""
    speed, phase = 1.695732937594882, 0.0759521649383
    of = impact_oscillator(0.1, 1.0, (1.0, 1.0, phase))
    of = replace(of, bodies=(replace(of.bodies[0], x=1.0, v=-0.8 * speed),), t_end=40 * pi)
    found = totals(of, begin=20 * pi)
    impacts = run(of).events
    count = sum(impacts["t"][impacts["kind"] == impacts["kind"][1]] > 20 * pi)
    expected = (count * 2 * np.log(0.8)) / (20 * pi) - 0.1
    assert sum(found["exponents"]) == pytest.approx(expected, abs=1e-9)
    assert abs(found["volume_residual"]) < PER_PIECE * found["tangent_pieces"] and found["rank_losses"] == 0


def test_plastic_impacts_and_rest_take_directions():
    """e = 0 takes one, rest two, in which a disturbance has the exponent minus infinity."""
    thrown = "base: {a: 5 cm, omega: 2.5 Hz, phase: 4.31 rad}"  # falls faster than the ball at the impact
    found = totals(ball_over(0, thrown, "base", t_end="0.3 s"))
    assert found["rank_losses"] == 1 and np.isneginf(found["exponents"][1]) and found["exponents"][0] > -1e3
    assert abs(found["volume_residual"]) < PER_PIECE * found["tangent_pieces"]
    rested = totals(ball_over(0, t_end="1 s"))
    assert rested["rank_losses"] == 2 and np.all(np.isneginf(rested["exponents"]))


def apart(of):
    """The scene with stops that touched at the start a little away: shifted starts lie inside none."""
    stops = (replace(s, gap=s.gap + 1e-3, at_start=False) if s.at_start else s for s in of.stops)
    return replace(of, stops=tuple(stops))


CHOSEN = {
    "a motor between two walls, one of them shaken": (
        """
bodies: {a: 1 kg, b: 2 kg}
links: {k: {between: [b, ground], k: 90 N/m, c: 0.3 N s/m}, l: {between: [a, b], k: 60 N/m, c: 0.1 N s/m}}
stops:
  wall: {between: [a, b], gap: 4 mm, acts: compression, law: rigid, e: 0.6}
  other: {between: [a, base], gap: 6 mm, acts: extension, law: rigid, e: 0.8}
base: {a: 3 mm, omega: 1.1 Hz, phase: 0.5 rad}
motor: {on: a, m3: 0.3 kg, e: 5 cm, J: 3e-4 kg m^2, M0: 0.02 N m, Omega0: 15 rad/s}
initial: {a: {v: 0.1 m/s}, motor: {phi: 0.4 rad, phidot: 12 rad/s}}
run: {t_end: 0.35 s, every: 1 s}
""",
        {"impact"},
    ),
    "a block on a shaken table that rubs on a body": (
        """
bodies: {a: 1 kg, b: 0.5 kg}
links: {k: {between: [b, ground], k: 50 N/m, c: 0.3 N s/m}}
stops: {wall: {between: [base, a], gap: 0 m, acts: compression, law: rigid, e: 0.3}}
friction: {f: {between: [a, b], N: 0.4 N, mu: 1, static: 1.5}}
forces: {g: {on: a, F0: -3 N}}
base: {a: 2 cm, omega: 2.6 Hz, phase: 0.5 rad}
initial: {a: {x: 2 cm}, b: {v: 0.1 m/s}}
run: {t_end: 0.42 s, every: 1 s}
""",
        {"impact", "reversal", "rest_begin", "rest_end"},
    ),
}


@pytest.mark.parametrize("label", CHOSEN)
def test_difference_quotients_of_chosen_scenes(label):
    text, expected = CHOSEN[label]
    columns, kinds = assert_derivative(scene_of(text))
    assert columns >= 3 and kinds >= expected


MOST = 2000  # events: some scenes with dry friction close up by a fraction of a per cent only


def ends(of, most=MOST):
    """Whether a run comes to its end, within so many events."""
    try:
        return len(run(of, most=most).events["t"]) < most
    except EngineError:
        return False


def assert_derivative_apart(of):
    if ends(apart(of), 100):
        assert_derivative(apart(of))


test_difference_quotients_of_random_scenes = always(
    assert_derivative_apart, rigid_scenes(radians=6.0, bodies=3), few=12, many=300
)


def assert_volumes_grow(of, method):
    """As Liouville says: not where hops fade away, whose S is as large as one over their
    speed, so that rounding takes what is left of a volume.
    """
    of = replace(of, method=method)
    if ends(of):
        found = run(of, tangent=dimension(of))
        fades = EVENT_KINDS["chatter"] in found.events["kind"]
        residual = np.nan if fades else found.totals["volume_residual"]
        assert np.isnan(residual) or abs(residual) < PER_PIECE * (found.totals["tangent_pieces"] + 1)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", [234, 10428, 12821, 25955])
def test_no_volume_stands_on_what_rounding_leaves_of_a_disturbance(seed, method):
    """Impacts with e = 0, and one stick, leave of a disturbance so little beside others that it is rounding,
    or no better at right angles to them than rounding over that little.
    """
    of = rigid_scene(Draws(seed), radians=4.0)
    assert_volumes_grow(of, method)
    found = totals(replace(of, method=method))
    assert found["rank_losses"] >= 2 and np.isneginf(found["exponents"]).any()
    assert np.isfinite(found["volume_residual"])


test_volumes_of_random_scenes_grow_as_liouville_says = always(
    assert_volumes_grow, rigid_scenes(radians=4.0), st.sampled_from(METHODS), few=20, many=3000
)

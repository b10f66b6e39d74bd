"""Motions whose course is known in closed form, by mechanics alone."""

from itertools import pairwise
from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest

from tests.engine.runs import run, scene_of
from vibsim.physics.parts import AT_FORCE

METHODS = ("auto", "taylor")


def case(text, method="auto", changes=None, **settings):
    """The scene of a case, for 10 s and sampled every 50 ms if it does not say otherwise."""
    return scene_of(text, changes, **{"t_end": "10 s", "every": "50 ms", "method": method, **settings})


@pytest.mark.parametrize("method", METHODS)
def test_modes_of_a_chain_of_three(method):
    """Equal masses between two walls by equal springs: normal frequencies 2 w sin(j pi / 8) (Rayleigh)."""
    w, amplitude = 3.0, 0.01
    shape = [sin(j * pi / 4) for j in (1, 2, 3)]
    starts = {f"b{j}.x": amplitude * s for j, s in enumerate(shape)}
    ends = ["ground", *(f"b{j}" for j in range(3)), "ground"]
    links = [f"l{i}: {{between: [{P}, {Q}], k: {w * w} N/m}}" for i, (P, Q) in enumerate(pairwise(ends))]
    text = f"""
bodies: {{b0: 1 kg, b1: 1 kg, b2: 1 kg}}
links: {{{", ".join(links)}}}
initial: {{b0: {{x: 0 m}}, b1: {{x: 0 m}}, b2: {{x: 0 m}}}}
"""
    result = run(case(text, method, starts))
    rate = 2 * w * sin(pi / 8)
    for j, s in enumerate(shape):
        expected = amplitude * s * np.cos(rate * result.samples["time"])
        assert np.abs(result.samples[f"x_b{j}"] - expected).max() < 1e-14


@pytest.mark.parametrize("method", METHODS)
def test_shaken_base_moves_a_mass_as_theory_says(method):
    """x'' + w^2 x = w^2 X, X = a sin(nu t), from rest: x = a (sin nu t - nu/w sin w t) / (1 - nu^2 / w^2)."""
    w, nu, a = 5.0, 2 * pi * 0.6, 0.002
    text = f"""
bodies: {{m: 2 kg}}
links: {{l: {{between: [m, base], k: {2 * w * w} N/m}}}}
base: {{a: {a} m, omega: 0.6 Hz}}
"""
    result = run(case(text, method))
    t = result.samples["time"]
    expected = a * (np.sin(nu * t) - nu / w * np.sin(w * t)) / (1 - (nu / w) ** 2)
    assert np.abs(result.samples["x_m"] - expected).max() < 1e-14


ON_A_BELT = """
bodies: {m: 1 kg}
links: {l: {between: [m, ground], k: 4 N/m}}
friction: {f: {between: [m, ground], N: 1 N, mu: 1, belt: 0.3 m/s}}
initial: {m: {v: 0.3 m/s}}
"""


@pytest.mark.parametrize("method", METHODS)
def test_block_on_a_belt_sticks_where_the_spring_pulls_as_hard_as_friction(method):
    """Carried to x = N / k, it slips from there for good around its equilibrium, by belt speed / w."""
    k, N, belt = 4.0, 1.0, 0.3
    result = run(case(ON_A_BELT, method))
    kinds, times = result.events["kind"].tolist(), result.events["t"]
    assert kinds[:2] == [0, 5]  # start, stick_end
    assert times[1] == pytest.approx(N / k / belt, rel=1e-14)
    after = result.samples["time"] > times[1]
    t = result.samples["time"][after] - times[1]
    expected = N / k + belt / sqrt(k) * np.sin(sqrt(k) * t)
    before_next = result.samples["time"][after] < (times[2] if len(times) > 3 else 10.0)
    assert np.abs(result.samples["x_m"][after] - expected)[before_next].max() < 1e-13


@pytest.mark.parametrize("method", METHODS)
def test_body_rubbing_on_a_free_body_ends_at_their_common_velocity(method):
    """Momentum is kept: both end at m1 v1 / (m1 + m2), after v1 / (N (1/m1 + 1/m2))."""
    m1, m2, v1, N = 2.0, 3.0, 1.5, 4.0
    text = f"""
bodies: {{a: {m1} kg, b: {m2} kg}}
friction: {{f: {{between: [a, b], N: {N} N, mu: 1}}}}
initial: {{a: {{v: {v1} m/s}}}}
"""
    result = run(case(text, method, t_end="4 s"), momentum=True)
    stick = result.events["t"][result.events["kind"] == 4]
    assert stick == pytest.approx([v1 / (N * (1 / m1 + 1 / m2))], rel=1e-15)
    for name in ("v_a", "v_b"):
        assert result.samples[name][-1] == pytest.approx(m1 * v1 / (m1 + m2), rel=1e-15)
    totals = result.totals
    assert totals["loss.friction.f"] == pytest.approx(m1 * m2 * v1**2 / (2 * (m1 + m2)), rel=1e-14)
    assert totals["momentum_start"] == totals["momentum_end"] == m1 * v1
    for name in ("impulse_ground", "impulse_base", "impulse_belt", "impulse_source"):
        assert totals[name] == 0


@pytest.mark.parametrize("method", METHODS)
def test_stack_of_stuck_blocks_moves_as_one_until_its_weakest_tie_gives_way(method):
    """Of three blocks on each other the top one slips where its acceleration passes N_top / m_top."""
    text = """
bodies: {a: 3 kg, b: 2 kg, c: 1 kg}
friction:
  bottom: {between: [a, ground], N: 6 N, mu: 1}
  middle: {between: [b, a], N: 5 N, mu: 1}
  top: {between: [c, b], N: 0.5 N, mu: 1}
forces: {drive: {on: a, F0: 12 N}}
"""
    result = run(case(text, method, t_end="2 s"))
    # the top one slips: 0.5 N moves 1 kg at 0.5; the others, 5 kg, at (12 - 6 - 0.5) / 5
    t = result.samples["time"]
    assert np.allclose(result.samples["x_c"], 0.5 * t**2 / 2, rtol=1e-14)
    assert np.allclose(result.samples["x_a"], 1.1 * t**2 / 2, rtol=1e-14)
    assert np.array_equal(result.samples["x_a"], result.samples["x_b"])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("release", ("gap", "force"))
def test_damped_stop_takes_off_as_the_half_wave_says(method, release):
    """A mass thrown at a damped wall: depth g = v/wd exp(-a t) sin(wd t); it opens at g = 0, or at k g + c
    g' = 0. What the mass loses is the stop's loss; let go at zero force, with what the spring holds.
    """
    m, k, c, v = 2.0, 800.0, 12.0, 0.7
    text = f"""
bodies: {{m: {m} kg}}
stops: {{wall: {{between: [m, ground], gap: 10 cm, acts: compression, k: {k} N/m, c: {c} N s/m,
               release: {release}}}}}
initial: {{m: {{v: {v} m/s}}}}
"""
    result = run(case(text, method, t_end="3 s"), ledger=True)
    a, wd = c / (2 * m), sqrt(k / m - (c / (2 * m)) ** 2)
    begin, end = result.events["t"][1:3]
    assert result.events["kind"][1:3].tolist() == [1, 2]
    assert begin == pytest.approx(0.1 / v, rel=1e-15)
    # k g + c g' = 0: (k - c a) sin + c wd cos = 0
    angle = pi - np.arctan2(c * wd, k - c * a) if release == AT_FORCE else pi
    duration = angle / wd
    assert end - begin == pytest.approx(duration, rel=1e-13)
    speed = v * exp(-a * duration) * (cos(angle) - a / wd * sin(angle))
    assert result.events["v_m"][2] == pytest.approx(speed, rel=1e-13)
    # free of the wall before its surface is back, or with it
    assert result.samples["wall"].max() == (2 if release == AT_FORCE else 1)
    totals, lost = result.totals, m * (v**2 - result.events["v_m"][2] ** 2) / 2
    assert 0 < lost < m * v**2 / 2
    assert totals["loss.stops.wall"] == totals["loss_stops"] == pytest.approx(lost, rel=1e-13)
    assert totals["energy_end"] == pytest.approx(m * result.events["v_m"][2] ** 2 / 2, rel=1e-14)


@pytest.mark.parametrize("method", METHODS)
def test_bilinear_frequency_between_two_stops_with_no_gap(method):
    """Stops on both sides at gap 0 act as one spring: w^2 = k / m."""
    k, m, x = 90.0, 1.6, 0.01
    text = f"""
bodies: {{m: {m} kg}}
stops:
  up: {{between: [m, ground], gap: 0 m, acts: compression, k: {k} N/m}}
  down: {{between: [m, ground], gap: 0 m, acts: extension, k: {k} N/m}}
initial: {{m: {{x: {x} m}}}}
"""
    result = run(case(text, method))
    expected = x * np.cos(sqrt(k / m) * result.samples["time"])
    assert np.abs(result.samples["x_m"] - expected).max() < 1e-14


@pytest.mark.parametrize("method", METHODS)
def test_two_parallel_springs_move_as_one(method):
    text = """
bodies: {m: 1 kg, n: 2 kg}
links:
  a: {between: [m, n], k: 30 N/m, c: 0.2 N s/m}
  b: {between: [n, m], k: 12 N/m, c: 0.1 N s/m}
  c: {between: [n, ground], k: 20 N/m}
initial: {m: {x: 2 cm}, n: {v: 0.3 m/s}}
"""
    one = {"a.k": 42, "a.c": 0.3, "links.b": "none"}
    split, joined = (run(case(text, method, changes)) for changes in ({}, one))
    assert np.abs(split.samples["x_m"] - joined.samples["x_m"]).max() < 1e-13


@pytest.mark.parametrize("method", METHODS)
def test_split_body_whose_halves_are_tied_moves_as_one(method):
    """A body cut in two, stuck together by more friction than any force: the motion of the whole."""
    text = """
bodies: {m: 3 kg}
links: {l: {between: [m, ground], k: 50 N/m}}
initial: {m: {x: 1 cm, v: 0.2 m/s}}
"""
    whole = run(case(text, method))
    halves = text.replace("m: 3 kg", "m: 1 kg, n: 2 kg").replace("0.2 m/s}", "0.2 m/s}, n: {v: 0.2 m/s}")
    split = run(case(f"{halves}friction: {{glue: {{between: [m, n], N: 1 MN, mu: 1}}}}", method))
    assert np.abs(whole.samples["x_m"] - split.samples["x_m"]).max() < 1e-14
    assert split.totals["events"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_parts_of_no_strength_change_nothing(method):
    text = """
bodies: {m: 1 kg}
links: {l: {between: [m, ground], k: 30 N/m, c: 0.5 N s/m}}
initial: {m: {x: 2 cm}}
"""
    link = {"links.z.between": "[m, ground]", "links.z.k": "0 N/m"}
    force = {"forces.zero.on": "m", "forces.zero.A": "0 N", "forces.zero.omega": "2 Hz"}
    base, more = (case(text, method, changes) for changes in ({}, link | force))
    assert np.array_equal(run(base).samples["x_m"], run(more).samples["x_m"])


@pytest.mark.parametrize("method", METHODS)
def test_stuck_block_breaks_loose_where_its_force_passes_friction(method):
    """A sin(2 pi f t) moves nothing until it passes N: at arcsin(N / A) / (2 pi f)."""
    A, N, f = 1.0, 0.9, 1.0
    text = f"""
bodies: {{m: 1 kg}}
friction: {{f: {{between: [m, ground], N: {N} N, mu: 1}}}}
forces: {{F: {{on: m, A: {A} N, omega: {f} Hz}}}}
"""
    result = run(case(text, method))
    slips = result.events["t"][result.events["kind"] == 5]
    expected = np.arcsin(N / A) / (2 * pi * f) + np.arange(20) / 2
    assert slips == pytest.approx(expected, rel=1e-14)
    assert result.totals["uncertified"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_body_between_ground_and_moving_base_follows_the_stronger_friction(method):
    """It cannot stick to both where the base rests for an instant; it starts with the base, a sin(nu t)."""
    a, nu, weak, strong = 0.01, pi, 0.02, 5.0

    def rubbing(on_base, on_ground):
        text = f"""
bodies: {{m: 1 kg}}
friction:
  b: {{between: [m, base], N: {on_base} N, mu: 1}}
  g: {{between: [m, ground], N: {on_ground} N, mu: 1}}
base: {{a: {a} m, omega: 0.5 Hz}}
initial: {{m: {{v: {a * nu} m/s}}}}
"""
        return run(case(text, method, t_end="6 s"))

    carried, braked = rubbing(strong, weak), rubbing(weak, strong)
    assert np.abs(carried.samples["x_m"] - a * np.sin(nu * carried.samples["time"])).max() < 1e-15
    assert np.ptp(braked.samples["x_m"][braked.samples["time"] > 0.1]) == 0.0
    for result, part in ((carried, 1), (braked, 0)):
        turns = result.events["kind"] == 3
        assert result.events["t"][turns] == pytest.approx([0.5, 1.5, 2.5, 3.5, 4.5, 5.5], rel=1e-14)
        assert (result.events["part"][turns] == part).all()
        assert result.totals["uncertified"] == 0


@pytest.mark.parametrize("method", METHODS)
def test_body_that_touches_a_stop_at_rest_is_in_contact_as_soon_as_it_is_pushed(method):
    """The table turns round where friction on it then tears the body off the ground, into the stop."""
    limit = 0.01 * (2 * pi) ** 2
    rate = 7.264067453591843
    text = f"""
bodies: {{m: {10**0.006} kg}}
stops: {{wall: {{between: [ground, m], gap: 0 m, acts: extension, k: {(2 * pi) ** 2} N/m}}}}
friction:
  floor: {{between: [ground, m], N: {limit} N, plus: {{mu: 1}}, minus: {{mu: 0.5}}}}
  table: {{between: [base, m], N: {limit} N, mu: 1}}
base: {{a: 3.69 mm, omega: {rate} rad/s, phase: 2 rad}}
"""
    result = run(case(text, method, t_end="0.4775 s", every="1 s"), ledger=True)
    turn = (1.5 * pi - 2.0) / rate
    begins = result.events["t"][result.events["kind"] == 1]
    assert begins[0] == pytest.approx(turn, rel=1e-14)
    assert abs(result.totals["energy_residual"]) < 1e-17

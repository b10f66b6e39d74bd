"""Exponents of scenes made of parts whose growth is known, and those of the engine of two blocks."""

from dataclasses import replace
from math import exp, inf, log, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.engine.bundles import PER_PIECE, totals, volume_bound
from tests.engine.random_parts import part_scenes
from tests.engine.runs import run, scene_of
from tests.engine.test_closed_cases import METHODS, case
from tests.random_scenes import scenes
from tests.scenes import paper
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.saltation import Saltation
from vibsim.engine.tangent.tangent_space import components, dimension, references
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import EVENT_KINDS
from vibsim.physics.two_blocks import TwoBlocks

TWO_BLOCKS = scenes(features=False).map(TwoBlocks.as_parts)


@settings(max_examples=200)
@given(st.one_of(part_scenes(), TWO_BLOCKS, TWO_BLOCKS), st.sampled_from(METHODS))
def test_volumes_of_random_scenes_grow_as_liouville_says(scene, method):
    try:
        result = totals(replace(scene, method=method))
    except EngineError:
        return  # a scene that accumulates events, say: nothing to compare
    assert abs(result["volume_residual"]) <= volume_bound(result, scene.t_end)


def test_a_reversal_that_all_but_sticks_drowns_no_volume():
    """Friction drags the body as hard as the base may hold it: only the motion of the base lets it turn
    round, and the determinant there, some 1e-5, is known to rounding / 1e-5.
    """
    result = totals(
        scene_of("""
bodies: {a: 1 kg, b: 1.8 kg}
friction:
  f: {between: [base, a], N: 0.4 N, mu: 1}
  g: {between: [a, b], N: 0.4 N, mu: 1, belt: 12.6 mm/s}
base: {a: 0.01 mm, omega: 11.3 rad/s}
run: {t_end: 0.48 s}
""")
    )
    assert result["reversals"] == 1
    assert abs(result["volume_residual"]) <= PER_PIECE * result["tangent_pieces"]


RUBBING = """
bodies: {block: 1 kg}
links: {spring: {between: [block, ground], k: 40 N/m}}
friction:
  table: {between: [block, ground], law: stribeck exponential, N: 1 N + 20 N/m*x_block, mu_s: 0.4, mu_d: 0.3,
          v0: 0.5 m/s}
forces: {push: {on: block, A: 6 N, omega: 0.8 Hz}}
initial: {block: {v: 1 m/s}}
run: {t_end: 6 s}
"""


def test_a_wrong_saltation_is_seen(monkeypatch):
    """At reversals of a friction by a formula, which Python takes disturbances through."""
    result = totals(scene_of(RUBBING))
    assert result["reversals"] == 9 and abs(result["volume_residual"]) < 1e-14
    monkeypatch.setattr(Saltation, "applied", lambda _, vector: vector)
    assert abs(totals(scene_of(RUBBING))["volume_residual"]) > 1.0


def matrix(of):
    """Of (x, v) of a scene of links to each other and the ground, from the balance of forces."""
    n = len(of.bodies)
    A = np.zeros((2 * n, 2 * n))
    A[:n, n:] = np.eye(n)
    for link in of.links:
        shape = np.zeros(n)
        for end, sign in ((link.P, 1.0), (link.Q, -1.0)):
            if end >= 0:
                shape[end] = sign
        inverse = np.diag([1 / body.m for body in of.bodies])
        A[n:, :n] -= link.k * inverse @ np.outer(shape, shape)
        A[n:, n:] -= link.c * inverse @ np.outer(shape, shape)
    return A


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("damping", [(0.8, 0.6, 0.4), (0.1, 3.0, 0.0)])  # proportional, and not
def test_linear_scenes_have_the_real_parts_of_their_eigenvalues(method, damping):
    text = """
bodies: {a: 1 kg, b: 2 kg, c: 0.5 kg}
links:
  l0: {between: [a, ground], k: 40 N/m}
  l1: {between: [b, a], k: 30 N/m}
  l2: {between: [c, b], k: 20 N/m}
forces: {f: {on: c, F0: 0.1 N, A: 0.3 N, omega: 0.7 Hz}}
initial: {a: {x: 1 cm}, b: {v: 0.1 m/s}}
"""
    of = case(text, method, {f"l{i}.c": f"{c} N s/m" for i, c in enumerate(damping)}, t_end="40 s")
    result = totals(of, begin=20.0)
    expected = np.sort(np.linalg.eigvals(matrix(of)).real)[::-1]
    # directions of a pair turn in an ellipse: each exponent is known to the logarithm of its axes over 20 s
    np.testing.assert_allclose(result["exponents"], expected, rtol=0, atol=3 / 20)
    assert sum(result["exponents"]) == pytest.approx(sum(expected), rel=1e-10)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("c", (0.0, 12.0))
def test_volume_of_a_throw_at_a_wall_shrinks_by_the_square_of_the_restitution(method, c):
    """Half a wave long contact: x' = -e v, e = exp(-pi a / wd), whatever the speed; det = e^2."""
    m, k = 2.0, 800.0
    result = totals(
        scene_of(f"""
bodies: {{m: {m} kg}}
stops: {{wall: {{between: [m, ground], gap: 10 cm, acts: compression, k: {k} N/m, c: {c} N s/m}}}}
initial: {{m: {{v: 0.7 m/s}}}}
run: {{t_end: 3 s, method: {method}}}
""")
    )
    a = c / (2 * m)
    restitution = exp(-pi * a / sqrt(k / m - a * a))
    grown = result["growth"][-1, 1:]
    assert sum(grown) == pytest.approx(2 * log(restitution), rel=1e-12, abs=1e-13)


@pytest.mark.parametrize("method", METHODS)
def test_each_of_two_bodies_that_stick_in_turn_loses_a_direction(method):
    """Apart from each other: never at rest together when one of them sticks first, yet two directions go."""
    text = """
bodies: {a: 1 kg, b: 1 kg}
friction: {f: {between: [a, ground], N: 1 N, mu: 1}, g: {between: [b, ground], N: 1 N, mu: 1}}
forces: {kick: {on: a, A: 3 N, omega: 0.1 Hz, phase: -0.3 rad}}
initial: {a: {v: 0.5 m/s}, b: {v: 2 m/s}}
"""
    # a slips again from 1.02 s on, b sticks at 2 s
    result = totals(case(text, method, t_end="2.4 s"))
    assert result["rank_losses"] == 2
    assert result["exponents"].tolist() == [-inf, -inf]
    assert abs(result["volume_residual"]) < 1e-11


@pytest.mark.parametrize("method", METHODS)
def test_a_stack_that_rides_as_one_keeps_one_velocity(method):
    """(x, v) of the whole swings undamped on a spring, two directions are held from the start."""
    text = """
bodies: {a: 3 kg, b: 2 kg, c: 1 kg}
links: {l: {between: [a, ground], k: 60 N/m}}
friction: {f0: {between: [b, a], N: 9 N, mu: 1}, f1: {between: [c, b], N: 9 N, mu: 1}}
initial: {a: {x: 1 cm}, b: {x: 1 cm}, c: {x: 1 cm}}
"""
    of = case(text, method, t_end=f"{20 * pi / sqrt(60.0 / 6.0)} s")
    result = totals(of)
    assert dimension(of) == 4 and result["rank_losses"] == 2
    np.testing.assert_allclose(result["exponents"], [0.0, 0.0, -inf, -inf], rtol=0, atol=1e-12)


def test_bodies_that_nothing_ties_to_the_ground_lose_the_shift():
    of = scene_of("""
bodies: {a: 1 kg, b: 1 kg, c: 1 kg, d: 1 kg}
links: {l: {between: [a, c], k: 1 N/m}}
stops: {s: {between: [b, base], gap: 1 cm, acts: extension, k: 5 N/m}}
friction: {f: {between: [d, a], N: 1 N, mu: 1}}
base: {a: 1 mm, omega: 1 Hz}
""")
    assert references(of) == [2, None, 2, 3]
    assert components(of) == [0, 1, 4, 5, 6, 7]


@pytest.mark.parametrize("count", [-1, 4])
def test_numbers_of_exponents_that_a_scene_has_not_got(count):
    with pytest.raises(ValueError, match=f"tangent must be 0 to 3 for this scene, got {count}"):
        open_trajectory(paper("I-A").as_parts(), tangent=count)


@pytest.mark.parametrize("name", ["I-A", "II-B"])
def test_a_bundle_changes_no_trajectory(name):
    of = paper(name, t_end=3.0).as_parts()
    plain, carrying = (run(of, tangent=count) for count in (0, dimension(of)))
    for one, other in ((plain.samples, carrying.samples), (plain.events, carrying.events)):
        assert len(one["v1"]) > 5 and list(one) == list(other)
        assert all(np.array_equal(one[column], other[column]) for column in one)


def test_friction_that_tears_off_beside_a_stop_at_rest():
    """A body that friction and a rigid stop hold at once, which holds any force one way, is torn off by
    A sin(omega t) at the limit H of the friction, close to the crest: at the rate A omega cos(omega t) with
    sin(omega t) = H / A, over H times the natural rate sqrt(k / m).
    """
    amplitude, limit, omega, k = 1.1001, 1.1, 3.0, 4.0
    of = scene_of(f"""
bodies: {{block: 1 kg}}
links: {{spring: {{between: [block, ground], k: {k} N/m, c: 0.1 N s/m}}}}
stops: {{wall: {{between: [block, ground], gap: 0 m, acts: extension, law: rigid, e: 0.5}}}}
friction: {{rail: {{between: [block, ground], N: 0.5 N, mu: 1, static: {limit / 0.5}}}}}
forces: {{drive: {{on: block, A: {amplitude} N, omega: {omega} rad/s}}}}
run: {{t_end: 0.55 s}}  # the crest is at 0.524 s
""")
    found = run(of, tangent=2)
    assert {EVENT_KINDS["rest_end"], EVENT_KINDS["stick_end"]} <= set(found.events["kind"])
    rate = omega * sqrt(amplitude**2 - limit**2)
    share = (rate / (limit * sqrt(k))) ** 2
    assert found.totals["closest_tangency"] == pytest.approx(share, rel=1e-9)

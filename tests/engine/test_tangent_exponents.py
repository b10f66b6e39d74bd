"""Exponents of scenes made of parts whose growth is known, and those of the engine of two blocks."""

from math import exp, inf, log, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings

from tests.engine.bundles import PER_PIECE, totals
from tests.engine.random_parts import part_scenes
from tests.engine.runs import scene_of
from tests.engine.test_closed_cases import harmonic, scene
from tests.scenes import paper
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.saltation import Saltation
from vibsim.engine.tangent.tangent_space import components, dimension, references
from vibsim.engine.trajectory import open_trajectory
from vibsim.physics.parts import (
    AT_GAP,
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
    RigidStop,
    Scene,
    Stop,
)

METHODS = ("auto", "taylor")


@settings(max_examples=25)
@given(part_scenes())
def test_volumes_of_random_scenes_grow_as_liouville_says(scene):
    try:
        result = totals(scene)
    except EngineError:
        return  # a scene that accumulates events, say: nothing to compare
    assert abs(result["volume_residual"]) <= PER_PIECE * result["tangent_pieces"]


def test_a_reversal_that_all_but_sticks_drowns_no_volume():
    """Friction drags the body as hard as the base may hold it: only the motion of the base lets it turn
    round, and the determinant there, some 1e-5, is known to rounding / 1e-5.
    """
    N, pace = 0.4, 11.3
    bodies = [Body("a", 1.0, 0.0, 0.0), Body("b", 1.8, 0.0, 0.0)]
    frictions = (Friction("f", BASE, 0, N, N, 0.0), Friction("g", 0, 1, N, N, 0.0126))
    base = (harmonic(1e-5, pace / (2 * pi)),)
    result = totals(scene(bodies, frictions=frictions, base=base, t_end=0.48))
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


def chain(method, damping, **parts):
    """Three bodies on springs between a wall and the open end; damping by link [N s/m]."""
    bodies = [Body("a", 1.0, 0.01, 0.0), Body("b", 2.0, 0.0, 0.1), Body("c", 0.5, 0.0, 0.0)]
    ends = [(0, GROUND), (1, 0), (2, 1)]
    links = [
        Link(f"l{i}", P, Q, k, c)
        for i, ((P, Q), k, c) in enumerate(zip(ends, (40.0, 30.0, 20.0), damping, strict=True))
    ]
    return scene(bodies, method, links=tuple(links), **parts)


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
    of = chain(method, damping, t_end=40.0, forces=(Force("f", 2, 0.1, (harmonic(0.3, 0.7),)),))
    result = totals(of, begin=20.0)
    expected = np.sort(np.linalg.eigvals(matrix(of)).real)[::-1]
    # directions of a pair turn in an ellipse: each exponent is known to the logarithm of its axes over 20 s
    np.testing.assert_allclose(result["exponents"], expected, rtol=0, atol=3 / 20)
    assert sum(result["exponents"]) == pytest.approx(sum(expected), rel=1e-10)


@pytest.mark.parametrize("method", METHODS)
def test_volume_of_a_throw_at_a_damped_wall_shrinks_by_the_square_of_the_restitution(method):
    """Half a wave long contact: x' = -e v, e = exp(-pi a / wd), whatever the speed; det = e^2."""
    m, k, c = 2.0, 800.0, 12.0
    stop = Stop("wall", 0, GROUND, 0.1, COMPRESSION, k, c, AT_GAP)
    result = totals(scene([Body("m", m, 0.0, 0.7)], method, stops=(stop,), t_end=3.0))
    a = c / (2 * m)
    restitution = exp(-pi * a / sqrt(k / m - a * a))
    grown = result["growth"][-1, 1:]
    assert sum(grown) == pytest.approx(2 * log(restitution), rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_each_of_two_bodies_that_stick_in_turn_loses_a_direction(method):
    """Apart from each other: never at rest together when one of them sticks first, yet two directions go."""
    bodies = [Body("a", 1.0, 0.0, 0.5), Body("b", 1.0, 0.0, 2.0)]
    frictions = (Friction("f", 0, GROUND, 1.0, 1.0, 0.0), Friction("g", 1, GROUND, 1.0, 1.0, 0.0))
    drive = (
        Force("kick", 0, 0.0, (harmonic(3.0, 0.1, -0.3),)),
    )  # a slips again from 1.02 s on, b sticks at 2 s
    of = scene(bodies, method, frictions=frictions, forces=drive, t_end=2.4)
    result = totals(of)
    assert result["rank_losses"] == 2
    assert result["exponents"].tolist() == [-inf, -inf]
    assert abs(result["volume_residual"]) < 1e-11


@pytest.mark.parametrize("method", METHODS)
def test_a_stack_that_rides_as_one_keeps_one_velocity(method):
    """Three blocks on each other on a spring: (x, v) of the whole swings undamped, two directions are held
    from the start.
    """
    bodies = [Body(name, m, 0.01, 0.0) for name, m in zip("abc", (3.0, 2.0, 1.0), strict=True)]
    frictions = tuple(Friction(f"f{i}", i + 1, i, 9.0, 9.0, 0.0) for i in range(2))
    rate = sqrt(60.0 / 6.0)
    of = scene(
        bodies,
        method,
        frictions=frictions,
        links=(Link("l", 0, GROUND, 60.0, 0.0),),
        t_end=10 * 2 * pi / rate,
    )
    result = totals(of)
    assert dimension(of) == 4 and result["rank_losses"] == 2
    np.testing.assert_allclose(result["exponents"], [0.0, 0.0, -inf, -inf], rtol=0, atol=1e-12)


def test_bodies_that_nothing_ties_to_the_ground_lose_the_shift():
    bodies = [Body(name, 1.0, 0.0, 0.0) for name in "abcd"]
    links = (Link("l", 0, 2, 1.0, 0.0),)
    stops = (Stop("s", 1, BASE, 0.01, EXTENSION, 5.0, 0.0),)
    rubbing = (Friction("f", 3, 0, 1.0, 1.0, 0.0),)
    of = scene(bodies, links=links, stops=stops, frictions=rubbing, base=(harmonic(0.001, 1.0),))
    assert references(of) == [2, None, 2, 3]
    assert components(of) == [0, 1, 4, 5, 6, 7]


@pytest.mark.parametrize("count", [-1, 4])
def test_numbers_of_exponents_that_a_scene_has_not_got(count):
    with pytest.raises(ValueError, match=f"tangent must be 0 to 3 for this scene, got {count}"):
        open_trajectory(paper("I-A").as_parts(), tangent=count)


@pytest.mark.parametrize("name", ["I-A", "II-B"])
def test_a_bundle_changes_no_trajectory(name):
    of = paper(name, t_end=3.0).as_parts()
    plain, carrying = (open_trajectory(of, tangent=count) for count in (0, dimension(of)))
    for one, other in zip(whole(plain), whole(carrying), strict=True):
        assert len(one["v1"]) > 5 and list(one) == list(other)
        assert all(np.array_equal(one[column], other[column]) for column in one)


def whole(trajectory):
    """Samples and events of a run."""
    blocks = list(trajectory.blocks())
    for tables in ([b.samples for b in blocks], [b.events for b in blocks]):
        yield {name: np.concatenate([table[name] for table in tables]) for name in tables[0]}


def test_volume_of_a_throw_at_an_elastic_wall_is_kept():
    bare = Stop("wall", 0, GROUND, 0.1, COMPRESSION, 800.0, 0.0, AT_GAP)
    throw = scene([Body("m", 2.0, 0.0, 0.7)], stops=(bare,), t_end=3.0)
    assert sum(totals(throw)["growth"][-1, 1:]) == pytest.approx(0.0, abs=1e-13)


def test_friction_that_tears_off_beside_a_stop_at_rest():
    """A body that friction and a rigid stop hold at once, which holds any force one way, is torn off by
    A sin(omega t) at the limit H of the friction, close to the crest: at the rate A omega cos(omega t) with
    sin(omega t) = H / A, over H times the natural rate sqrt(k / m).
    """
    amplitude, limit, omega, k = 1.1001, 1.1, 3.0, 4.0
    drive = Harmonic(amplitude, omega, omega / (2 * pi), 0.0, 0.0)
    of = Scene(
        bodies=(Body("block", 1.0, 0.0, 0.0),),
        links=(Link("spring", 0, GROUND, k, 0.1),),
        stops=(RigidStop("wall", 0, GROUND, 0.0, EXTENSION, 0.5, at_start=True),),
        frictions=(Friction("rail", 0, GROUND, 0.5, 0.5, 0.0, limit, limit),),
        forces=(Force("drive", 0, 0.0, (drive,)),),
        t_end=0.55,  # the crest is at 0.524 s
    )
    trajectory = open_trajectory(of, tangent=2)
    kinds = np.concatenate([block.events["kind"] for block in trajectory.blocks()])
    assert EVENT_KINDS["rest_end"] in kinds and EVENT_KINDS["stick_end"] in kinds
    rate = omega * sqrt(amplitude**2 - limit**2)
    share = (rate / (limit * sqrt(k))) ** 2
    assert trajectory.totals["closest_tangency"] == pytest.approx(share, rel=1e-9)

"""Several ties between ends at rest to each other: ground, a base of amplitude 0, belts of equal speed.

A scene is judged by one that says the same otherwise: its parts hung on the ground, or frictions between the
same ends put together to one.
"""

import math
from collections import Counter
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import strategies as st

from tests.engine.random_parts import LENGTH, part_scenes, rigid_scenes
from tests.engine.runs import differences, outcome, run
from tests.random_scenes import always
from vibsim.physics.formulas import mul, num
from vibsim.physics.parts import (
    BASE,
    EVENT_KINDS,
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

W = 2 * math.pi
RESTS = (Harmonic(0.0, W, 1.0, 0.0, 0.5), Harmonic(-0.0, 2 * W, 2.0, 0.0, 0.0))
JOINED = ("links", "stops", "frictions")
OF_FRICTIONS = {EVENT_KINDS[name] for name in ("reversal", "stick_begin", "stick_end")}
LEDGERS = {"ledger": True, "momentum": True}


def moved(part, old, new):
    """A part with one end for another."""
    return replace(part, **{side: new for side in ("P", "Q") if getattr(part, side) == old})


def rehung(scene):
    """The scene with the parts of its base on the ground."""
    return replace(
        scene, **{name: tuple(moved(p, BASE, GROUND) for p in getattr(scene, name)) for name in JOINED}
    )


@st.composite
def resting(draw, scenes):
    """A scene whose base rests; parts on the ground or the base hang on either."""
    scene = draw(scenes)
    hung = {
        name: tuple(
            moved(moved(part, BASE, GROUND), GROUND, draw(st.sampled_from((GROUND, BASE))))
            for part in getattr(scene, name)
        )
        for name in JOINED
    }
    return replace(scene, base=RESTS[: draw(st.integers(1, 2))], **hung)


def halved(friction, number):
    """One of two frictions that make up one."""

    def half(force):
        return None if force is None else force / 2

    slips = friction.slips and tuple(mul(num(Fraction(1, 2)), one) for one in friction.slips)
    forces = {
        way: half(getattr(friction, way)) for way in ("forward", "backward", "hold_forward", "hold_backward")
    }
    one = replace(friction, name=f"{friction.name}{number}", slips=slips, **forces)
    return moved(one, GROUND, BASE) if number else one


def twofold(scene):
    """Every friction as two of half the force between the same ends, the second one on the base."""
    return replace(scene, frictions=tuple(halved(f, number) for f in scene.frictions for number in (0, 1)))


def told(result, first, frictions=1):
    """How often each event (kind, part) is told; first: number of the first friction; frictions: how
    many tell of one and the same.
    """
    counts, latest = Counter(), {}
    for kind, part, t in zip(*(result.events[name].tolist() for name in ("kind", "part", "t")), strict=True):
        key = kind, (part - first) // frictions if kind in OF_FRICTIONS else part
        if frictions == 1 or kind not in OF_FRICTIONS or latest.get(key) != t:
            counts[key] += 1
        latest[key] = t
    return counts


def assert_same_as_on_ground(scene):
    one, other = (outcome(each, **LEDGERS) for each in (scene, rehung(scene)))
    if isinstance(one, str):
        assert one == other
    else:
        assert differences(one, other) == []


def assert_twofold_is_one(scene):
    one, two = run(scene), run(twofold(scene))
    if one.totals["uncertified"] or two.totals["uncertified"]:
        return
    for name in (column for column in one.samples if column.startswith("x_")):
        assert np.abs(one.samples[name] - two.samples[name]).max() < 1e-10 * LENGTH
    first = len(scene.stops)
    assert told(one, first) == told(two, first, frictions=2)


test_resting_base_is_ground = always(assert_same_as_on_ground, resting(part_scenes()), few=25, many=1000)
test_resting_base_is_ground_to_rigid_stops = always(
    assert_same_as_on_ground, resting(rigid_scenes()), few=40, many=1000
)
test_two_frictions_are_their_sum = always(
    assert_twofold_is_one, resting(part_scenes()).map(rehung), few=25, many=2000
)


def oscillators(frictions, bodies=1, x=0.01, stops=()):
    """Bodies on springs, the first one driven; frictions: (P, Q, force of slip, belt, most it holds)."""
    return Scene(
        bodies=tuple(Body(f"b{i}", 1.0, x * (1 - i / 2), 0.0) for i in range(bodies)),
        links=tuple(Link(f"l{i}", i, GROUND, W * W, 0.0) for i in range(bodies)),
        stops=tuple(stops),
        frictions=tuple(
            Friction(f"f{i}", P, Q, N, N, belt, hold, hold)
            for i, (P, Q, N, belt, hold) in enumerate(frictions)
        ),
        forces=(Force("drive", 0, 0.0, (Harmonic(0.1, 0.7 * W, 0.7, 0.0, 0.0),)),),
        base=RESTS[:1],
        t_end=4.0,
        every_den=40,
    )


SCENES = {
    "ground and base": oscillators([(0, GROUND, 0.05, 0.0, None), (0, BASE, 0.03, 0.0, None)]),
    "belts on both": oscillators([(0, GROUND, 0.05, 0.02, None), (BASE, 0, 0.03, -0.02, None)]),
    "belt and base": oscillators([(0, GROUND, 0.05, 0.02, None), (0, BASE, 0.2, 0.0, 0.3)]),
    "two bodies": oscillators(
        [(0, BASE, 0.1, 0.0, 0.2), (1, 0, 0.2, 0.0, 0.3), (1, GROUND, 0.3, 0.0, 0.4)], bodies=2
    ),
    "elastic and rigid stops": oscillators(
        [(0, BASE, 0.02, 0.0, None), (0, GROUND, 0.03, 0.0, 0.1)],
        stops=(
            Stop("soft", 0, BASE, 0.001, 1, 20 * W * W, 0.5, "force"),
            RigidStop("hard", 0, BASE, 0.002, -1, 0.5),
            RigidStop("wall", GROUND, 0, 0.004, -1, 0.5),
        ),
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_known_scene_is_that_on_ground(name):
    """The first ended with the error of more than 64 events at one instant."""
    scene = SCENES[name]
    assert_same_as_on_ground(scene)
    result = run(scene, **LEDGERS)
    assert result.totals["uncertified"] == (1 if scene.rigid_stops else 0)
    assert abs(result.totals["energy_residual"]) < 1e-14  # of some 1 J and 1 N s
    assert abs(result.totals["momentum_residual"]) < 1e-14  # of some 1 J and 1 N s
    assert "impulse.base" not in result.totals


def test_limits_of_ground_and_base_add_up():
    """0.05 N on the ground and 0.03 N on the base are 0.08 N on the ground."""
    N = 0.05 + 0.03
    two = run(SCENES["ground and base"])
    one = run(oscillators([(0, GROUND, N, 0.0, None)]))
    assert np.abs(two.samples["x_b0"] - one.samples["x_b0"]).max() < 1e-14
    both = two.events["t"][two.events["part"] == 0], two.events["t"][two.events["part"] == 1]
    assert np.array_equal(*both)  # the two hold, slip and turn at the same instants
    assert np.abs(both[0] - one.events["t"][one.events["part"] == 0]).max() < 1e-12


@pytest.mark.parametrize("belts", [(0.1, 0.2, 0.3), (0.3, -0.1, 0.2), (-0.3, 0.1, -0.2)])
def test_speeds_of_belts_add_up(belts):
    """Speeds equal in the case but not as sums of doubles: the motion is that of sums equal to the bit."""

    def chain(last):
        ties = [(0, GROUND, 2.0, belts[0], None), (1, 0, 2.0, belts[1], None), (1, BASE, 2.0, last, None)]
        return oscillators(ties, bodies=2, x=0.001)

    assert belts[0] + belts[1] != belts[2]
    rounded, exact = (run(chain(last)) for last in (belts[2], belts[0] + belts[1]))
    for column in ("kind", "part"):
        assert rounded.events[column].tolist() == exact.events[column].tolist()
    assert np.abs(rounded.samples["x_b1"] - exact.samples["x_b1"]).max() < 1e-14
    assert {0, 1, 2} <= set(exact.events["part"].tolist())

"""Forces that set in smoothly, F (1 - cos wt): neither they nor their rates are there at t = 0. Quarter turns
are none of the numbers, and what rounding leaves of their cosine pushed bodies to and fro within 1e-16 s.
"""

import math
from itertools import pairwise, product

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.engine.runs import run as run_parts
from tests.events.special_scenes import harmonic
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import (
    COMPRESSION,
    EVENT_KINDS,
    EXTENSION,
    GROUND,
    Body,
    Force,
    Link,
    RigidStop,
    Scene,
    Stop,
)

OMEGA = 5.0


def pushed(sign, k, count, law, acts):
    """Bodies of 1 kg in a row at rest, of which the last touches the wall; the first is pushed by
    sign (1 - cos OMEGA t) N, and held by a spring k [N/m].
    """
    bodies = tuple(Body(f"b{i}", 1.0, 0.0, 0.0) for i in range(count))
    links = [Link(f"l{i}", i, i - 1 if i else GROUND, 100.0 if i else k, 0.0) for i in range(count)]
    ends = "wall", count - 1, GROUND, 0.0, acts
    stop = RigidStop(*ends, 0.5, True) if law == "rigid" else Stop(*ends, 3000.0, 0.0, at_start=True)
    push = Force("push", 0, sign, (harmonic(1.0, OMEGA, -sign * math.pi / 2),))
    sprung = tuple(link for link in links if link.k > 0)
    return Scene(bodies, sprung, (stop,), (), (push,), t_end=5.0, every_num=1, every_den=50)


@pytest.mark.parametrize(
    ("k", "count", "law", "pressed"), list(product((0.0, 200.0), (1, 2), ("rigid", "elastic"), (True, False)))
)
def test_bodies_at_rest_on_a_wall_are_set_in_motion_from_either_side(k, count, law, pressed):
    acts = (EXTENSION, COMPRESSION) if pressed else (COMPRESSION, EXTENSION)
    one, other = (
        run_parts(pushed(sign, k, count, law, way)) for sign, way in zip((-1.0, 1.0), acts, strict=True)
    )
    np.testing.assert_allclose(one.samples["x_b0"], -other.samples["x_b0"], atol=1e-10)
    assert np.array_equal(one.events["kind"], other.events["kind"])


def test_the_body_on_the_wall_rests_until_the_one_before_it_comes_back():
    """Held by 300 N/m, that one moves as the closed form says; where it passes 0 the other is pulled off."""
    run = run_parts(pushed(-1.0, 200.0, 2, "rigid", EXTENSION))
    rate = math.sqrt(300.0)

    def place(t):
        return -(1 - math.cos(rate * t)) / 300 + (math.cos(OMEGA * t) - math.cos(rate * t)) / 275

    first = int(np.flatnonzero(run.events["kind"] == EVENT_KINDS["rest_end"])[0])
    assert first == 1  # behind the start
    before = run.samples["time"] < run.events["t"][first]
    expected = [place(t) for t in run.samples["time"][before]]
    np.testing.assert_allclose(run.samples["x_b0"][before], expected, atol=1e-15)
    assert not run.samples["x_b1"][before].any()
    times = np.linspace(0.2, 2.0, 2000)
    after = next(b for a, b in pairwise(times) if place(a) < 0 <= place(b))
    assert run.events["t"][first] == pytest.approx(brentq(place, after - 1e-3, after, xtol=1e-15), abs=1e-12)


@pytest.mark.parametrize("quarters", [-3, -2, -1, 1, 2, 3])
def test_of_quarter_turns_sine_and_cosine_are_whole(quarters):
    exact = [(0, 1), (1, 0), (0, -1), (-1, 0)][quarters % 4]
    assert Doubles.rounded_sine_cosine(quarters * math.pi / 2) == exact
    beside = Doubles.rounded_sine_cosine(quarters * math.pi / 2 + 1e-14)
    assert beside == Doubles.sine_cosine(quarters * math.pi / 2 + 1e-14) and all(beside)

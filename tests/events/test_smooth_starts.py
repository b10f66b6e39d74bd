"""Forces that set in smoothly, F (1 - cos wt): neither they nor their rates are there at t = 0. Quarter turns
are none of the numbers, and what rounding leaves of their cosine pushed bodies to and fro within 1e-16 s.
"""

import math
from itertools import pairwise, product

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.engine.runs import run, scene_of
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import EVENT_KINDS

OMEGA = 5.0


def pushed(sign, k, count, law, acts):
    """Bodies of 1 kg in a row at rest, of which the last touches the wall; the first is pushed by
    sign (1 - cos OMEGA t) N, and held by a spring k [N/m].
    """
    links = [f"l0: {{between: [b0, ground], k: {k} N/m}}"] * (k > 0)
    links += ["l1: {between: [b1, b0], k: 100 N/m}"] * (count > 1)
    return scene_of(f"""
bodies: {{{", ".join(f"b{i}: 1 kg" for i in range(count))}}}
links: {{{", ".join(links)}}}
stops: {{wall: {{between: [b{count - 1}, ground], gap: 0 m, acts: {acts}, {law}}}}}
forces: {{push: {{on: b0, F0: {sign} N, A: 1 N, omega: {OMEGA} rad/s, phase: {-90 * sign} deg}}}}
run: {{t_end: 5 s, every: 20 ms}}
""")


RIGID, ELASTIC = "law: rigid, e: 0.5", "k: 3000 N/m"


@pytest.mark.parametrize(
    ("k", "count", "law", "pressed"), list(product((0, 200), (1, 2), (RIGID, ELASTIC), (True, False)))
)
def test_bodies_at_rest_on_a_wall_are_set_in_motion_from_either_side(k, count, law, pressed):
    acts = ("extension", "compression")[:: 1 if pressed else -1]
    one, other = (run(pushed(sign, k, count, law, way)) for sign, way in zip((-1, 1), acts, strict=True))
    np.testing.assert_allclose(one.samples["x_b0"], -other.samples["x_b0"], atol=1e-10)
    assert np.array_equal(one.events["kind"], other.events["kind"])


def test_the_body_on_the_wall_rests_until_the_one_before_it_comes_back():
    """Held by 300 N/m, that one moves as the closed form says; where it passes 0 the other is pulled off."""
    found = run(pushed(-1, 200, 2, RIGID, "extension"))
    rate = math.sqrt(300.0)

    def place(t):
        return -(1 - math.cos(rate * t)) / 300 + (math.cos(OMEGA * t) - math.cos(rate * t)) / 275

    first = int(np.flatnonzero(found.events["kind"] == EVENT_KINDS["rest_end"])[0])
    assert first == 1  # behind the start
    before = found.samples["time"] < found.events["t"][first]
    expected = [place(t) for t in found.samples["time"][before]]
    np.testing.assert_allclose(found.samples["x_b0"][before], expected, atol=1e-15)
    assert not found.samples["x_b1"][before].any()
    times = np.linspace(0.2, 2.0, 2000)
    after = next(b for a, b in pairwise(times) if place(a) < 0 <= place(b))
    assert found.events["t"][first] == pytest.approx(
        brentq(place, after - 1e-3, after, xtol=1e-15), abs=1e-12
    )


@pytest.mark.parametrize("quarters", [-3, -2, -1, 1, 2, 3])
def test_of_quarter_turns_sine_and_cosine_are_whole(quarters):
    exact = [(0, 1), (1, 0), (0, -1), (-1, 0)][quarters % 4]
    assert Doubles.rounded_sine_cosine(quarters * math.pi / 2) == exact
    beside = Doubles.rounded_sine_cosine(quarters * math.pi / 2 + 1e-14)
    assert beside == Doubles.sine_cosine(quarters * math.pi / 2 + 1e-14) and all(beside)

"""Closed form and Taylor series are two ways to one trajectory: same events, same times, same states."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings

from tests.random_scenes import RADIANS, scenes
from tests.scenes import TABLE_1, paper
from tests.trajectories import run

# Both flows round each event and step to a few eps of the largest state; over the 40 rad of a run, with some
# ten events, an error grows as the difference of neighbours does, by 1e3 or so at most: 1e3 x 100 eps = 1e-11
STATE, TIME = 1e-10, 1e-10


def scale(column):
    return float(np.max(np.abs(column), initial=0.0))


def sizes(scene, result):
    """Largest displacement [m] and velocity [m/s], at least what that displacement would swing with."""
    size = max(scale(result.samples[name]) for name in result.samples if name.startswith("x"))
    speed = max(scale(result.samples[name]) for name in result.samples if name.startswith("v"))
    return size, max(speed, size * RADIANS / scene.t_end)


def transversal(scene):
    """Whether contacts and violations begin and end at speed: a grazing one has a time known to sqrt(eps)."""
    result = run(replace(scene, method="closed_form"))
    crossing = np.isin(result.events["kind"], (1, 2, 6, 7))
    rate = np.abs(result.events["v1"] - result.events.get("v2", 0.0))[crossing]
    margin = result.totals["grazing_margin"]
    size, speed = sizes(scene, result)
    return np.all(rate > 1e-4 * speed) and not margin < 1e-6 * size


def assert_same_trajectory(scene):
    one = run(replace(scene, method="closed_form"))
    other = run(replace(scene, method="taylor"))
    clear = scene.t_end * (1 - 10 * TIME)  # an event just at the end happens in one and not in the other
    count = int(np.sum(one.times < clear))
    assert one.kinds[:count] == other.kinds[:count]
    assert count == np.sum(other.times < clear)
    np.testing.assert_allclose(one.times[:count], other.times[:count], rtol=0, atol=TIME * scene.t_end)
    size, speed = sizes(scene, one)
    for name in one.samples:
        bound = STATE * (size if name.startswith("x") else speed)
        if name in ("contact", "friction"):
            continue
        np.testing.assert_allclose(one.samples[name], other.samples[name], rtol=0, atol=bound, err_msg=name)
    return one, other


@settings(max_examples=100)
@given(scenes(sources=("none", "harmonic")))
def test_random_ideal_scenes(scene):
    assume(transversal(scene))
    assert_same_trajectory(scene)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=3000)
@given(scenes(sources=("none", "harmonic")))
def test_many_random_ideal_scenes(scene):
    assume(transversal(scene))
    assert_same_trajectory(scene)


@pytest.mark.parametrize("name", TABLE_1)
def test_papers_cases(name):
    one, other = assert_same_trajectory(paper(name, t_end=30.0))
    assert other.totals["grazing_margin"] == pytest.approx(one.totals["grazing_margin"], abs=1e-12)
    assert other.totals["grazing_time"] == pytest.approx(one.totals["grazing_time"], abs=1e-6)

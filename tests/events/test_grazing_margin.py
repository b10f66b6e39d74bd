"""The grazing margin: the smallest distance from contact at which the gap function turned round."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.random_scenes import scenes
from tests.scenes import fixed_block
from tests.trajectories import run

SAMPLES = 20000
METHODS = ("closed_form", "taylor")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("c", (0.0, 0.4, 4.0))
def test_a_swing_that_stays_before_the_stop(method, c):
    """Pushed off the stop, block 1 follows x1 = -(v / wd) exp(-a t) sin(wd t) to its second extreme."""
    m1, k1, v, G = 2.0, 98.0, 0.15, 0.08
    swing = fixed_block(m1=m1, k1=k1, c=c, k2=1684.0, G=G, stop_sign=-1, v1=-v, t_end=1.3, method=method)
    a = c / (2 * m1)
    wd = math.sqrt(k1 / m1 - a * a)
    t = (math.atan2(wd, a) + math.pi) / wd
    closest = G + v / wd * math.exp(-a * t) * math.sin(wd * t)
    result = run(swing)
    assert result.kinds == []
    assert result.totals["grazing_margin"] == pytest.approx(closest, rel=1e-12)
    assert result.totals["grazing_time"] == pytest.approx(t, abs=1e-6)


def smallest_turn(scene):
    """Smallest minimum of the distance from contact that samples show, and the largest distance [m]."""
    dense = replace(scene, every_num=1, every_den=max(1, round(SAMPLES / scene.t_end)))
    result = run(dense)
    samples = result.samples
    y = samples["x1"] - samples.get("x2", 0.0)
    distance = scene.stop_sign * y + scene.G
    before, here, after = distance[:-2], distance[1:-1], distance[2:]
    turn = (here < before) & (here <= after) & (samples["contact"][1:-1] == 0)
    events = result.events["t"][1:-1]
    first = np.searchsorted(events, samples["time"][:-2])
    turn &= first == np.searchsorted(events, samples["time"][2:])
    bend = before - 2 * here + after
    turn &= bend > 1e-10 * np.max(np.abs(distance))  # not the last bits of a distance that stays
    shift = np.where(bend > 0, (before - after) ** 2 / (8 * np.where(bend > 0, bend, 1.0)), 0.0)
    return float(np.min((here - shift)[turn], initial=np.inf)), float(np.max(np.abs(distance)))


def assert_margin(scene):
    expected, size = smallest_turn(scene)
    margin = run(scene).totals["grazing_margin"]
    # a turn at an event itself may count or not: only what sampling sees between events must be covered
    if np.isfinite(expected):
        assert margin <= expected + 1e-6 * size
    return margin


@settings(max_examples=60)
@given(scenes(sources=("none", "harmonic"), features=False).filter(lambda scene: scene.has_stop))
def test_random_scenes_by_closed_form(scene):
    assert_margin(scene)


@settings(max_examples=60)
@given(scenes(features=False).filter(lambda scene: scene.has_stop))
def test_random_scenes_by_taylor(scene):
    assert_margin(replace(scene, method="taylor"))

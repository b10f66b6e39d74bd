"""No missed event: on samples as dense as wanted the state never contradicts the mode it is reported in.

Samples are read off the flow between the events found, a few thousand per run: if an event were missed, the
gap function, the sliding velocity or the friction force would leave its mode's range between two events.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, MOTORS, paper
from tests.trajectories import run

SAMPLES = 4000
ROUNDING = 1e-12  # relative to the largest value of each kind: some 1e3 events and steps of a few eps each


def dense(scene):
    """The scene with SAMPLES samples over its run."""
    return replace(scene, every_num=1, every_den=max(1, round(SAMPLES / scene.t_end)))


def largest(*arrays):
    return max(float(np.max(np.abs(array), initial=0.0)) for array in arrays)


def violations(scene, samples):
    """Names of the conditions that a sample breaks beyond rounding."""
    x2, v2 = samples.get("x2", np.zeros(1)), samples.get("v2", np.zeros(1))
    y, u = samples["x1"] - x2, samples["v1"] - v2
    contact = samples.get("contact", np.zeros(len(y)))
    broken = set()
    if scene.has_stop:
        gap, room = -scene.stop_sign * y - scene.G, ROUNDING * (largest(samples["x1"], x2) + abs(scene.G))
        broken |= {"free beyond the gap"} if np.any(gap[contact == 0] > room) else set()
        broken |= {"contact within the gap"} if np.any(gap[contact == 1] < -room) else set()
    if scene.has_friction:
        friction = samples["friction"]
        spring = scene.k1 * y + scene.c * u
        if scene.has_stop:
            spring = spring + contact * scene.k2 * (y + scene.stop_sign * scene.G)
        stiffness = scene.k1 + (scene.k2 or 0.0)
        room = ROUNDING * (stiffness * largest(samples["x1"], x2) + scene.c * largest(u) + scene.N)
        broken |= {"slips while held"} if np.any(v2[friction == 0] != 0) else set()
        broken |= (
            {"held beyond the limit"} if np.any(np.abs(spring[friction == 0]) > scene.N + room) else set()
        )
        room = ROUNDING * largest(v2, samples["v1"])
        broken |= {"slips backwards"} if np.any(friction * v2 < -room) else set()
    return broken


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
@pytest.mark.parametrize("name", CASE_NAMES)
def test_papers_cases(name, method):
    if name in MOTORS:
        method = "auto"
    scene = paper(name, method=method, t_end=20.0, every_den=5000)
    result = run(scene)
    assert violations(scene, result.samples) == set()
    assert result.totals["impacts"] > 5


@settings(max_examples=80)
@given(scenes(sources=("none", "harmonic"), radians=100.0))
def test_random_scenes_by_closed_form(scene):
    scene = dense(scene)
    assert violations(scene, run(scene).samples) == set()


@settings(max_examples=80)
@given(scenes(radians=100.0))
def test_random_scenes_by_taylor(scene):
    scene = dense(replace(scene, method="taylor"))
    assert violations(scene, run(scene).samples) == set()


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=4000)
@given(scenes(sources=("none", "harmonic"), radians=200.0))
def test_many_random_scenes_by_closed_form(scene):
    scene = dense(scene)
    assert violations(scene, run(scene).samples) == set()


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=4000)
@given(scenes(radians=200.0))
def test_many_random_scenes_by_taylor(scene):
    scene = dense(replace(scene, method="taylor"))
    assert violations(scene, run(scene).samples) == set()


def test_a_missed_event_would_be_seen():
    scene = paper("I-A", t_end=5.0, every_den=1000)
    samples = dict(run(scene).samples)
    assert violations(scene, samples) == set()
    assert violations(scene, {**samples, "contact": 0 * samples["contact"]}) == {"free beyond the gap"}
    assert "slips backwards" in violations(scene, {**samples, "friction": np.abs(samples["friction"])})

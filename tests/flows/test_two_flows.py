"""Closed form and Taylor series are two ways to one trajectory: same events, same times, same states."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings

from tests.engine import runs
from tests.engine.random_parts import LENGTH, part_scenes
from tests.random_scenes import RADIANS, scenes
from tests.scenes import TABLE_1, paper
from tests.trajectories import run
from vibsim.engine.flows.closed.matrices import jacobi
from vibsim.physics.numbers import Doubles

# Two blocks.


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


# Scenes of parts.


CLOSE = 1e-10 * LENGTH  # rounding of some hundred steps of 1e-16 each, grown by a few impacts
SOON = 1e-14  # s; nearer than some roundings of times: twin stops and symmetric bodies meet in any order


def in_order(events):
    """Events as [(kind, part)], those that rounding alone puts in an order by kind and part."""
    instants, latest = [], None
    for t, *what in zip(*(events[name].tolist() for name in ("t", "kind", "part")), strict=True):
        if latest is None or t - latest > SOON:
            instants.append([])
        instants[-1].append(what)
        latest = t
    return [what for instant in instants for what in sorted(instant)]


def assert_flows_agree(scene):
    closed, taylor = runs.run(scene), runs.run(replace(scene, method="taylor"))
    if closed.totals["uncertified"] or taylor.totals["uncertified"]:
        return  # a start at a gap or at rest, where rounding may decide
    assert in_order(closed.events) == in_order(taylor.events)
    for name in (column for column in closed.samples if column.startswith("x_")):
        assert np.abs(closed.samples[name] - taylor.samples[name]).max() < CLOSE


@settings(max_examples=50)
@given(part_scenes(motor=False))
def test_flows_agree_on_random_scenes(scene):
    assert_flows_agree(scene)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=5000)
@given(part_scenes(motor=False))
def test_flows_agree_on_many_random_scenes(scene):
    assert_flows_agree(scene)


# Normal coordinates: what goes there and back is what it was.


@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-6, 1e-3, 0.3, -1e-6, -0.3])
@pytest.mark.parametrize("off", [0.5, -0.5, 1e-9])
def test_rotations_are_orthogonal_however_close_the_diagonal_is(apart, off):
    K = np.array([[1.0, off, 0.1], [off, 1.0 + apart, 0.0], [0.1, 0.0, 2.0]])
    V = np.array(jacobi(Doubles, K.tolist(), np.zeros((3, 3)).tolist()))
    # some 20 rotations, each orthogonal to a few roundings
    np.testing.assert_allclose(V.T @ V, np.eye(3), rtol=0, atol=1e-14)
    rotated = V.T @ K @ V
    np.testing.assert_allclose(rotated, np.diag(np.diag(rotated)), rtol=0, atol=1e-13)

"""The C engine equals the Python engine in every bit: samples, events, totals, errors."""

import os
from dataclasses import replace
from itertools import islice, pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, MOTORS, TABLE_1, fixed_block, paper
from tests.trajectories import Run, assert_same_bits, run
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory, state_at
from vibsim.physics.parts import EVENT_NAMES

TAYLOR_SETTINGS = ((20, 2.0**-53), (12, 1e-9), (30, 2.0**-53), (8, 1e-6), (40, 1e-20))


def outcome(scene, engine):
    """The run, or the sentence with which it failed."""
    try:
        return run(scene, engine)
    except EngineError as error:
        return str(error)


def assert_engines_agree(scene):
    fast, slow = outcome(scene, "c"), outcome(scene, "python")
    if isinstance(slow, Run) and isinstance(fast, Run):
        assert_same_bits(fast, slow)
    else:
        assert fast == slow
    return slow


@pytest.mark.parametrize("name", ("I-B", "II-C"))
@pytest.mark.parametrize(("order", "tol"), TAYLOR_SETTINGS)
def test_taylor_at_other_orders_and_tolerances(name, order, tol):
    assert_engines_agree(paper(name, method="taylor", order=order, tol=tol, t_end=3.0))


@pytest.mark.slow
@pytest.mark.parametrize("name", CASE_NAMES)
@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_long_runs_of_the_papers_cases(name, method):
    if name in MOTORS and method == "closed_form":
        pytest.skip("a motor has no closed form")
    assert_engines_agree(paper(name, method=method, t_end=100.0))


@settings(max_examples=80)
@given(scenes(sources=("none", "harmonic")))
def test_random_scenes_by_closed_form(scene):
    assert_engines_agree(scene)


@settings(max_examples=40)
@given(scenes())
def test_random_scenes_by_taylor(scene):
    assert_engines_agree(with_method(scene, "taylor"))


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=3000)
@given(scenes(sources=("none", "harmonic")))
def test_many_random_scenes_by_closed_form(scene):
    assert_engines_agree(scene)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=2000)
@given(scenes())
def test_many_random_scenes_by_taylor(scene):
    assert_engines_agree(with_method(scene, "taylor"))


def with_method(scene, method):
    return replace(scene, method=method)


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_a_run_that_ends_at_its_start(method):
    scene = fixed_block(x1=0.02, rest_distance=0.01, stop_on_violation=True, method=method)
    result = assert_engines_agree(scene)
    assert [EVENT_NAMES[code] for code in result.events["kind"]] == ["start", "end"]
    assert result.events["t"].tolist() == [0.0, 0.0] and result.events["x1"].tolist() == [0.02, 0.02]
    assert result.totals["first_violation_time"] == 0.0


def test_comparison_sees_one_bit():
    one = run(paper("I-A", t_end=1.0))
    other = run(paper("I-A", t_end=1.0), "python")
    other.samples["x1"][7] = np.nextafter(other.samples["x1"][7], 1.0)
    with pytest.raises(AssertionError, match="x1"):
        assert_same_bits(one, other)


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_a_run_that_overflows_fails_alike(method):
    scene = fixed_block(k1=1e308, m1=1e-10, x1=1e10, t_end=0.1, method=method)
    assert "no longer finite" in assert_engines_agree(scene)


def test_table_1_amplitudes():
    assert [paper(name).A for name in TABLE_1] == [0.0725, 0.1140, 0.1350]
    # m3 e omega^2: 1.596, 3.941, 5.504 N
    assert [round(paper(f"{name}-eq211").A, 3) for name in TABLE_1] == [1.596, 3.941, 5.504]


# Random scenes through every part of the C engine; `make sanitize` runs a thousand under sanitizers.


COUNT = int(os.environ.get("VIBSIM_SCENES", "25"))
BLOCKS = 10  # a scene may run for ever


@settings(max_examples=COUNT, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(scenes())
def test_a_scene_runs_with_all_that_goes_with_it(scene):
    scene = scene.as_parts()
    trajectory = open_trajectory(scene, "c", section=True, ledger=True, tangent=dimension(scene))
    t, rows = 0.0, []
    try:
        for block in islice(trajectory.blocks(), BLOCKS):
            assert t <= block.t_reached <= scene.t_end
            t = block.t_reached
            rows += [
                dict(zip(block.events, row, strict=True)) for row in zip(*block.events.values(), strict=True)
            ]
    except EngineError:
        pass
    for row, following in list(pairwise(rows))[:5]:
        states = state_at(scene, row, np.linspace(row["t"], following["t"], 3), "c")
        assert len(states["x1"]) == 3

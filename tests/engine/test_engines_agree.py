"""The C engine equals the Python engine in every bit on scenes made of parts, and both equal the engine of
two blocks on its scenes.
"""

from dataclasses import replace
from unittest.mock import patch

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.engine.random_parts import part_scenes
from tests.engine.runs import Run, differences, outcome, run, same_bits
from tests.engine.two_blocks import parts_of
from tests.scenes import CASE_NAMES, MOTORS, paper
from tests.trajectories import run as run_two_blocks
from vibsim.engine.c_engine import CRun
from vibsim.engine.tangent_space import dimension
from vibsim.physics.numbers import Doubles


def assert_engines_agree(scene, tangent=0):
    options = {"ledger": True, "momentum": True, "section": True, "tangent": tangent}
    fast, slow = outcome(scene, "c", **options), outcome(scene, "python", **options)
    if isinstance(slow, Run) and isinstance(fast, Run):
        assert differences(fast, slow) == []
    else:
        assert fast == slow
    return slow


@pytest.mark.parametrize("name", CASE_NAMES)
@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_papers_cases_equal_the_engine_of_two_blocks(name, method):
    if name in MOTORS:
        method = "taylor"
    scene = paper(name, method=method, t_end=20.0)
    old, new = run_two_blocks(scene), run(parts_of(scene, Doubles))
    assert all(same_bits(new.samples[column], old.samples[column]) for column in old.samples)
    assert all(same_bits(new.events[column], old.events[column]) for column in old.events)
    assert new.totals["impacts"] > 0
    assert new.totals["grazing_margin"] == old.totals["grazing_margin"]
    assert new.totals["uncertified"] == old.totals["uncertified"] == 0


@pytest.mark.parametrize("name", CASE_NAMES)
@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_engines_agree_on_the_papers_cases(name, method):
    method = "taylor" if name in MOTORS else method
    scene = parts_of(paper(name, method=method, t_end=4.0), Doubles)
    result = assert_engines_agree(scene, dimension(scene))
    assert result.totals["impacts"] > 2
    assert len(result.totals["growth"]) > 50 and result.totals["rank_losses"] > 0


@settings(max_examples=120)
@given(part_scenes(motor=False))
def test_random_scenes_by_the_flow_that_suits_each_mode(scene):
    assert_engines_agree(scene)


@settings(max_examples=120)
@given(part_scenes())
def test_random_scenes_by_taylor(scene):
    assert_engines_agree(replace(scene, method="taylor"))


@settings(max_examples=40)
@given(part_scenes(), st.integers(1, 10), st.sampled_from(("auto", "taylor")))
def test_random_scenes_with_disturbances(scene, count, method):
    assert_engines_agree(replace(scene, method=method), min(count, dimension(scene)))


@settings(max_examples=40)
@given(part_scenes())
def test_disturbances_that_python_takes_through_events(scene):
    """As where C knows no saltation: bit for bit what C does by itself."""
    with patch.object(CRun, "_jumps_in_c", lambda *_: False):
        assert_engines_agree(scene, dimension(scene))


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=5000)
@given(part_scenes())
def test_many_random_scenes(scene):
    assert_engines_agree(scene, dimension(scene))

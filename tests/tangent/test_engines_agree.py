"""The bundle of the C engine equals that of the Python engine in every bit, and changes no trajectory."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, MOTORS, paper
from tests.tangent.bundles import same_bits, totals
from tests.trajectories import assert_same_bits, collect, run
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent_space import dimension
from vibsim.engine.trajectory import open_trajectory


def outcome(scene, engine, count, begin):
    """Totals of the run, or the sentence with which it failed."""
    try:
        return totals(scene, engine, count, begin)
    except EngineError as error:
        return str(error)


def assert_engines_agree(scene, count=None, begin=0.0):
    fast, slow = outcome(scene, "c", count, begin), outcome(scene, "python", count, begin)
    agree = fast == slow if isinstance(slow, str) else same_bits(fast, slow)
    assert agree
    return slow


@pytest.mark.parametrize("name", [name for name in CASE_NAMES if name not in MOTORS])
def test_closed_form_of_the_papers_cases(name):
    found = assert_engines_agree(paper(name, t_end=30.0), begin=7.0)
    assert len(found["growth"]) == 101


@pytest.mark.parametrize("name", CASE_NAMES)
@pytest.mark.parametrize("count", [1, None])
def test_taylor_of_the_papers_cases(name, count):
    found = assert_engines_agree(paper(name, method="taylor", t_end=4.0), count, 1.0)
    assert 50 < len(found["growth"]) <= 101


@settings(max_examples=100)
@given(scenes(sources=("none", "harmonic")), st.integers(1, 5), st.sampled_from((0.0, 0.5)))
def test_random_scenes_by_closed_form(scene, count, share):
    assert_engines_agree(scene, min(count, dimension(scene)), share * scene.t_end)


@settings(max_examples=60)
@given(scenes(radians=15.0), st.integers(1, 5))
def test_random_scenes_by_taylor(scene, count):
    assert_engines_agree(replace(scene, method="taylor"), min(count, dimension(scene)))


@pytest.mark.slow
@pytest.mark.timeout(1800)
@settings(max_examples=2000)
@given(scenes(), st.integers(1, 5))
def test_many_random_scenes(scene, count):
    assert_engines_agree(scene, min(count, dimension(scene)))
    assert_engines_agree(replace(scene, method="taylor"), min(count, dimension(scene)))


@pytest.mark.parametrize("name", ["I-A", "II-B"])
def test_a_bundle_changes_no_trajectory(name):
    scene = paper(name, t_end=20.0)
    carried = collect(open_trajectory(scene, "c", tangent=dimension(scene)))
    plain = run(scene)
    for key in set(carried.totals) - set(plain.totals):
        del carried.totals[key]
    assert_same_bits(carried, plain)


def test_numbers_of_exponents_that_a_scene_has_not_got():
    with pytest.raises(ValueError, match="tangent must be 0 to 3 for this scene, got 4"):
        open_trajectory(paper("I-A"), tangent=4)
    with pytest.raises(ValueError, match="tangent must be 0 to 5 for this scene, got -1"):
        open_trajectory(paper("II-A"), tangent=-1)

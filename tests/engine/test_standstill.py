"""A run that steps within its rounding ends with an error: it would never come to its end."""

import random

import pytest

from tests.engine.many_digits import exact_parts, truth
from tests.engine.runs import whole
from tests.events.coincidences import machine
from vibsim.cases import load_case
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory

CRAWLING = """
bodies: {m: 1 kg}
links: {spring: {between: [m, ground], k: 1e8 N/m}}
initial: {m: {x: 1 mm}}
run: {t_end: 2e14 s, every: 1e14 s, method: taylor}
"""


@pytest.fixture
def crawling(tmp_path):
    """10,000 rad/s for 2e14 s: 1e17 steps."""
    path = tmp_path / "crawling.yaml"
    path.write_text(CRAWLING)
    return load_case(path).scene()


def standstill(scene, engine):
    with pytest.raises(EngineError, match="steps brought the run no further") as caught:
        for _ in open_trajectory(scene, engine).blocks():
            pass
    return caught.value


def test_a_run_that_gets_nowhere_ends(crawling):
    error = standstill(crawling, "c")
    assert error.reason == "standstill" and 0 < error.state.t < 2**-30 * crawling.t_end


@pytest.mark.slow
def test_both_engines_end_it_at_one_step(crawling):
    assert standstill(crawling, "c").state == standstill(crawling, "python").state


@pytest.mark.slow
def test_special_scenes_that_creep_end():
    standstill(machine(random.Random(6241)), "c")


def test_a_special_scene_that_crept_runs_as_in_many_digits():
    """On a stop without restitution: it comes to rest in doubt now, where it crept."""
    scene = machine(random.Random(4006))
    found = whole([block.events for block in open_trajectory(scene, "c").blocks()])
    _, true, _, _ = truth(exact_parts(scene), 40)
    assert list(found["kind"]) == list(true["kind"]) and list(found["part"]) == list(true["part"])
    for name in ("t", "x_a", "v_a", "x_b", "v_b"):
        assert found[name] == pytest.approx(true[name], abs=1e-14)

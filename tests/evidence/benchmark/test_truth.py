import numpy as np
import pytest

from tests.evidence.benchmark.made import plan, truth
from vibsim.engine.truth import open_truth
from vibsim.evidence.benchmark.running import RIGHT, compute_truth


@pytest.mark.parametrize("name", ["I-A", "II-B"])
def test_every_double_is_the_nearest_to_a_run_of_many_more_digits(name):
    found = truth(name, "3 s")
    blocks = list(open_truth(plan(name, "3 s").case.exact_scene, 60).blocks())
    for column, values in found.samples.items():
        np.testing.assert_array_equal(values, np.concatenate([block.samples[column] for block in blocks]))
    for column, values in found.events.items():
        np.testing.assert_array_equal(values, np.concatenate([block.events[column] for block in blocks]))
    assert found.attrs["truth_digits_right"] >= RIGHT
    assert len(found.events["t"]) > 5


def test_digits_are_added_until_enough_are_right(monkeypatch):
    monkeypatch.setattr("vibsim.evidence.benchmark.running.error_growth", lambda scene: -20.0)
    monkeypatch.setattr("vibsim.evidence.benchmark.running.FEWEST", 20)
    found = compute_truth(plan("I-A", "3 s"))
    assert found.attrs["truth_digits"] > 20 and found.attrs["truth_digits_right"] >= RIGHT


def test_it_can_be_interrupted():
    assert compute_truth(plan(), lambda t: False) is None

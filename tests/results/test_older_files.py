"""Files from before events named their part, and before a rest distance had a state, open as they did."""

import h5py
import numpy as np
import pytest

import vibsim
from tests.results.made import short_case


@pytest.fixture(params=["II-B", "I-C"])
def runs(request, tmp_path):
    """A run with violations, as it is stored and as it was before: without what was added since."""
    case = short_case(request.param, "20 s", rest_distance__value="5 mm")
    new, old = tmp_path / "new.h5", tmp_path / "old.h5"
    for path in (new, old):
        vibsim.simulate(case).save(path)
    with h5py.File(old, "r+") as file:
        for name in ("events/part", "events/rest_distance", "rest_distance"):
            del file[name]
    return vibsim.open_result(new), vibsim.open_result(old)


def test_events_get_their_parts_and_states_back(runs):
    new, old = runs
    assert set(old.events) == set(new.events)
    for name in new.events:
        np.testing.assert_array_equal(old.events[name], new.events[name], err_msg=name)
    assert new.events["rest_distance"].any() and len(set(new.events["part"].tolist())) > 3


def test_states_between_samples_are_the_same(runs):
    new, old = runs
    times = np.linspace(0.0, 20.0, 57)
    expected, found = new.at(times), old.at(times)
    assert all(np.array_equal(found[name], expected[name]) for name in expected)
    assert "rest_distance" not in old and len(old) == len(new)

"""The Python interface of a trajectory."""

import numpy as np
import pytest

import vibsim
from tests.results.made import short_case, short_run

CASES = ["I-A", "I-B", "II-B"]


def test_columns_by_name():
    result = short_run("II-B")
    names = ["time", "x1", "v1", "x2", "v2", "phi", "phidot", "contact", "friction", "error_estimate"]
    assert result.keys() == names
    assert list(result) == result.keys()
    assert len(result) == 1001 == len(result.time)
    assert np.array_equal(result.time, np.arange(1001) * 5 / 1000)
    assert result["contact"].dtype == result["friction"].dtype == np.int8
    assert list(result.events)[:2] == ["t", "kind"]
    assert result.events["kind"][[0, -1]].tolist() == [0, 8]


def test_the_case_and_the_trust_horizon():
    result = short_run("II-B")
    assert result.case.sha256 == short_case("II-B").sha256
    assert result.trust_horizon == 5
    assert vibsim.simulate(short_case("II-B"), trust=False).trust_horizon is None
    assert "II-B: 0 to 5 s, 1001 samples" in repr(result)


@pytest.mark.parametrize("name", CASES)
def test_states_at_the_samples_are_the_samples(name):
    result = short_run(name)
    found = result.at(result.time)
    for column in found:
        assert found[column].tobytes() == result[column].tobytes()


@pytest.mark.parametrize("name", CASES)
def test_states_between_the_samples_are_those_of_a_run_with_more_samples(name):
    fine = short_run(name, run__every="1 ms")
    found = short_run(name).at(fine.time)
    for column in found:
        assert found[column].tobytes() == fine[column].tobytes()


def test_times_in_any_shape_and_order():
    result = short_run("II-B")
    times = np.array([[4.0, 0.0, 2.5], [5.0, 2.5, 1e-9]])
    found = result.at(times)
    assert found["x1"].shape == (2, 3)
    for place in np.ndindex(2, 3):
        one = result.at(times[place])
        assert one["x1"].shape == ()
        assert {name: one[name].item() for name in one} == {name: found[name][place] for name in found}
    assert result.at([])["x1"].shape == (0,)


@pytest.mark.parametrize("t", [-1e-9, 5.0001, np.nan, np.inf])
def test_times_outside_the_run(t):
    with pytest.raises(ValueError, match="between 0 and 5 s"):
        short_run().at([1.0, t])


def test_a_saved_result_answers_the_same(tmp_path):
    result = short_run("II-B")
    again = vibsim.open_result(result.save(tmp_path / "a.h5"))
    assert again.case.sha256 == result.case.sha256
    assert again.at(3.21) == result.at(3.21)
    assert again.attrs == result.attrs
    assert again.keys() == result.keys()
    assert list(again.events) == list(result.events)


def test_a_case_read_back_from_a_file_runs_bit_for_bit_the_same(tmp_path):
    result = short_run("II-B", excitation__Omega0="6.5 Hz")
    case = vibsim.open_result(result.save(tmp_path / "a.h5")).case
    again = vibsim.simulate(case)
    for name in result:
        assert again[name].tobytes() == result[name].tobytes()


def test_both_engines_give_the_same_result():
    fast, plain = short_run("II-B"), vibsim.simulate(short_case("II-B"), engine="python")
    assert plain.attrs["engine"] == "python"
    for name in fast:
        assert fast[name].tobytes() == plain[name].tobytes()
    same = ("impacts", "sticks", "events", "rest_distance_needed", "grazing_margin", "grazing_time")
    assert [fast.attrs[name] for name in same] == [plain.attrs[name] for name in same]


def test_violations_are_counted_and_may_stop_the_run():
    limits = {"rest_distance__value": "1 mm"}
    warned = short_run(t_end="20 s", rest_distance__on_violation="warn", **limits)
    assert warned.attrs["violations"] > 0
    assert warned.t_reached == 20
    first = warned.attrs["first_violation_time"]
    assert first == warned.events["t"][warned.events["kind"] == 6][0]
    stopped = short_run(t_end="20 s", rest_distance__on_violation="stop", **limits)
    assert stopped.complete
    assert stopped.t_reached == first
    assert stopped.attrs["rest_distance_needed"] == pytest.approx(1e-3, rel=1e-6)
    assert warned.attrs["rest_distance_needed"] > 1e-3

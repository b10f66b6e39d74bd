"""What users get goes to other processes and back: runs, sweeps, orbits and branches."""

import pickle

import numpy as np
import pytest

import vibsim


def there_and_back(thing):
    return pickle.loads(pickle.dumps(thing))


@pytest.fixture(scope="module")
def result():
    return vibsim.simulate("II-B", overrides={"run.t_end": "2 s"})


@pytest.mark.parametrize("on_file", (False, True))
def test_a_run(result, on_file, tmp_path):
    """One that lies on file leaves it behind."""
    run = vibsim.open_result(result.save(tmp_path / "a.h5")) if on_file else result
    again = there_and_back(run)
    assert again.case == run.case and dict(again.attrs) == dict(run.attrs)
    assert all(np.array_equal(again[name], result[name]) for name in result)
    assert all(np.array_equal(again.events[name], result.events[name]) for name in result.events)
    assert again.at(1.0) == result.at(1.0)
    events = there_and_back(run.events)
    assert list(events) == list(run.events)
    assert all(np.array_equal(events[name], result.events[name]) for name in result.events)
    assert events.words("part").tolist() == result.events.words("part").tolist()


def test_the_digits_of_a_run(tmp_path):
    pytest.importorskip("flint")
    result = vibsim.simulate("I-A", digits=20, overrides={"run.t_end": "0.1 s"})
    again = there_and_back(vibsim.open_result(result.save(tmp_path / "a.h5")))
    assert again.digits["x1"].tolist() == result.digits["x1"].tolist()
    assert again.digits.events["t"].tolist() == result.digits.events["t"].tolist()


@pytest.mark.parametrize("on_file", (False, True))
def test_a_sweep(on_file, tmp_path):
    case = vibsim.load_case("II-B", {"run.t_end": "1 s"})
    out = {"out": tmp_path / "a.h5"} if on_file else {}
    sweep = vibsim.sweep(case, {"c": [0.01, 0.02]}, section=3, jobs=1, **out)
    again = there_and_back(sweep)
    for name in sweep:
        assert np.array_equal(again[name], sweep[name], equal_nan=again[name].dtype.kind == "f")
    assert again.to_xarray().identical(sweep.to_xarray())


def test_an_orbit():
    orbit = vibsim.orbit("gallery/friction-oscillator")
    again = there_and_back(orbit)
    assert again.multipliers.tolist() == orbit.multipliers.tolist()
    assert again.state == orbit.state and again.events == orbit.events
    assert all(np.array_equal(again.run[name], orbit.run[name]) for name in orbit.run)

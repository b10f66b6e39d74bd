"""A trajectory is taken over where it is of the same case, whole, and judged; else it is made again."""

import pytest

from vibsim.cases import load_case
from vibsim.evidence.reports import measurements
from vibsim.evidence.reports.measurements import MeasurementInterrupted, obtain_run, stored_run
from vibsim.results import simulate
from vibsim.results.simulation import open_result

SHORT = {"run.t_end": "2 s"}


@pytest.fixture
def case():
    return load_case("I-A", SHORT)


def test_a_run_is_simulated_once(tmp_path, case):
    first, anew = obtain_run(case, tmp_path)
    written = (tmp_path / "I-A.h5").read_bytes()
    again, once_more = obtain_run(case, tmp_path)
    assert (anew, once_more) == (True, False)
    assert (tmp_path / "I-A.h5").read_bytes() == written
    assert again["x1"].tolist() == first["x1"].tolist()


def test_a_run_of_another_case_is_replaced(tmp_path, case):
    obtain_run(load_case("I-A", {**SHORT, "coupling.c": "0.002"}), tmp_path)
    found, anew = obtain_run(case, tmp_path)
    assert anew
    assert found.case.number("coupling.c") == 0.001


def test_a_run_of_another_version_is_replaced(tmp_path, case, monkeypatch):
    obtain_run(case, tmp_path)
    monkeypatch.setattr(measurements, "__version__", "0.0")
    assert stored_run(case, tmp_path / "I-A.h5") is None


def test_a_run_without_a_trust_horizon_is_replaced(tmp_path, case):
    simulate(case, trust=False).save(tmp_path / "I-A.h5")
    found, anew = obtain_run(case, tmp_path)
    assert anew
    assert found.trust_horizon == 2.0


def test_a_damaged_file_is_replaced(tmp_path, case):
    (tmp_path / "I-A.h5").write_text("no HDF5")
    assert obtain_run(case, tmp_path)[1]


def test_fresh_simulates_again(tmp_path, case):
    obtain_run(case, tmp_path)
    assert obtain_run(case, tmp_path, fresh=True)[1]


def test_an_interrupted_run_is_not_taken_over(tmp_path, case):
    long = load_case("I-A", {"run.t_end": "100000 s"})
    with pytest.raises(MeasurementInterrupted):
        obtain_run(long, tmp_path, watch=lambda t: False)
    assert not open_result(tmp_path / "I-A.h5").complete
    assert stored_run(long, tmp_path / "I-A.h5") is None

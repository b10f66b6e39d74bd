"""CSV and MAT files hold the same bits as the trajectory."""

import csv

import numpy as np
import pytest
from scipy.io import loadmat

import vibsim
from tests.results.made import short_run
from vibsim.physics.parts import EVENT_NAMES
from vibsim.results import ResultFileError
from vibsim.results import result as result_module
from vibsim.results.labelled import Tidy
from vibsim.results.result import write_csv, write_mat

EVERYTHING = (0.0, np.inf)


@pytest.fixture(params=["memory", "file"])
def result(request, tmp_path):
    run = short_run("II-B")
    return run if request.param == "memory" else vibsim.open_result(run.save(tmp_path / "run.h5"))


def read_csv(path):
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    return header, dict(zip(header, zip(*rows, strict=True), strict=True))


def test_csv_reads_back_to_the_same_bits(result, tmp_path, monkeypatch):
    monkeypatch.setattr(result_module, "PIECE", 300)  # several pieces, the last one short
    write_csv(result, tmp_path / "a.csv", EVERYTHING)
    header, columns = read_csv(tmp_path / "a.csv")
    assert header == result.keys()
    for name in set(header) - {"contact", "friction"}:
        assert np.array(columns[name], "f8").tobytes() == result[name].astype("f8").tobytes()


@pytest.mark.parametrize("events", [False, True])
def test_csv_writes_all_codes_as_the_words_that_tables_have(result, tmp_path, events):
    write_csv(result, tmp_path / "a.csv", EVERYTHING, events=events)
    columns = read_csv(tmp_path / "a.csv")[1]
    table = Tidy((result.events if events else result).arrays())
    for name in ["contact", "friction", *(["kind", "part"] if events else [])]:
        assert list(columns[name]) == list(table.told(name))
    assert {"free", "contact"} == set(columns["contact"])


def test_csv_lines_end_as_rfc_4180_says(result, tmp_path):
    write_csv(result, tmp_path / "a.csv", EVERYTHING)
    raw = (tmp_path / "a.csv").read_bytes()
    assert raw.count(b"\r\n") == raw.count(b"\n") == 1 + len(result)
    assert raw.endswith(b"\r\n")


def test_csv_of_the_events_names_their_kinds(result, tmp_path):
    write_csv(result, tmp_path / "a.csv", EVERYTHING, events=True)
    header, columns = read_csv(tmp_path / "a.csv")
    assert header == list(result.events)
    assert list(columns["kind"]) == [EVENT_NAMES[code] for code in result.events["kind"].tolist()]
    assert np.array_equal(np.array(columns["t"], "f8"), result.events["t"])


def test_a_window_has_both_of_its_ends(result, tmp_path):
    write_csv(result, tmp_path / "a.csv", (1.0, 1.5))
    times = np.array(read_csv(tmp_path / "a.csv")[1]["time"], "f8")
    assert (times[0], times[-1], len(times)) == (1.0, 1.5, 101)


def test_mat_holds_samples_events_and_where_they_come_from(result, tmp_path):
    write_mat(result, tmp_path / "a.mat", EVERYTHING)
    found = loadmat(tmp_path / "a.mat", squeeze_me=True)
    for name in result:
        assert found[name].dtype == result[name].dtype
        assert found[name].tobytes() == result[name].tobytes()
    for name in result.events:
        assert found["events"][name].item().tobytes() == result.events[name].tobytes()
    assert found["info"]["case_sha256"].item() == result.case.sha256
    assert found["info"]["impacts"].item() == result.attrs["impacts"]


def test_mat_of_a_window(result, tmp_path):
    write_mat(result, tmp_path / "a.mat", (1.0, 1.5))
    found = loadmat(tmp_path / "a.mat", squeeze_me=True)
    assert len(found["time"]) == 101
    times = np.atleast_1d(found["events"]["t"].item())
    assert len(times) > 0 and np.all((times >= 1.0) & (times <= 1.5))


def test_mat_beyond_its_limit_is_refused(result, tmp_path, monkeypatch):
    monkeypatch.setattr(result_module, "LARGEST", 1000)
    with pytest.raises(ResultFileError, match="a MAT file takes 2 GB; export a window, or as CSV"):
        write_mat(result, tmp_path / "a.mat", EVERYTHING)
    assert not (tmp_path / "a.mat").exists()


@pytest.mark.parametrize("write", [write_csv, write_mat])
def test_an_existing_export_is_kept(result, tmp_path, write):
    (tmp_path / "a.out").write_text("precious")
    with pytest.raises(ResultFileError, match="exists; kept"):
        write(result, tmp_path / "a.out", EVERYTHING)
    assert (tmp_path / "a.out").read_text() == "precious"
    write(result, tmp_path / "a.out", EVERYTHING, force=True)
    assert (tmp_path / "a.out").stat().st_size > 1000

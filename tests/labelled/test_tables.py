"""Sweeps and events as CSV and Parquet."""

import csv
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call, told
from vibsim.results import labelled
from vibsim.results.labelled import Tidy, write_table


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """Two axes; one point fails in time for a text with a comma."""
    case = vibsim.load_case("II-B", {"run.t_end": "4 s"})
    path = tmp_path_factory.mktemp("sweep") / "sweep.h5"
    axes = {"Omega0": "5,6 Hz", "c": "0.01,0.02,0.03"}
    vibsim.sweep(case, axes, compute=["capture"], section=3, jobs=1, out=path)
    return path


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, dict(zip(header, zip(*rows, strict=True), strict=True))


def numbers(texts):
    """Cells as numbers, empty ones NaN."""
    return np.array([float(text) if text else np.nan for text in texts])


def test_a_sweep_as_csv_is_a_row_per_point(sweep, tmp_path, monkeypatch):
    monkeypatch.setattr(labelled, "PIECE", 4)  # several pieces, the last one short
    done = call("export", str(sweep), "-o", str(tmp_path / "a.csv"))
    assert (done.exit_code, done.stderr) == (0, f"{tmp_path / 'a.csv'} written\n")
    header, columns = read(tmp_path / "a.csv")
    result = vibsim.open_result(sweep)
    assert header[:3] == ["omega0", "c", "direction"]
    assert columns["omega0"] == ("5.0",) * 3 + ("6.0",) * 3
    assert columns["c"] == ("0.01", "0.02", "0.03") * 2
    assert set(columns["direction"]) == {"up"}
    assert columns["capture"] == tuple(result.verdict("capture").ravel())
    for name, column in result.plan.columns.items():
        if not column.dimension and not column.flags:
            assert numbers(columns[name]).tobytes() == result[name].tobytes(), name
    assert columns["status"] == ("done",) * 6
    assert columns["sha256"] == tuple(result["sha256"].ravel())


def test_a_sweep_along_its_section(sweep, tmp_path):
    told("export", str(sweep), "-o", str(tmp_path / "a.csv"), "--along", "section")
    header, columns = read(tmp_path / "a.csv")
    names = ["section_displacement", "section_velocity", "section_speed"]
    assert header == ["omega0", "c", "direction", "section", *names]
    result = vibsim.open_result(sweep)
    for name in names:
        assert np.array_equal(numbers(columns[name]), result[name].ravel(), equal_nan=True)


def test_texts_with_commas_and_line_ends_are_quoted(tmp_path):
    case = vibsim.load_case("II-B", {"run.t_end": "1 s"})
    result = vibsim.sweep(case, {"c": [0.01, 0.02]}, section=0, jobs=1)
    error = 'said "no", and\nleft'
    result.table.error[0, 0] = error
    write_table(Tidy(result.arrays()), tmp_path / "a.csv")
    assert read(tmp_path / "a.csv")[1]["error"] == (error, "")


def test_parquet_keeps_units_words_and_provenance(sweep, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    assert call("export", str(sweep), "-o", str(tmp_path / "a.parquet"), "-q").exit_code == 0
    table, result = parquet.read_table(tmp_path / "a.parquet"), vibsim.open_result(sweep)
    assert table.schema.field("omega0").metadata[b"units"] == b"Hz"
    assert np.array(table["mean_speed"]).tobytes() == result["mean_speed"].tobytes()
    assert table["capture"].to_pylist() == [word or None for word in result.verdict("capture").ravel()]
    assert result.attrs["case_sha256"].encode() in table.schema.metadata[b"vibsim"]


def test_a_run_as_parquet(tmp_path, monkeypatch):
    parquet = pytest.importorskip("pyarrow.parquet")
    monkeypatch.chdir(tmp_path)
    assert call("run", "II-B", "--t-end", "5s", "-q").exit_code == 0
    assert call("export", "II-B.h5", "-o", "a.parquet", "--window", "1:2", "-q").exit_code == 0
    assert call("export", "II-B.h5", "-o", "b.parquet", "--events", "--window", "2:", "-q").exit_code == 0
    result, time = vibsim.open_result("II-B.h5"), parquet.read_table("a.parquet")["time"].to_pylist()
    assert (time[0], time[-1], len(time)) == (1.0, 2.0, 201)
    kinds = parquet.read_table("b.parquet")["kind"].to_pylist()
    assert kinds == list(result.events.words("kind")[result.events["t"] >= 2])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "a.mat"], "a MAT file takes a run"),
        (["-o", "a.csv", "--window", "1:2"], "--window is for runs"),
        (["-o", "a.csv", "--events"], "--events is for runs"),
        (["-o", "a.csv", "--along", "exponent"], "no further dimension is called 'exponent'"),
    ],
)
def test_what_does_not_go_with_a_sweep(sweep, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = call("export", str(sweep), *words)
    assert done.exit_code == 2 and message in done.stderr
    assert not list(Path().iterdir())


def test_parquet_without_pyarrow_names_the_extra(sweep, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    done = call("export", str(sweep), "-o", str(tmp_path / "a.parquet"))
    assert done.exit_code == 2 and "pip install 'vibsim[parquet]'" in done.stderr


def test_a_pyarrow_that_cannot_be_imported_is_told_in_one_line(sweep, tmp_path, monkeypatch):
    """As with an older numpy, of which it says so only then."""
    (tmp_path / "pyarrow.py").write_text('raise ImportError("pyarrow requires NumPy 2.0\\nor newer")')
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "pyarrow", raising=False)
    done = call("export", str(sweep), "-o", str(tmp_path / "a.parquet"))
    assert done.exit_code == 2
    assert "pyarrow, which cannot be imported: pyarrow requires NumPy 2.0 or newer\n" in done.stderr


# What users get goes to other processes and back: runs, sweeps, orbits and branches.


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

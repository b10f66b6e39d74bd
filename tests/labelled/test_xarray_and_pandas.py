"""Results as xarray Datasets, pandas DataFrames and notebook tables."""

import csv
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest

import vibsim
from tests.command_line.made import call, told
from tests.results.made import short_run
from vibsim.physics.parts import EVENT_NAMES
from vibsim.results import labelled
from vibsim.results.labelled import MissingExtra, Tidy, write_table


@pytest.fixture(scope="module")
def sweep():
    """Two axes, an ensemble, a further dimension, verdicts."""
    case = vibsim.load_case("II-B", {"run.t_end": "4 s"})
    axes = {"Omega0": "5,6 Hz", "c": "0.01,0.02,0.03"}
    return vibsim.sweep(case, axes, compute=["capture"], section=3, ensemble=2, jobs=1)


def opened(path, group=None):
    """The Dataset that xarray reads from a file."""
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(path, engine="h5netcdf", group=group) as data:
        return data.load()


@pytest.mark.parametrize("name", ["II-B", "I-A", "gallery/drifting-capsule", "gallery/impact-pair"])
def test_the_dataset_of_a_run_is_the_one_that_xarray_reads_from_its_file(name, tmp_path):
    run = short_run(name)
    path = run.save(tmp_path / "run.h5")
    for result in (run, vibsim.open_result(path)):
        opened(path).identical(result.to_xarray()) or pytest.fail("samples")
        events = result.events.to_xarray()
        assert opened(path, "events").drop_attrs(deep=False).identical(events)
        assert events["kind"].attrs["flag_meanings"].split()[0] == "start"


def test_the_dataset_of_a_sweep_is_the_one_that_xarray_reads_from_its_file(sweep, tmp_path):
    path = sweep.save(tmp_path / "sweep.h5")
    assert opened(path).identical(sweep.to_xarray())
    assert opened(path).identical(vibsim.open_result(path).to_xarray())


def test_a_frame_of_a_run_is_indexed_by_time():
    run = short_run("II-B")
    frame = run.to_dataframe()
    assert frame.index.name == "time" and frame.index.to_numpy().tobytes() == run.time.tobytes()
    assert frame["x1"].to_numpy().tobytes() == run["x1"].tobytes()
    assert frame.attrs["units"]["v1"] == "m s-1"
    assert set(frame["contact"]) <= {"free", "contact"}


def test_a_frame_of_events_names_kinds_and_parts():
    events = short_run("II-B").events
    frame = events.to_dataframe()
    assert list(frame.columns) == list(events)
    assert list(frame["kind"]) == [EVENT_NAMES[code] for code in events["kind"].tolist()]
    assert frame["part"].iloc[0] == "none"
    assert set(frame["part"][frame["kind"] == "contact_begin"]) == {"stop"}
    assert list(events.words("kind")) == list(frame["kind"])
    with pytest.raises(KeyError, match="x1 is no column of codes; such are kind, part, contact, friction"):
        events.words("x1")


def test_a_frame_of_a_sweep_has_a_row_per_point(sweep):
    frame = sweep.to_dataframe()
    assert list(frame.index.names) == ["omega0", "c", "member", "direction"]
    assert len(frame) == sweep["status"].size == 12
    for index in np.ndindex(sweep["status"].shape):
        omega0, c, member = (axis.numbers()[i] for axis, i in zip(sweep.axes, index, strict=False))
        row = frame.loc[(omega0, c, member, "up")]
        assert row["mean_speed"] == sweep["mean_speed"][index]
        assert row["capture"] == sweep.verdict("capture")[index]
        assert row["member_phi"] == sweep["member_phi"][member]
        assert row["sha256"] == sweep["sha256"][index]


def test_a_frame_along_a_further_dimension_has_a_row_per_position(sweep):
    frame = sweep.to_dataframe("section")
    assert list(frame.columns) == ["section_displacement", "section_velocity", "section_speed"]
    assert frame["section_speed"].to_numpy().tobytes() == sweep["section_speed"].tobytes()
    assert frame.index.get_level_values("section")[:3].tolist() == [-2, -1, 0]
    with pytest.raises(ValueError, match="no further dimension is called 'exponent'; there are: section"):
        sweep.to_dataframe("exponent")


@pytest.mark.parametrize(
    ("package", "call", "extra"), [("xarray", "to_xarray", "xarray"), ("pandas", "to_dataframe", "pandas")]
)
def test_a_missing_package_is_named_with_its_extra(package, call, extra, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    message = rf"needs {package}, which is not installed: pip install 'vibsim\[{extra}\]'"
    with pytest.raises(MissingExtra, match=message):
        getattr(short_run(), call)()


def test_a_notebook_shows_lines_columns_and_events(sweep):
    for result in (short_run("II-B"), sweep):
        html = result._repr_html_()
        assert "II-B" in html and "<details>" in html
        assert all(f">{name}<" in html for name in result)
    events = short_run("II-B").events._repr_html_()
    assert events.count("<tr>") == 11 and ">stick_end<" in events and "t [s]" in events


def test_what_a_user_writes_is_no_markup(tmp_path):
    case = vibsim.load_case("I-A", {"run.t_end": "1 s", "title": "<script>alert(1)</script>"})
    html = vibsim.simulate(case)._repr_html_()
    assert "<script>" not in html and "&lt;script&gt;" in html


def test_reprs_are_a_few_lines(sweep):
    run, events = repr(short_run("II-B")), repr(short_run("II-B").events)
    assert run.startswith("<Result II-B: 0 to 5 s, 1001 samples, ")
    assert "right           to 1e-6 m over the whole run" in run
    assert events.startswith("<Events of II-B: ") and "1 start" in events
    assert repr(sweep).startswith("<SweepResult II-B: 2 omega0 5 to 6 Hz x 3 c 0.01 to 0.03 N s/m x 2 m")
    assert all(len(text.splitlines()) <= 10 for text in (run, events, repr(sweep)))


@pytest.mark.parametrize(
    ("judge", "lines"),
    [
        (lambda: vibsim.analyse(short_run("II-B")), ["capture", "drift", "impacts", "regime", "frequencies"]),
        (lambda: vibsim.analyse("gallery/impact-pair", what="impacts"), ["impacts", "impacts"]),
        (lambda: vibsim.lyapunov("gallery/impact-pair", count=1, overrides={"t_end": "2 s"}), ["exponents"]),
        (
            lambda: vibsim.monodromy("I-A", state={}, T=0.5, parameters=["c"]),
            ["components", "multipliers", "events"],
        ),
    ],
)
def test_what_is_judged_shows_itself_in_a_few_lines(judge, lines):
    """Not as all the numbers that it holds: a verdict has some hundred, exponents come with their history."""
    thing = judge()
    heading, *shown = repr(thing).splitlines()
    assert heading.startswith(f"<{type(thing).__name__} ") and heading.endswith(">")
    assert [line.split()[0] for line in shown if not line.startswith("  warning")] == lines
    assert all(len(line) < 250 for line in shown)
    assert thing._repr_html_().count("<tr>") == len(shown)


# Sweeps and events as CSV and Parquet.


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
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


def test_a_sweep_as_csv_is_a_row_per_point(swept, tmp_path, monkeypatch):
    monkeypatch.setattr(labelled, "PIECE", 4)  # several pieces, the last one short
    done = call("export", str(swept), "-o", str(tmp_path / "a.csv"))
    assert (done.exit_code, done.stderr) == (0, f"{tmp_path / 'a.csv'} written\n")
    header, columns = read(tmp_path / "a.csv")
    result = vibsim.open_result(swept)
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


def test_a_sweep_along_its_section(swept, tmp_path):
    told("export", str(swept), "-o", str(tmp_path / "a.csv"), "--along", "section")
    header, columns = read(tmp_path / "a.csv")
    names = ["section_displacement", "section_velocity", "section_speed"]
    assert header == ["omega0", "c", "direction", "section", *names]
    result = vibsim.open_result(swept)
    for name in names:
        assert np.array_equal(numbers(columns[name]), result[name].ravel(), equal_nan=True)


def test_texts_with_commas_and_line_ends_are_quoted(tmp_path):
    case = vibsim.load_case("II-B", {"run.t_end": "1 s"})
    result = vibsim.sweep(case, {"c": [0.01, 0.02]}, section=0, jobs=1)
    error = 'said "no", and\nleft'
    result.table.error[0, 0] = error
    write_table(Tidy(result.arrays()), tmp_path / "a.csv")
    assert read(tmp_path / "a.csv")[1]["error"] == (error, "")


def test_parquet_keeps_units_words_and_provenance(swept, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    assert call("export", str(swept), "-o", str(tmp_path / "a.parquet"), "-q").exit_code == 0
    table, result = parquet.read_table(tmp_path / "a.parquet"), vibsim.open_result(swept)
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
def test_what_does_not_go_with_a_sweep(swept, words, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = call("export", str(swept), *words)
    assert done.exit_code == 2 and message in done.stderr
    assert not list(Path().iterdir())


def test_parquet_without_pyarrow_names_the_extra(swept, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    done = call("export", str(swept), "-o", str(tmp_path / "a.parquet"))
    assert done.exit_code == 2 and "pip install 'vibsim[parquet]'" in done.stderr


def test_a_pyarrow_that_cannot_be_imported_is_told_in_one_line(swept, tmp_path, monkeypatch):
    """As with an older numpy, of which it says so only then."""
    (tmp_path / "pyarrow.py").write_text('raise ImportError("pyarrow requires NumPy 2.0\\nor newer")')
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "pyarrow", raising=False)
    done = call("export", str(swept), "-o", str(tmp_path / "a.parquet"))
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
    swept = vibsim.sweep(case, {"c": [0.01, 0.02]}, section=3, jobs=1, **out)
    again = there_and_back(swept)
    for name in swept:
        assert np.array_equal(again[name], swept[name], equal_nan=again[name].dtype.kind == "f")
    assert again.to_xarray().identical(swept.to_xarray())


def test_an_orbit():
    orbit = vibsim.orbit("gallery/friction-oscillator")
    again = there_and_back(orbit)
    assert again.multipliers.tolist() == orbit.multipliers.tolist()
    assert again.state == orbit.state and again.events == orbit.events
    assert all(np.array_equal(again.run[name], orbit.run[name]) for name in orbit.run)

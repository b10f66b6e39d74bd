"""Results as xarray Datasets, pandas DataFrames and notebook tables."""

import sys

import numpy as np
import pytest

import vibsim
from tests.results.made import short_run
from vibsim.physics.parts import EVENT_NAMES
from vibsim.results.labelled import MissingExtra


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

"""A branch as a table, a Dataset and a page, whose points can be run."""

import shlex

import numpy as np
import pytest

import vibsim
from tests.branches.made import KEYS, RESONANT, orbit_of
from tests.command_line.made import call
from tests.plots.test_pages import data_of
from vibsim.orbits.branches.continuing import continue_branch


@pytest.fixture(scope="module")
def branch(tmp_path_factory):
    path = tmp_path_factory.mktemp("branch") / "branch.h5"
    return continue_branch(orbit_of(RESONANT), KEYS["I"], "6.4:6.6 Hz", out=path), path


def test_the_dataset_is_the_one_that_xarray_reads_from_the_file(branch):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(branch[1], engine="h5netcdf") as data:
        data.load()
    found = branch[0].to_xarray()
    assert set(found.variables) == {
        *data.variables,
        "index",
        "stable",
    }  # stability is told of its multipliers
    for name in data.variables:
        assert data[name].variable.identical(found[name].variable), name


def test_frames_of_points_and_of_special_points(branch):
    found, _ = branch
    frame = found.to_dataframe()
    assert len(frame) == len(found) and np.array_equal(frame["period"], found["period"])
    assert frame.attrs["units"]["parameter"] == found.unit
    outside = (abs(found["multipliers"]) > 1).sum(axis=1)
    assert list(frame["index"]) == outside.tolist()
    assert list(frame["stable"]) == ["unstable" if number else "stable" for number in outside]
    multipliers = found.to_dataframe("multiplier")
    assert np.array_equal(multipliers["multiplier_re"], found["multipliers"].real.ravel())


def test_special_points_as_a_table_and_one_by_one():
    found = continue_branch("I-A", KEYS["I"], "3.4:3.6 Hz", max_points=12)
    special = found.to_dataframe("special")
    assert list(special["special_label"]) == [one.label for one in found.specials] != []
    for one in found.specials:
        assert repr(one).startswith(f"<SpecialPoint {one.label}: {one.kind} at ") and len(repr(one)) < 120


def test_it_shows_itself(branch):
    text = repr(branch[0])
    assert text.startswith("<Branch I-C: orbits of 1 period over excitation.omega") and "special" in text
    assert "multiplier_re" in branch[0]._repr_html_()


@pytest.mark.parametrize("span", [((6.4, 6.6), "Hz"), ((np.float64(6.4), 6.6), "Hz")])
def test_a_range_may_be_a_pair(branch, span):
    again = continue_branch(orbit_of(RESONANT), KEYS["I"], span, max_points=8)
    text = continue_branch(orbit_of(RESONANT), KEYS["I"], "6.4:6.6 Hz", max_points=8)
    assert np.array_equal(again["parameter"], text["parameter"])


@pytest.mark.parametrize(
    ("key", "span", "message"),
    [
        ("frequency", "3:4 Hz", "frequency: unknown key"),
        ("", "", "name what is to vary"),
        (KEYS["I"], 3, "a range is a text"),
        (KEYS["I"], (3, "x", 4), "a range is a text"),
    ],
)
def test_what_is_no_range_of_a_key(key, span, message):
    with pytest.raises((vibsim.OrbitError, KeyError, ValueError), match=message):
        continue_branch(orbit_of(RESONANT), key, span)


def test_exports_and_pages(branch, tmp_path, monkeypatch):
    found, path = branch
    monkeypatch.chdir(path.parent)
    assert call("export", "branch.h5", "-o", str(tmp_path / "a.csv"), "-q").exit_code == 0
    assert len((tmp_path / "a.csv").read_text().splitlines()) == len(found) + 1
    words = ["-o", str(tmp_path / "s.csv"), "--along", "special"]
    assert call("export", "branch.h5", *words).exit_code == 0
    assert len((tmp_path / "s.csv").read_text().splitlines()) == len(found.specials) + 1
    assert call("plot", "branch.h5", "-o", str(tmp_path / "a.html"), "-q").exit_code == 0
    data = data_of(tmp_path / "a.html")
    assert (data["x"], data["y"]) == ("parameter", ["period", "multiplier_re"])
    middle = len(found) // 2
    words = shlex.split(data["commands"][middle])
    assert call(*words[1:], "-q").exit_code == 0  # one period on the orbit: it ends where it began
    run = vibsim.open_result("point.h5")
    end = run.at(run.t_reached)
    start = run.at(0.0)
    travel = np.ptp(run["x1"])
    assert abs(end["v1"] - start["v1"]) < 1e-9 * np.ptp(run["v1"])
    assert abs((end["x1"] - end["x2"]) - (start["x1"] - start["x2"])) < 1e-9 * travel
    assert run.t_reached == pytest.approx(found["period"][middle], rel=1e-15)

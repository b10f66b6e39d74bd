"""Branches on file and as tables: read back to the bit, gone on with after whatever ended them."""

import json
import shlex
import shutil
from functools import cache

import h5py
import numpy as np
import pytest

import vibsim
from tests.branches.made import CAPTURED, KEYS, RESONANT, orbit_of
from tests.command_line.made import told
from tests.plots.html_data import data_of
from vibsim.cases import UnknownKeyError
from vibsim.orbits import find_orbit
from vibsim.orbits.branches.branch import BranchStore, read_branch
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.orbits.branches.tracing import BranchStep
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.simulation import open_result
from vibsim.results.store import from_plain, journal_path, plain_data

SPAN = "5.7:5.9 Hz"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A branch in one go, and its file."""
    path = tmp_path_factory.mktemp("branch") / "whole.h5"
    return continue_branch(captured_at_575(), KEYS["II"], SPAN, out=path), path


@cache
def captured_at_575():
    """The captured orbit at 5.75 Hz."""
    near = continue_branch(orbit_of(CAPTURED), KEYS["II"], "4.99:5.75 Hz")
    case = near.plan.family().at(5.75)
    state = dict(zip(("x1", "v1", "v2", "phidot"), near.points[-1].orbit.state, strict=True))
    return find_orbit(case.scene(), {**state, "x2": 0.0}, 1, case=case)


def same(one, other):
    assert one.points == other.points and one.specials == other.specials
    assert one.plan.settings == other.plan.settings and one.case.sha256 == other.case.sha256


def test_a_branch_is_saved_as_it_would_have_been_written(whole, tmp_path):
    """And is gone on with where it was not followed to its ends."""
    branch, _ = whole
    saved = branch.save(tmp_path / "saved.h5")
    same(read_branch(saved), branch)
    with pytest.raises(ResultFileError, match="exists"):
        branch.save(saved)
    part = continue_branch(captured_at_575(), KEYS["II"], SPAN, max_points=6)
    part.save(saved, force=True)
    same(continue_branch(captured_at_575(), KEYS["II"], SPAN, out=saved), branch)


def test_it_reads_back_to_the_bit(whole):
    branch, path = whole
    same(read_branch(path), branch)
    same(open_result(path), branch)
    assert not journal_path(path).exists()
    for name in [*branch.keys()]:
        np.testing.assert_array_equal(open_result(path)[name], branch[name])


def test_records_as_plain_data(whole):
    for record in (*whole[0].records[0], *whole[0].records[1]):
        assert from_plain(type(record), json.loads(json.dumps(plain_data(record)))) == record


@pytest.mark.parametrize("stop", [1, 3, 7])
def test_it_goes_on_where_it_was_stopped(whole, tmp_path, stop):
    """A watch that says stop; the same bits as in one go."""
    branch, path = whole[0], tmp_path / "part.h5"
    plan = branch.plan
    part, finished = complete(BranchStore(plan, path), 5000, watch=lambda count, _: count < stop)
    assert not finished and len(part) == max(stop, 2) and open_result(path).attrs["complete"] == 0
    rest, finished = complete(BranchStore(plan, path), 5000)
    assert finished
    same(rest, branch)
    assert open_result(path).attrs["complete"] == 1


def test_it_goes_on_after_a_kill(whole, tmp_path):
    """What a killed process leaves: a journal, with a last line that is not whole."""
    branch, path = whole[0], tmp_path / "killed.h5"
    store = BranchStore(branch.plan, path)
    points, specials = branch.records
    for point in points[:5]:
        met = tuple(one for one in specials if (one.way, one.number) == (point.way, point.number))
        store.add([BranchStep(point, met)])
    store._journal.close(remove=False)  # as the system does
    with open(journal_path(path), "ab") as file:
        file.write(b"0123456789abcdef 6 {")
    rest, _ = complete(BranchStore(branch.plan, path), 5000)
    same(rest, branch)
    assert not journal_path(path).exists()


def test_a_branch_under_way_is_written_anew_and_its_journal_begins_anew(whole, tmp_path, monkeypatch):
    """As often as it may be: the file then has all points at every moment, and the journal none."""
    branch, path = whole[0], tmp_path / "under-way.h5"
    monkeypatch.setattr("vibsim.results.store.LEAST_PAUSE", 0.0)
    monkeypatch.setattr("vibsim.results.store.LARGEST_SHARE", 1e9)
    counts = []

    def watch(count, _):
        lines = journal_path(path).read_bytes().count(b"\n")
        with h5py.File(path) as file:
            counts.append((count, int(file.attrs["points"]), lines, int(file.attrs["complete"])))
        return count < 6

    complete(BranchStore(branch.plan, path), 5000, watch=watch)
    assert [each[0] for each in counts] == list(range(2, 7))
    assert all(points == count and lines == 1 and not done for count, points, lines, done in counts)
    same(complete(BranchStore(branch.plan, path), 5000)[0], branch)


def test_more_points_are_added_to_a_file(whole, tmp_path):
    branch, path = whole[0], tmp_path / "few.h5"
    few, finished = complete(BranchStore(branch.plan, path), 6)
    assert finished and len(few) == 6 and "" in few.ends
    same(complete(BranchStore(branch.plan, path), 5000)[0], branch)


def test_a_finished_file_is_not_written_again(whole, tmp_path):
    path = tmp_path / "whole.h5"
    shutil.copy(whole[1], path)
    before = path.stat().st_mtime_ns, path.read_bytes()
    same(complete(BranchStore(whole[0].plan, path), 5000)[0], whole[0])
    assert (path.stat().st_mtime_ns, path.read_bytes()) == before and not journal_path(path).exists()


def test_nor_is_that_of_a_locus(whole, tmp_path):
    path = tmp_path / "locus.h5"
    plan = locus_plan(whole[0], "F1", *read_span(whole[0].case, "c", "0.029:0.031"))
    first = complete(LocusStore(plan, path), most=3)
    before = path.stat().st_mtime_ns, path.read_bytes()
    again = complete(LocusStore(plan, path), most=3)
    assert again[0].points == first[0].points and again[1] == first[1]
    assert (path.stat().st_mtime_ns, path.read_bytes()) == before and not journal_path(path).exists()


def test_another_branch_is_kept(whole, tmp_path):
    path = shutil.copy(whole[1], tmp_path)
    other = plan_from(captured_at_575(), whole[0].plan.keys, "Hz", (5.6, 5.9))
    with pytest.raises(ResultFileError, match=r"holds another branch; kept .* It differs in span"):
        BranchStore(other, path)
    same(read_branch(path), whole[0])


@pytest.mark.parametrize(
    ("key", "span", "error", "message"),
    [
        ("Omega0", "6:7 Hz", ValueError, "outside the range 6:7; begin from an orbit within it"),
        ("Omega0", "5.5", ValueError, "5.5 is not FROM:TO with an optional unit, such as 3:9 Hz"),
        ("Omega0", "5:6:0.1", ValueError, "is not FROM:TO"),
        ("Omega0", "5:6 kg", ValueError, "excitation.Omega0 is no mass"),
        ("c", "-1:1", ValueError, "coupling.c must be >= 0, got -1 N s/m"),
        ("nothing", "1:2", UnknownKeyError, "unknown key"),
        ("run.tol", "1e-18:1e-10", ValueError, "no orbit depends on run.tol; follow a number of the bodies"),
        ("x1", "-1:1 m", ValueError, "no orbit depends on initial.x1"),
    ],
)
def test_what_cannot_be_followed(whole, key, span, error, message):
    with pytest.raises(error, match=message):
        continue_branch(orbit_of(CAPTURED), key, span)


# A branch as a table, a Dataset and a page, whose points can be run.


@pytest.fixture(scope="module")
def branch(tmp_path_factory):
    path = tmp_path_factory.mktemp("branch") / "branch.h5"
    return continue_branch(orbit_of(RESONANT), KEYS["I"], "6.4:6.6 Hz", out=path), path


def test_the_dataset_is_the_one_that_xarray_reads_from_the_file(branch):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(branch[1], engine="h5netcdf") as data:
        data.load()
    found = branch[0].to_xarray()
    assert set(found.variables) == {*data.variables, "index", "stable"}  # these are told of its multipliers
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


def test_exports_and_pages(branch, tmp_path, monkeypatch):
    found, path = branch
    monkeypatch.chdir(path.parent)
    for rows, along in ((found, []), (found.specials, ["--along", "special"])):
        told("export", "branch.h5", "-o", tmp_path / "a.csv", "--force", *along)
        assert len((tmp_path / "a.csv").read_text().splitlines()) == len(rows) + 1
    told("plot", "branch.h5", "-o", tmp_path / "a.html")
    data = data_of(tmp_path / "a.html")
    assert (data["x"], data["y"]) == ("parameter", ["period", "multiplier_re"])
    middle = len(found) // 2
    told(*shlex.split(data["commands"][middle])[1:])  # one period on the orbit: it ends where it began
    run = vibsim.open_result("point.h5")
    end, start = run.at(run.t_reached), run.at(0.0)
    travel = np.ptp(run["x1"])
    assert abs(end["v1"] - start["v1"]) < 1e-9 * np.ptp(run["v1"])
    assert abs((end["x1"] - end["x2"]) - (start["x1"] - start["x2"])) < 1e-9 * travel
    assert run.t_reached == pytest.approx(found["period"][middle], rel=1e-15)

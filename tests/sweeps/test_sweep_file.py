"""What a sweep file looks like to other programs, and the order that it keeps."""

from itertools import pairwise

import h5py
import numpy as np
import pytest

from tests.command_line.made import call, refused
from tests.sweeps.made import (
    OMEGA0,
    SECTIONS,
    assert_same_points,
    short_case,
    short_plan,
    sweep_of_motors,
    swept,
)
from vibsim.plots.subject import open_subjects
from vibsim.plots.sweep_axes import plane_of
from vibsim.plots.sweep_curves import curves
from vibsim.results import ResultFileError
from vibsim.results.simulation import open_result
from vibsim.sweeps import describe, join, sweep, sweep_plan
from vibsim.sweeps.axes import read_members
from vibsim.sweeps.quantities import DEFINITIONS, always, quantities_of, section
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import DOWN, UP, PlanError, read_shard, shard
from vibsim.sweeps.sweeping import make_plan


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return sweep_of_motors(tmp_path_factory.mktemp("sweep") / "sweep.h5")


@pytest.fixture(scope="module")
def file(made):
    with h5py.File(made[0]) as file:
        yield file


def test_the_scales(file):
    assert file["omega0"][:].tolist() == [3.0, 3.5, 4.0] and file["omega0"].attrs["units"] == "Hz"
    assert file["G"][:].tolist() == [1.0, 2.0] and file["G"].attrs["units"] == "mm"
    assert file["omega0"].attrs["key"] == OMEGA0
    assert file["direction"][:].tolist() == [1, -1]
    assert file["direction"].attrs["flag_meanings"].split() == ["up", "down"]
    assert file["section"][:].tolist() == list(range(1 - SECTIONS, 1))


def test_every_dataset_lies_on_the_scales(file):
    scales = ["omega0", "G", "direction", "section"]
    of_sections = section(quantities_of(short_case()))
    for name, dataset in file.items():
        if name not in scales:
            expected = scales if name in of_sections else scales[:3]
            assert [dataset.dims[i].keys() for i in range(dataset.ndim)] == [[scale] for scale in expected]
            assert dataset.attrs["long_name"]


def test_units_and_filters(file):
    for name, column in always(quantities_of(short_case())).items():
        assert file[name].attrs["units"] == column.units
        assert (file[name].compression, file[name].fletcher32) == ("gzip", True)
    assert file["status"].attrs["flag_meanings"].split() == ["missing", "done", "failed"]
    assert file["status"].attrs["flag_values"].dtype == "i1"


def test_root_attributes(file):
    attrs = dict(file.attrs)
    assert (attrs["vibsim_kind"], attrs["vibsim_format"], attrs["complete"]) == ("sweep", 1, 1)
    assert (attrs["points"], attrs["points_done"], attrs["points_failed"]) == (12, 12, 0)
    assert attrs["definitions"] == DEFINITIONS and attrs["case_sha256"] == short_case().sha256
    assert (attrs["method"], attrs["taylor_order"]) == ("taylor", 20)
    assert {"case_yaml", "case_resolved_json", "sweep_sha256", "platform", "date_created"} <= set(attrs)


def test_reading_back_gives_the_same(made):
    path, result = made
    read = open_result(path)
    assert_same_points(read.table, result.table)
    assert read.plan.fingerprint == result.plan.fingerprint and read.plan.settings == result.plan.settings
    assert read.attrs == result.attrs
    assert read.case_at((1, 1, 1)).sha256 == result["sha256"][1, 1, 1]


def test_sections_are_filled_from_the_front(made):
    """2 s at 3 Hz from rest hold fewer than 7 turns: NaN first, then the turns."""
    _, result = made
    section = result["section_speed"][0, 0, 0]
    count = int(result["periods"][0, 0, 0]) + 1
    assert 2 <= count < SECTIONS
    assert np.isnan(section[: SECTIONS - count]).all() and np.isfinite(section[SECTIONS - count :]).all()


def test_a_sweep_without_motor_or_block_2_has_no_such_columns(tmp_path):
    text = "blocks: {m1: 1 kg, m2: fixed}\ncoupling: {k1: 9 N/m, c: 1}\nrun: {t_end: 9 s}\n"
    (tmp_path / "bare.yaml").write_text(text + "excitation: {kind: harmonic, A: 1 N, omega: 1 Hz}\n")
    result = sweep(tmp_path / "bare.yaml", {"omega": "1, 2 Hz"}, out=tmp_path / "bare.h5", section=0)
    with h5py.File(tmp_path / "bare.h5") as file:
        absent = {
            "mean_speed", "amplitude_x2", "drift_rate", "impacts", "sticks_per_period", "end_phi",
            "section",
        }  # fmt: skip
        assert not absent & set(file)
        assert file["amplitude_x1"][:].tolist() == result["amplitude_x1"].tolist()


def test_describe(made):
    lines, facts = describe(made[0])
    labelled = dict(lines)
    assert labelled["omega0"] == "3 to 4 Hz in steps of 0.5, 3 values"
    assert labelled["G"] == "1, 2 mm, 2 values" and labelled["points"] == "12 of 12 done"
    assert "up and back down" in labelled["start"]
    assert facts["points"] == 12 and facts["sweep"]["carry_state"] is True and facts["failed"] == []


# Order is meaning: a falling range runs down, a list as it is written, on axes, in files and in pictures.


CARRIED = {"carry_state": True}


def test_a_falling_range_runs_down():
    """As the rising one does with --direction down, from the other end."""
    falling, rising = short_plan({OMEGA0: "5:3:1 Hz"}, **CARRIED), short_plan({OMEGA0: "3:5:1 Hz"}, **CARRIED)
    down = short_plan({OMEGA0: "3:5:1 Hz"}, direction="down", **CARRIED)
    assert (falling.directions, rising.directions) == ((DOWN,), (UP,))
    result = swept(falling)
    assert result["omega0"].tolist() == [5.0, 4.0, 3.0]
    assert result.case_at((0, 0)).number("initial.x1") == 0.0
    assert result["end_x1"].tolist() == swept(down)["end_x1"][::-1].tolist()
    assert result["end_x1"].tolist() != swept(rising)["end_x1"][::-1].tolist()


def test_a_list_runs_as_it_is_written_and_back():
    plan = short_plan({OMEGA0: "4, 3, 5 Hz"}, direction="both", **CARRIED)
    result = swept(plan)
    assert result["omega0"].tolist() == [4.0, 3.0, 5.0]
    order = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]
    for before, after in pairwise(order):
        assert result.case_at(after).number("initial.x1") == result["end_x1"][before]
    for word in ("up", "down"):
        message = "a direction needs values that rise or fall: sort those of omega0"
        with pytest.raises(PlanError, match=message):
            short_plan({OMEGA0: "4, 3, 5 Hz"}, direction=word, **CARRIED)


@pytest.mark.parametrize(
    ("text", "word", "directions"),
    [("3:5:1 Hz", None, (UP,)), ("3:5:1 Hz", "down", (DOWN,)), ("3:5:1 Hz", "both", (UP, DOWN)),
     ("5:3:1 Hz", "up", (UP,)), ("5:3:1 Hz", "both", (DOWN, UP)), ("4 Hz", None, (UP,)),
     ("4, 3, 5 Hz", None, (UP,))],
)  # fmt: skip
def test_the_directions(text, word, directions):
    plan = short_plan({OMEGA0: text}, direction=word, **CARRIED)
    assert plan.directions == directions
    assert tuple({"up": UP, "down": DOWN}[word] for word in plan.settings["direction"]) == directions


def test_points_that_start_fresh_have_no_direction():
    assert short_plan({OMEGA0: "5:3:1 Hz"}).directions == (UP,)


def test_a_file_keeps_the_order_and_is_completed_in_it(tmp_path):
    plan = short_plan({OMEGA0: "5:3:1 Hz"}, direction="both", **CARRIED)
    whole = swept(plan, tmp_path / "a.h5")
    read = open_result(tmp_path / "a.h5")
    assert read.plan.fingerprint == plan.fingerprint
    assert read.directions == (DOWN, UP)
    assert read["omega0"].tolist() == [5.0, 4.0, 3.0]
    assert_same_points(read.table, whole.table)


@pytest.mark.parametrize("text", ["0.05:0.01/5", "0.01:0.05/5"])
def test_parts_of_a_range_join_in_its_order_whatever_theirs(tmp_path, text):
    plan = short_plan({"c": text})
    for number in (1, 2):
        swept(shard(plan, number, 2), tmp_path / f"{number}.h5")
    for order in ((1, 2), (2, 1)):
        joined = join([tmp_path / f"{number}.h5" for number in order])
        assert joined.plan.fingerprint == plan.fingerprint
        assert joined["c"].tolist() == [float(value) for value in plan.axes[0].values]


def test_pictures_run_from_left_to_right(tmp_path):
    axes = [{OMEGA0: "5, 3, 4 Hz", "c": "0.03:0.01/3"}, {OMEGA0: "3, 4, 5 Hz", "c": "0.01:0.03/3"}]
    for name, ranges in zip("ab", axes, strict=True):
        swept(short_plan(ranges), tmp_path / f"{name}.h5")
    (a,), (b,) = (open_subjects([str(tmp_path / f"{name}.h5")]) for name in "ab")
    drawn = {curve.label: (curve.x, curve.values("mean_speed")) for curve in curves([a])}
    assert len(drawn) == 3
    for curve in curves([b]):
        x, values = drawn[curve.label]
        np.testing.assert_array_equal(x, curve.x)
        np.testing.assert_array_equal(values, curve.values("mean_speed"))
    planes = plane_of(a), plane_of(b)
    for mine, others in zip(planes[0].spans(), planes[1].spans(), strict=True):
        np.testing.assert_array_equal(mine, others)
    cells = [plane.grid(s.result["mean_speed"]) for plane, s in zip(planes, (a, b), strict=True)]
    np.testing.assert_array_equal(*cells)


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["sweep", "--omega0", "3:4:1", "--omega0", "5:6:1"], "--omega0 is given twice"),
        (["sweep", "--omega0", "3:4:1", "--carry-state", "--fresh"], "--carry-state is given twice"),
        (["sweep", "--ensemble", "2", "--spread", "x1=1mm", "--spread", "x1=2mm"], "x1 is given twice"),
        (["run", "II-B", "--t-end", "1s", "--t-end", "2s"], "--t-end is given twice"),
        (["run", "II-B", "-s", "mu=1", "-s", "mu=2"], "mu is given twice"),
        (["run", "II-B", "-s", "mu=1", "-s", "friction.mu=2"], "friction.mu: is given twice"),
        (["run", "II-B", "-s", "t_end=1 s", "--t-end", "2s"], "--t-end and --set t_end say the same"),
        (["--color", "never", "--color", "always", "cases"], "--color is given twice"),
    ],
)
def test_what_is_given_twice_is_an_error(command, said, here):
    found = call(*command)
    assert found.exit_code in (2, 3)
    assert said in found.stderr
    assert not list(here.iterdir())


# Large sweeps: parts in files of their own, read as one; long axes; what does not fit into memory.


CASE = short_case(t_end="1 s")
GRID = [(OMEGA0, "3:5:0.5 Hz", ""), ("c", "0.01:0.07/7", "")]
MEMBERS = read_members(CASE, 7, 3, {"x1": "1 mm"})
PLANS = {
    "fresh": make_plan(CASE, GRID),
    "carried": make_plan(CASE, GRID[:1] + [("c", "0.01, 0.02, 0.05", "")], "both", carry_state=True),
    "ensemble": make_plan(CASE, [(OMEGA0, "3, 4 Hz", "")], ensemble=(MEMBERS,)),
}


def in_parts(plan, folder, parts=3):
    """Files of all parts, each run by itself."""
    paths = [folder / f"{number}.h5" for number in range(1, parts + 1)]
    for number, path in enumerate(paths, 1):
        swept(shard(plan, number, parts), path)
    return paths


@pytest.mark.parametrize("plan", PLANS.values(), ids=PLANS)
def test_the_parts_are_the_whole_bit_by_bit(tmp_path, plan):
    paths = in_parts(plan, tmp_path)
    joined = join(reversed(paths))
    whole = swept(plan)
    assert joined.plan.fingerprint == plan.fingerprint
    assert_same_points(joined.table, whole.table)
    assert joined.attrs["points_done"] == plan.count and joined.attrs["complete"] == 1 and joined.complete
    saved = open_result(joined.save(tmp_path / "whole.h5"))
    assert_same_points(saved.table, whole.table)
    assert_same_points(swept(plan, tmp_path / "whole.h5").table, whole.table)


def test_columns_are_read_when_they_are_asked_for(tmp_path):
    joined = join(in_parts(PLANS["fresh"], tmp_path))
    assert joined["mean_speed"].shape == (5, 7, 1)
    assert joined._read.cache_info().currsize == 1 and "table" not in vars(joined)


def test_what_is_no_part_is_refused(tmp_path):
    paths = in_parts(PLANS["fresh"], tmp_path)
    with pytest.raises(ResultFileError, match="overlap in c"):
        join([paths[0], paths[1], paths[1]])
    other = make_plan(CASE, [GRID[0], ("c", "1, 2", "")], section=3)
    swept(other, tmp_path / "other.h5")
    with pytest.raises(ResultFileError, match=r"other\.h5: its case or its settings are not those of"):
        join([*paths, tmp_path / "other.h5"])
    twice = make_plan(CASE, [(OMEGA0, "6 Hz", ""), ("c", "1, 2", "")])
    swept(twice, tmp_path / "twice.h5")
    with pytest.raises(ResultFileError, match=r"differs from .* in omega0 and c"):
        join([paths[0], tmp_path / "twice.h5"])
    with pytest.raises(ResultFileError, match="no files"):
        join([])


def test_missing_members_are_noticed(tmp_path):
    paths = in_parts(PLANS["ensemble"], tmp_path)
    with pytest.raises(ResultFileError, match="members are missing"):
        join([paths[0], paths[2]])


@pytest.mark.parametrize("text", ["", "3", "0/3", "4/3", "a/b", "1/0", "-1/3"])
def test_shards_are_written_as_k_of_n(text):
    with pytest.raises(PlanError, match="K/N"):
        read_shard(text)


def test_what_cannot_be_cut():
    with pytest.raises(PlanError, match="c, has 7 values, not 8"):
        shard(PLANS["fresh"], 1, 8)
    with pytest.raises(PlanError, match="cannot be cut"):
        shard(make_plan(CASE, GRID[:1], carry_state=True), 1, 2)


def test_the_command(here):
    words = ("sweep", "II-B", "--omega0", "3:4:0.1", "--t-end", "1s", "-j", 2)
    for k in range(1, 4):
        assert call(*words, "--shard", f"{k}/3").exit_code == 0
    parts = sorted(here.glob("*.h5"))
    assert [path.name for path in parts] == [f"II-B-omega0-{k}of3.h5" for k in (1, 2, 3)]
    assert join(parts)["omega0"].tolist() == [round(3 + i / 10, 1) for i in range(11)]
    assert "--shard: the longest axis" in refused(*words, "--shard", "12/12")


def test_a_long_axis_is_stored_in_short(tmp_path):
    """20,001 values written out would be 200 kB of attribute."""
    plan = short_plan({OMEGA0: "3:5:0.0001 Hz"}, CASE, section=0)
    with SweepStore(plan, tmp_path / "long.h5"):
        pass
    with h5py.File(tmp_path / "long.h5") as file:
        assert len(file.attrs["sweep_settings_json"]) < 1000
    read = open_result(tmp_path / "long.h5").plan
    assert read.axes == plan.axes and read.fingerprint == plan.fingerprint
    assert np.array_equal(read.axes[0].numbers(), np.array([round(3 + i / 10000, 4) for i in range(20001)]))
    other = short_plan({OMEGA0: "3:5:0.0002 Hz"}, CASE, section=0)
    message = r"file 3, 3.0001, ... 5 Hz \(20001 values\), here 3, 3.0002, ... 5"
    with pytest.raises(ResultFileError, match=message):
        SweepStore(other, tmp_path / "long.h5")


def test_what_does_not_fit_into_memory_is_refused(monkeypatch, tmp_path):
    plan = PLANS["fresh"]
    needed = plan.count * sweep_plan.bytes_per_point(plan)
    table = SweepStore(plan).table
    held = sum(array.nbytes for array in table.numbers.values())
    assert held < needed < held + 200 * plan.count
    monkeypatch.setattr(sweep_plan, "_memory", lambda: int(needed / 0.71))
    with pytest.raises(PlanError, match=r"35 points of \d+ bytes take .*--shard"):
        SweepStore(plan, tmp_path / "s.h5")
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setattr(sweep_plan, "_memory", lambda: int(needed / 0.69))
    SweepStore(plan)

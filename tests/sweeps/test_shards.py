"""Large sweeps: parts in files of their own, read as one; long axes; what does not fit into memory."""

import h5py
import numpy as np
import pytest

from tests.command_line.made import call
from tests.sweeps.made import OMEGA0, assert_same_points, run_stored, short_case, short_plan
from vibsim.results import ResultFileError
from vibsim.results.simulation import open_result
from vibsim.sweeps import join, sweep_plan
from vibsim.sweeps.axes import read_members
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import PlanError, read_shard, shard
from vibsim.sweeps.sweeping import make_plan

CASE = short_case(t_end="1 s")
GRID = [(OMEGA0, "3:5:0.5 Hz", ""), ("c", "0.01:0.07/7", "")]
PLANS = {
    "fresh": make_plan(CASE, GRID),
    "carried": make_plan(CASE, GRID[:1] + [("c", "0.01, 0.02, 0.05", "")], "both", carry_state=True),
    "ensemble": make_plan(
        CASE, [(OMEGA0, "3, 4 Hz", "")], ensemble=(read_members(CASE, 7, 3, {"x1": "1 mm"}),)
    ),
}


def in_parts(plan, folder, parts=3):
    """Files of all parts, each run by itself."""
    paths = [folder / f"{number}.h5" for number in range(1, parts + 1)]
    for number, path in enumerate(paths, 1):
        run_stored(SweepStore(shard(plan, number, parts), path), 2)
    return paths


@pytest.mark.parametrize("plan", PLANS.values(), ids=PLANS)
def test_the_parts_are_the_whole_bit_by_bit(tmp_path, plan):
    paths = in_parts(plan, tmp_path)
    joined = join(reversed(paths))
    whole = run_stored(SweepStore(plan), 2)[0]
    assert joined.plan.fingerprint == plan.fingerprint
    assert_same_points(joined.table, whole.table)
    assert joined.attrs["points_done"] == plan.count and joined.attrs["complete"] == 1 and joined.complete
    saved = open_result(joined.save(tmp_path / "whole.h5"))
    assert_same_points(saved.table, whole.table)
    assert_same_points(run_stored(SweepStore(plan, tmp_path / "whole.h5"), 1)[0].table, whole.table)


def test_columns_are_read_when_they_are_asked_for(tmp_path):
    joined = join(in_parts(PLANS["fresh"], tmp_path))
    assert joined["mean_speed"].shape == (5, 7, 1)
    assert joined._read.cache_info().currsize == 1 and "table" not in vars(joined)


def test_what_is_no_part_is_refused(tmp_path):
    paths = in_parts(PLANS["fresh"], tmp_path)
    with pytest.raises(ResultFileError, match="overlap in c"):
        join([paths[0], paths[1], paths[1]])
    other = make_plan(CASE, [GRID[0], ("c", "1, 2", "")], section=3)
    run_stored(SweepStore(other, tmp_path / "other.h5"), 2)
    with pytest.raises(ResultFileError, match=r"other\.h5: its case or its settings are not those of"):
        join([*paths, tmp_path / "other.h5"])
    twice = make_plan(CASE, [(OMEGA0, "6 Hz", ""), ("c", "1, 2", "")])
    run_stored(SweepStore(twice, tmp_path / "twice.h5"), 2)
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


def test_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ("sweep", "II-B", "--omega0", "3:4:0.1", "--t-end", "1s", "-j", 2)
    for k in range(1, 4):
        assert call(*words, "--shard", f"{k}/3").exit_code == 0
    parts = sorted(tmp_path.glob("*.h5"))
    assert [path.name for path in parts] == [f"II-B-omega0-{k}of3.h5" for k in (1, 2, 3)]
    assert join(parts)["omega0"].tolist() == [round(3 + i / 10, 1) for i in range(11)]
    done = call(*words, "--shard", "12/12")
    assert done.exit_code == 2 and "--shard: the longest axis" in done.stderr


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
    with pytest.raises(
        ResultFileError, match=r"file 3, 3.0001, ... 5 Hz \(20001 values\), here 3, 3.0002, ... 5"
    ):
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

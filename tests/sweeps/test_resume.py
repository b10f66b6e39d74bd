"""What is finished stays finished: interruption, kill -9, resume, locks, refusals."""

import json
import random
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

import vibsim
from tests.sweeps.made import (
    OMEGA0,
    assert_same_points,
    complete,
    in_memory,
    run_stored,
    short_case,
    short_plan,
    until,
)
from vibsim.results import ResultFileError
from vibsim.results.simulation import open_result
from vibsim.results.store import Journal, journal_path, plain_data
from vibsim.sweeps.quantities import DONE, MISSING
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweeping import sweep

CARRIED = {"carry_state": True, "direction": "both"}


@pytest.mark.parametrize("settings", [{}, CARRIED], ids=["fresh", "carried"])
def test_an_interrupted_sweep_goes_on_to_the_same_bits(tmp_path, settings):
    # the first batches have one point, later ones an eighth of what is left: those under way are not all
    axes, case = {OMEGA0: "3:5:0.05 Hz"}, short_case(t_end="100 s")
    plan, path = short_plan(axes, case, **settings), tmp_path / "sweep.h5"
    run_stored(SweepStore(plan, path), 2, until(2))
    left = open_result(path)
    assert left.attrs["complete"] == 0 and 2 <= left.table.count(DONE) < plan.count
    assert np.isnan(left["mean_speed"][left["status"] == MISSING]).all()
    assert not journal_path(path).exists()
    result, computed = complete(plan, path)
    assert len(computed) == plan.count - left.table.count(DONE)
    assert_same_points(result.table, in_memory(plan))
    assert_same_points(open_result(path).table, result.table)
    assert complete(plan, path)[1] == []


def test_a_finished_file_is_not_written_again(tmp_path):
    plan, path = short_plan(), tmp_path / "sweep.h5"
    complete(plan, path)
    written = path.stat().st_mtime_ns, path.read_bytes()
    complete(plan, path)
    assert (path.stat().st_mtime_ns, path.read_bytes()) == written


def test_a_chain_is_recomputed_from_the_first_point_that_does_not_follow(tmp_path):
    plan, path = short_plan(**CARRIED), tmp_path / "sweep.h5"
    result, _ = complete(plan, path)
    with h5py.File(path, "r+") as file:
        file["end_x1"][2, 0] += 1e-9  # everything behind (2, up) was begun elsewhere
    store = SweepStore(plan, path)
    again, _ = run_stored(store, 1)
    order = next(plan.chains())
    for index in order:
        same = again["sha256"][index] == result["sha256"][index]
        assert same == (order.index(index) <= order.index((2, 0)))


def test_points_waiting_in_the_journal_are_taken_over(tmp_path):
    plan, path = short_plan(), tmp_path / "sweep.h5"
    points = in_memory(plan)
    with SweepStore(plan, path) as store:
        store._journal.add([plain_data(points.point((1, 0)))])
        with open(journal_path(path), "ab") as file:
            file.write(b'{"index": [2, 0], "status": 1, "sha')  # killed in the middle of a line
        copy = journal_path(path).read_bytes()
    journal_path(path).write_bytes(copy)
    _, computed = complete(plan, path)
    assert computed == [(0, 0), (2, 0), (3, 0), (4, 0)]
    assert_same_points(open_result(path).table, points)


def journal_begun(path):
    """When the journal was last written to; None while there is nothing in it."""
    try:
        found = journal_path(path).stat()
    except FileNotFoundError:
        return None
    return found.st_mtime_ns if found.st_size else None


def kill_at(plan_settings, path, delay):
    """Start a sweep as a process of its own and kill it after `delay` seconds of computing."""
    words = ["sweep", "II-B", "--omega0", "3:5:0.1", "-o", str(path), "-j", "2", "--t-end", "8s"]
    before = journal_begun(path)
    command = [sys.executable, "-m", "vibsim", *words, *plan_settings]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 100
    while journal_begun(path) in (None, before) and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.001)
    time.sleep(delay)
    process.kill()  # nothing, where it is done already
    process.wait()


@pytest.mark.parametrize("carried", [False, True], ids=["fresh", "carried"])
def test_kill_at_random_moments(tmp_path, carried):
    """Whatever the moment: the file opens, no finished point is lost, and the end is the same."""
    path, draw = tmp_path / "sweep.h5", random.Random(7)
    settings = CARRIED if carried else {}
    plan = short_plan({OMEGA0: "3:5:0.1 Hz"}, short_case(t_end="8 s"), **settings)
    known = 0
    for _ in range(4):
        kill_at(["--carry-state", "--direction", "both"] if carried else [], path, draw.uniform(0, 0.12))
        if path.exists():
            open_result(path)
        store = SweepStore(plan, path)
        assert store.table.count(DONE) >= known
        known = store.table.count(DONE)
        store._journal.close(remove=False)
    result, _ = complete(plan, path)
    assert_same_points(result.table, in_memory(plan))
    assert not journal_path(path).exists() and len(list(tmp_path.iterdir())) == 1


def test_another_sweep_is_refused_with_the_difference(tmp_path):
    path = tmp_path / "sweep.h5"
    complete(short_plan({OMEGA0: "3, 4 Hz"}), path)
    before = path.read_bytes()
    axes, case = {OMEGA0: "3, 5 Hz", "mu": "0.001, 0.002"}, short_case(coupling__c="0.002 N s/m")
    other = short_plan(axes, case, discard="1 s")
    with pytest.raises(ResultFileError) as error:
        SweepStore(other, path)
    message = str(error.value)
    assert "excitation.Omega0: in the file 3, 4 Hz (2 values), here 3, 5 Hz (2 values)" in message
    assert "friction.mu: in the file not swept, here 0.001, 0.002 (2 values)" in message
    assert "coupling.c: in the file 0.001 N s/m, here 0.002 N s/m" in message
    assert "discard: in the file 50 %, here 1 s" in message and "\n" not in message
    assert path.read_bytes() == before
    complete(other, path, force=True)
    assert open_result(path)["mean_speed"].shape == (2, 2, 1)


def test_the_spelling_of_the_same_sweep_makes_no_difference(tmp_path):
    path = tmp_path / "sweep.h5"
    complete(short_plan({OMEGA0: "3, 4 Hz"}), path)
    same = short_plan({"Omega0": "3.0,4.0 Hz"}, short_case(excitation__Omega0="3 Hz", coupling__c="1e-3"))
    assert complete(same, path)[1] == []


def test_a_trajectory_is_not_overwritten(tmp_path):
    path = vibsim.simulate(short_case()).save(tmp_path / "run.h5")
    with pytest.raises(ResultFileError, match="holds a trajectory, not a sweep"):
        SweepStore(short_plan(), path)


def test_a_second_process_is_refused(tmp_path):
    path = tmp_path / "sweep.h5"
    with (
        SweepStore(short_plan(), path),
        pytest.raises(ResultFileError, match="another command is writing it"),
    ):
        Journal(path, "sweep", path)
    Journal(path, "sweep", path).close(remove=True)


def journal_of(plan, path, count):
    """The journal of a sweep killed after `count` points, and those points."""
    points = in_memory(plan)
    with SweepStore(plan, path) as store:
        store.make_room(2)
        store.add([points.point(index) for index in next_indices(plan, count)])
        data = journal_path(path).read_bytes()
    open_result(path)
    path.unlink()
    return data, points


def next_indices(plan, count):
    return [index for chain in plan.chains() for index in chain][:count]


def test_journal_lines_are_plain_json(tmp_path):
    plan = short_plan({OMEGA0: "3, 4 Hz"})
    data, _ = journal_of(plan, tmp_path / "sweep.h5", 1)
    header, record, room = data.split(b"\n")
    assert json.loads(header.split(b" ", 2)[2]) == {"fingerprint": plan.fingerprint}
    assert json.loads(record.split(b" ", 2)[2])["index"] == [0, 0]
    assert len(room) > 1000 and not room.strip(b"\0")  # reserved for the points that were being computed


DAMAGES = {
    "a changed number": lambda lines: [lines[0], lines[1].replace(b'"events": ', b'"events": 1'), *lines[2:]],
    "an index": lambda lines: [lines[0], lines[1].replace(b"[0, 0]", b"[-1, 0]"), *lines[2:]],
    "hex that is none": lambda lines: [lines[0], lines[1].replace(b'": "', b'": "xyz'), *lines[2:]],
    "another key": lambda lines: [lines[0], lines[1].replace(b"status", b"statue"), *lines[2:]],
    "garbage in the middle": lambda lines: [lines[0], b"\xff\x00{", *lines[2:]],
    "no header": lambda lines: [b"garbage", *lines[1:]],
    "nothing but numbers": lambda lines: [lines[0], b"17", *lines[2:]],
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_record_is_told_left_out_and_computed_again(tmp_path, damage):
    plan, path = short_plan({OMEGA0: "3, 4, 5 Hz"}), tmp_path / "sweep.h5"
    data, points = journal_of(plan, path, 3)
    lines = DAMAGES[damage](data.split(b"\n"))
    journal_path(path).write_bytes(b"\n".join(lines))
    store = SweepStore(plan, path)
    assert store.notes == [f"{journal_path(path)}: 1 damaged record left out; computed again"]
    assert store.table.count(DONE) == (3 if damage == "no header" else 2)
    result, _ = run_stored(store, 1)
    assert_same_points(result.table, points)


def test_python_warns_of_a_damaged_record(tmp_path):
    plan, path = short_plan({OMEGA0: "3, 4 Hz"}), tmp_path / "sweep.h5"
    data, points = journal_of(plan, path, 2)
    journal_path(path).write_bytes(data.replace(b'"status": 1', b'"status": 2', 1))
    with pytest.warns(UserWarning, match="1 damaged record left out"):
        result = sweep(plan.case, {OMEGA0: "3, 4 Hz"}, out=path, jobs=1)
    assert_same_points(result.table, points)


def test_the_journal_of_another_sweep_is_refused(tmp_path):
    plan, path = short_plan({OMEGA0: "3, 4 Hz"}), tmp_path / "sweep.h5"
    data, _ = journal_of(plan, path, 2)
    journal_path(path).write_bytes(data)
    with pytest.raises(ResultFileError, match="points of another sweep are waiting"):
        SweepStore(short_plan({OMEGA0: "3, 5 Hz"}), path)


def test_a_journal_without_records_is_not_left(tmp_path):
    """As where the disk is full before the first point is done."""
    journal = Journal(tmp_path / "sweep.h5", "sweep")
    journal.restart("0" * 64)
    journal.close(remove=False)
    assert list(tmp_path.iterdir()) == []
    journal = Journal(tmp_path / "sweep.h5", "sweep")
    journal.restart("0" * 64)
    journal.add([{"point": 0}])
    journal.close(remove=False)
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.h5.journal"]

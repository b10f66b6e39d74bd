"""A disk that fills up during a run: a clear message, and what was computed stays readable."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

import vibsim
from tests.command_line.made import refused, told
from tests.fitting.made import small_plan
from tests.sweeps.made import run_stored
from vibsim.fitting.fit_result import run_fit
from vibsim.orbits.branches.branch import BranchStore
from vibsim.orbits.branches.continuing import orbit_from
from vibsim.orbits.branches.curve import complete
from vibsim.orbits.branches.locus_result import LocusStore, locus_plan
from vibsim.orbits.branches.plan import plan_from, read_span
from vibsim.results.simulation import open_result
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweeping import make_plan

RUN = """
import os, resource, sys
limit = int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))  # no file grows beyond that
if "no-fallocate" in sys.argv:
    del os.posix_fallocate
from vibsim.command_line.main import main
words = [word for word in sys.argv[2:] if word.startswith("--")]
sys.argv[1:] = ["run", "II-B", *(words or ["--every=1ms", "--t-end=300s"])]
main()
"""


def run(folder, limit, *options):
    command = [sys.executable, "-c", RUN, str(limit), *options]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def check_partial(folder, seconds):
    assert sorted(os.listdir(folder)) == ["II-B.h5.partial"]
    result = vibsim.open_result(folder / "II-B.h5.partial")
    assert not result.complete
    assert result.column("time")[-1] > seconds
    whole = vibsim.simulate(vibsim.load_case("II-B", {"run.every": "1 ms", "run.t_end": "100 s"}))
    count = min(len(whole), len(result))
    for name in result:
        assert np.array_equal(result[name][:count], whole[name][:count])
    return result


@pytest.mark.parametrize("option", ["", "no-fallocate"])
def test_room_for_a_part_of_the_run(tmp_path, option):
    done = run(tmp_path, 9_000_000, option)
    assert done.returncode == 6
    result = check_partial(tmp_path, seconds=60)
    last = result.column("time")[-1]
    assert done.stderr == f"Error: II-B.h5.partial: disk full; it holds the run until {last:g} s\n"
    assert len(result.events["t"]) > 100
    assert result.at(result.t_reached)["x1"] == result.events["x1"][-1]


def test_no_room_at_all(tmp_path):
    done = run(tmp_path, 100_000)
    assert (done.returncode, done.stderr) == (6, "Error: II-B.h5: disk full\n")
    assert os.listdir(tmp_path) == []


def test_a_run_asks_for_about_the_room_that_its_result_needs(tmp_path):
    """Some 3.5 kB for each of 21 columns, and the rows."""
    words = ["--t-end=2s"]
    assert run(tmp_path, 10_000_000, *words).returncode == 0
    size = os.path.getsize(tmp_path / "II-B.h5")
    os.remove(tmp_path / "II-B.h5")
    done = run(tmp_path, int(1.5 * size), *words)
    assert (done.returncode, done.stderr) == (0, "")
    assert os.path.getsize(tmp_path / "II-B.h5") < 150_000


@pytest.mark.parametrize("limit", [130_000, 200_000, 1_000_000, 2_500_000])
def test_whatever_room_there_is_the_file_opens(tmp_path, limit):
    done = run(tmp_path, limit, "--every=1ms", "--t-end=60s")
    assert done.returncode == 6 and "disk full" in done.stderr and done.stderr.count("\n") == 1
    assert ("holds the run" in done.stderr) == bool(os.listdir(tmp_path))
    for name in os.listdir(tmp_path):
        result = vibsim.open_result(tmp_path / name)
        assert len(result) > 1
        assert not result.complete
        assert all(len(result[each]) == len(result) for each in result)
        assert os.path.getsize(tmp_path / name) <= limit


BROKEN_DEVICE = """
import os, sys
from vibsim.command_line.main import main
from vibsim.results.recording import TrajectoryWriter
append = TrajectoryWriter.append
def append_to_a_device_that_breaks(self, samples, events):
    append(self, samples, events)
    if self.samples.rows > 150_000:
        os.dup2(os.open("/dev/full", os.O_RDWR), self._file.id.get_vfd_handle())
TrajectoryWriter.append = append_to_a_device_that_breaks
sys.argv[1:] = ["run", "II-B", "--every", "1ms", "--t-end", "300s"]
main()
"""


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
def test_a_write_that_fails_in_spite_of_that_leaves_what_was_flushed(tmp_path):
    command = [sys.executable, "-c", BROKEN_DEVICE]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    last = check_partial(tmp_path, seconds=60).column("time")[-1]
    said = f"Error: II-B.h5.partial: cannot write: disk full; it holds the run until {last:g} s\n"
    assert (done.returncode, done.stderr) == (6, said)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
def test_stdout_on_a_full_disk():
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "vibsim", "--version"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (6, "Error: stdout: disk full\n")


# What a killed sweep, branch, locus or fit has left: it is read as far as it came, and completed.


class Kill:
    """Keeps a folder as it stands once so much is done, and as a process that is killed then leaves it."""

    def __init__(self, folder, count):
        self.folder, self.count = folder, count
        self.there = 0  # points that were done by then

    def __call__(self, done):
        if done >= self.count and not self.there:
            shutil.copytree(self.folder, self.folder.parent / "killed")
            self.there = done
        return True


@pytest.fixture
def work(tmp_path, monkeypatch):
    """A folder to work in; what is killed is left in `killed` beside it, where commands are called."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path / "work"


def info(name):
    return json.loads(told("info", f"killed/{name}", "--json"))


def test_a_killed_sweep(work, monkeypatch):
    case = vibsim.load_case("I-A", {"run.t_end": "5 s"})
    plan = make_plan(case, [("omega", "3:4:0.1", "Hz", "axes")], section=3)
    kill = Kill(work, 4)
    store = SweepStore(plan, work / "s.h5")
    whole, _ = run_stored(store, 1, lambda table: kill(int((table.status == 1).sum())))
    facts = info("s.h5")
    assert facts["points_done"] == kill.there >= 4 and facts["complete"] == 0
    found = open_result("killed/s.h5")
    done = found["status"] == 1
    assert done.sum() == kill.there and np.array_equal(found["impacts"][done], whole["impacts"][done])
    told("plot", "killed/s.h5", "-o", "p.png")
    said = refused("sweep", "killed/s.h5", "--section", "9")
    assert "by the plan that it holds; leave --section out" in said
    assert f"{kill.there} points there before" in told("sweep", "killed/s.h5", "-j", "1")
    assert np.array_equal(open_result("killed/s.h5")["drift_rate"], whole["drift_rate"], equal_nan=True)
    assert "nothing to compute" in told("sweep", "killed/s.h5", "-j", "1")


def test_a_killed_branch_and_a_killed_locus(work):
    orbit = orbit_from(vibsim.load_case("I-C", {"omega": "4.2 Hz"}))
    plan = plan_from(orbit, *read_span(orbit.case, "omega", "4:4.3 Hz"))
    kill = Kill(work, 5)
    whole, _ = complete(BranchStore(plan, work / "b.h5"), 5000, watch=lambda count, *_: kill(count))
    assert info("b.h5")["points"] == kill.there == 5
    found = open_result("killed/b.h5")
    assert not found.attrs["complete"]
    assert np.isin(found["period"], whole["period"]).all()
    told("plot", "killed/b.h5", "-o", "p.png")
    told("continue", "killed/b.h5", "-q")
    assert np.array_equal(open_result("killed/b.h5")["period"], whole["period"])
    shutil.rmtree("killed")
    followed = locus_plan(whole, "PD1", *read_span(whole.case, "c", "0.001:0.003 N s/m"))
    kill = Kill(work, 3)
    locus, _ = complete(LocusStore(followed, work / "l.h5"), 6, lambda count, *_: kill(count))
    assert len(info("l.h5")["points"]) == kill.there == 3
    told("continue", "killed/l.h5", "--max-points", "6", "-q")
    assert np.array_equal(open_result("killed/l.h5")["second"], locus["second"])


def test_a_killed_fit(work):
    plan = small_plan()
    kill = Kill(work, 5)
    whole, _ = run_fit(plan, work / "f.h5", 1, watch=lambda *_: kill(count_of(work / "f.h5.journal")))
    facts = info("f.h5")
    assert facts["runs"] == kill.there >= 5 and facts["complete"] == 0
    found = open_result("killed/f.h5")
    for there, of_whole in zip(found.candidates, whole.candidates, strict=False):
        assert there.changes == of_whole.changes
    assert found.candidates and len(found.runs) == kill.there
    told("fit", "killed/f.h5", "-j", "1", "-q")
    completed = open_result("killed/f.h5")
    assert completed.complete
    assert [each.price for each in completed.ranking] == [each.price for each in whole.ranking]


def count_of(journal):
    """Runs in a journal: its lines behind the first."""
    return journal.read_bytes().count(b"\n") - 1 if journal.exists() else 0

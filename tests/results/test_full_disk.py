"""A disk that fills up during a run: a clear message, and what was computed stays readable."""

import os
import subprocess
import sys

import numpy as np
import pytest

import vibsim

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


@pytest.mark.parametrize("limit", [130_000, 200_000, 500_000, 1_000_000, 2_000_000, 2_500_000])
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

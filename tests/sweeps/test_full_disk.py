"""A disk that fills up during a sweep: a clear message, and no point that was computed is lost."""

import os
import subprocess
import sys

import pytest

from tests.sweeps.made import assert_same_points, complete, in_memory, short_case, short_plan
from vibsim.results.simulation import open_result
from vibsim.sweeps.quantities import DONE
from vibsim.sweeps.sweep_file import SweepStore

SWEEP = """
import os, resource, sys
from vibsim.command_line.main import main
limit, section = int(sys.argv[1]), sys.argv[2]
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))  # no file grows beyond that
sys.argv[1:] = "sweep II-B --omega0 3:5:0.1 --t-end 2s -j 2 -o s.h5 --section".split() + [section]
main()
"""
AXES = {"excitation.Omega0": "3:5:0.1 Hz"}


def size_without_points(plan, path):
    with SweepStore(plan, path):
        size = os.path.getsize(path)
    path.unlink()
    return size


@pytest.mark.skipif(sys.platform == "win32", reason="needs limits of a process")
@pytest.mark.parametrize(
    ("section", "further", "left"),
    [
        (100, 500, ["s.h5", "s.h5.journal"]),  # room for the journal, none for the file that takes it up
        (1500, 600_000, ["s.h5"]),  # room for the file, none for the journal of all points
    ],
)
def test_nothing_computed_is_lost(tmp_path, section, further, left):
    plan, path = short_plan(AXES, short_case(t_end="2 s"), section=section), tmp_path / "s.h5"
    limit = size_without_points(plan, path) + further
    command = [sys.executable, "-c", SWEEP, str(limit), str(section)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 6
    assert "disk full; " in done.stderr and "and the same command resumes it" in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(os.listdir(tmp_path)) == left
    open_result(path)
    store = SweepStore(plan, path)
    kept = store.table.count(DONE)
    store._journal.close(remove=False)
    assert kept > 0
    result, computed = complete(plan, path)
    assert len(computed) == plan.count - kept
    assert_same_points(result.table, in_memory(plan))
    assert os.listdir(tmp_path) == ["s.h5"]

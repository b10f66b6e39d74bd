"""Budget: memory does not grow with the length of a run. Minutes, and 2 GB in the temporary folder."""

import os
import subprocess
import tempfile
from pathlib import Path

from tests.budgets.processes import VIBSIM
from tests.budgets.row import Row


def rows():
    figures = [peak_megabytes(t_end) for t_end in ("300 s", "100000 s")]
    note = f"the same for 300 s: {figures[0]:.0f} MB"
    yield Row("II-B, 100,000 s at 5 ms, resident memory", "MB", 300.0, figures[1:], [note])


def peak_megabytes(t_end):
    """Largest resident memory [MB] of `vibsim run II-B` up to t_end."""
    with tempfile.TemporaryDirectory() as folder:
        command = [VIBSIM, "-q", "run", "II-B", "--t-end", t_end, "-o", Path(folder) / "long.h5"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
    assert os.waitstatus_to_exitcode(status) == 0, "vibsim run failed"
    return usage.ru_maxrss / 1024  # kB on Linux

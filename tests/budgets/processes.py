"""Budget: the whole `vibsim run` process against importing what it stands on; start-up of `vibsim --help`."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.budgets.row import Row, stopwatch

VIBSIM = Path(sys.executable).with_name("vibsim")
CASES = Path(__file__).resolve().parents[2] / "cases"
IMPORTS = [sys.executable, "-c", "import numpy, h5py, click, yaml"]
PAIRS = 11
# an installed vibsim has its bytecode, as numpy and the others have theirs
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
# as the command has it: numpy's threads are not vibsim's to count
ENVIRONMENT |= {"OPENBLAS_NUM_THREADS": "1"}


def rows():
    with tempfile.TemporaryDirectory() as folder:
        run = [VIBSIM, "run", CASES / "II-B.yaml", "-o", Path(folder) / "II-B.h5", "--force"]
        seconds(run), seconds(IMPORTS)  # once for the disk's sake, and to write the bytecode
        pairs = [(seconds(run), seconds(IMPORTS)) for _ in range(PAIRS)]
    note = f"run {low_to_high([a for a, _ in pairs])}, imports {low_to_high([b for _, b in pairs])}"
    yield Row(
        "vibsim run cases/II-B.yaml / its imports, processes", "x", 2.0, [a / b for a, b in pairs], [note]
    )
    yield Row("vibsim run cases/II-B.yaml, process", "s", 0.23, [a for a, _ in pairs])
    helps = [seconds([VIBSIM, "--help"]) * 1e3 for _ in range(PAIRS)]
    yield Row("vibsim --help, process", "ms", 150.0, helps)


def seconds(command):
    """Wall time of a process [s]; raises CalledProcessError when it fails."""
    nowhere = subprocess.DEVNULL
    return stopwatch(
        lambda: subprocess.run(command, check=True, stdout=nowhere, stderr=nowhere, env=ENVIRONMENT)
    )


def low_to_high(values):
    """Smallest and largest of some times [s], in ms."""
    return f"{min(values) * 1e3:.0f}-{max(values) * 1e3:.0f} ms"

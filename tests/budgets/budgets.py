"""Every budget of the project, measured: limit, median (smallest-largest), ratio to the limit, verdict.

    python tests/budgets/budgets.py [--long] [NAME...]        NAME: a part, such as engine_time

Run it on a quiet machine. Peers that are not installed are left out. Exits with 1 where a budget is not met.
"""

import importlib
import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PARTS = ("processes", "engine_time", "mode_rows", "against_heyoka", "against_scipy", "sweep_time")
LONG = ("memory",)
PEERS = ("vibsim", "numpy", "scipy", "h5py", "pydantic", "heyoka")


def installed(package):
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def main(arguments):
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    chosen = [name for name in arguments if name != "--long"]
    parts = chosen or PARTS + (LONG if "--long" in arguments else ())
    print(f"Python {platform.python_version()}, " + ", ".join(f"{name} {installed(name)}" for name in PEERS))
    print(f"{'budget':<58} {'limit':>14} {'median (smallest-largest)':>32} {'ratio':>7}")
    missed = 0
    for part in parts:
        for row in importlib.import_module(f"tests.budgets.{part}").rows():
            print(row, flush=True)
            missed += row.met == "NOT MET"
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

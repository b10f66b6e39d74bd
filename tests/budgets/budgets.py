"""Every budget of the project, measured: limit, median (smallest-largest), ratio to the limit, verdict.

    python tests/budgets/budgets.py [--long] [--no-history] [NAME...]        NAME: a part, such as engine_time

Run it on a quiet machine. Peers that are not installed are left out. What was measured is appended to
docs/benchmarks/history.json, also when it is interrupted. Exits with 1 where a budget is not met.
"""

import importlib
import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PARTS = ("processes", "engine_time", "mode_rows", "against_heyoka", "against_scipy", "sweep_time")
LONG = ("memory",)
OPTIONS = ("--long", "--no-history")
PEERS = ("vibsim", "numpy", "scipy", "h5py", "heyoka")


def installed(package):
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def main(arguments):
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    chosen = [name for name in arguments if name not in OPTIONS]
    parts = chosen or PARTS + (LONG if "--long" in arguments else ())
    versions = {name: installed(name) for name in PEERS}
    print(f"Python {platform.python_version()}, " + ", ".join(map(" ".join, versions.items())))
    print(f"{'budget':<58} {'limit':>14} {'median (smallest-largest)':>32} {'ratio':>7}")
    measured = []
    try:
        for part in parts:
            for row in importlib.import_module(f"tests.budgets.{part}").rows():
                print(row, flush=True)
                measured.append(row)
    finally:
        if measured and "--no-history" not in arguments:
            keep(measured, versions)
    return 1 if any(row.met == "NOT MET" for row in measured) else 0


def keep(measured, versions):
    """Append what was measured to the history."""
    from tests.budgets.history import HISTORY, append, run_of

    append(run_of(measured, versions))
    print(f"appended to {HISTORY}")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

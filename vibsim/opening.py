"""Open a result file, whatever kind of result it holds: above all the rooms that write one."""

from pathlib import Path
from typing import Any

from vibsim.results.simulation import kind_of
from vibsim.signals import ended_at_once


@ended_at_once()
def open_result(path: str | Path) -> Any:
    """The Result (SweepResult, FitResult, Branch, BenchResult) in an HDF5 file that vibsim wrote.

    Raises ResultFileError when the file is missing, not readable, foreign, damaged or of a newer format.

    >>> import vibsim
    >>> path = vibsim.simulate(vibsim.load_case("gallery/three-balls")).save("balls.h5")
    >>> vibsim.open_result(path).attrs["impacts"]
    1
    """
    match kind_of(path):
        case "trajectory":
            from vibsim.results.simulation import open_trajectory_file as read
        case "sweep":
            from vibsim.sweeps import open_sweep as read
        case "fit":
            from vibsim.fitting import open_fit as read
        case "branch":
            from vibsim.orbits.branches.branch_file import read_branch as read
        case "locus":
            from vibsim.orbits.branches.branch_file import read_locus as read
        case _:
            from vibsim.evidence.benchmark import open_bench as read
    return read(path)

"""A run, however it is named: a Result, its file, or a case that is run first."""

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from vibsim.results.opening import names_a_result, open_trajectory_file
from vibsim.results.result import Result
from vibsim.results.simulation import simulate

if TYPE_CHECKING:
    from vibsim.cases import Case


def as_result(run: "Result | Case | str | PathLike[str]") -> Result:
    """The Result itself, that in a file, or that of running a case (a Case, its file or its shipped name).

    Raises ResultFileError, CaseError, and TypeError for anything else.
    """
    if isinstance(run, Result):
        return run
    if isinstance(run, str | PathLike) and names_a_result(Path(run)):
        stored: Result = open_trajectory_file(Path(run))
        return stored
    return simulate(run)

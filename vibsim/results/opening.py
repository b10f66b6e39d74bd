"""Open a trajectory file, and tell what kind of result a file holds."""

from pathlib import Path
from typing import Any

from vibsim.files.errors import ResultFileError
from vibsim.files.signals import ended_at_once

KINDS = ("trajectory", "sweep", "fit", "branch", "locus", "bench")


@ended_at_once()
def kind_of(path: str | Path) -> str:
    """What a result file holds, one of KINDS; raises as `vibsim.open_result`."""
    from vibsim.files.attributes import read_attr
    from vibsim.files.reading import damage_named, open_hdf5

    with damage_named(Path(path)), open_hdf5(Path(path)) as file:
        kind = str(read_attr(file, "vibsim_kind", "trajectory"))
    if kind not in KINDS:
        raise ResultFileError(f"{path}: holds a {kind!r:.60}, which this vibsim does not read")
    return kind


def names_a_result(source: str | Path) -> bool:
    """Whether a source is a result file, or is called as one that is not there."""
    from vibsim.cases.reading.sources import called_as_result

    return str(source) != "-" and (is_result_file(source) or called_as_result(str(source)))


def is_result_file(path: str | Path) -> bool:
    """Whether `path` is a regular file that begins as an HDF5 file does; of a pipe nothing is read.

    One that must not be read is judged by its name, and whoever opens it says so.
    """
    from vibsim.cases.reading.sources import called_as_result
    from vibsim.files.signature import check_signature

    try:
        check_signature(Path(path))
    except ResultFileError as error:
        return isinstance(error.__cause__, PermissionError) and called_as_result(str(path))
    return True


def open_trajectory_file(path: str | Path) -> Any:
    """The Result in a trajectory file; raises as `open_result`, and for no single run."""
    from vibsim.results.result import Result
    from vibsim.results.stored.trajectory_file import TrajectoryFile

    if kind_of(path) != "trajectory":
        raise ResultFileError(f"{path}: holds no single run")
    file = TrajectoryFile(path)
    return Result(file.attrs, file.samples, file.events, case=file.case, digits=file.digits, orbit=file.orbit)

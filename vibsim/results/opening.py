"""Open a result file, whatever kind of result it holds."""

from importlib import import_module
from pathlib import Path
from typing import Any

from vibsim.results.errors import ResultFileError
from vibsim.results.signals import ended_at_once

# vibsim_kind -> who reads it, by name: they stand above results, which must not import them.
READERS = {
    "trajectory": ("vibsim.results.opening", "open_trajectory_file"),
    "sweep": ("vibsim.sweeps", "open_sweep"),
    "fit": ("vibsim.fitting", "open_fit"),
    "bench": ("vibsim.benchmark", "open_bench"),
}


@ended_at_once()
def open_result(path: str | Path) -> Any:
    """The Result (SweepResult, FitResult, BenchResult) in an HDF5 file that vibsim wrote.

    Raises ResultFileError when the file is missing, not readable, foreign, damaged or of a newer format.
    """
    kind = kind_of(path)
    if kind not in READERS:
        raise ResultFileError(f"{path}: holds a {kind!r}, which this vibsim does not read")
    module, function = READERS[kind]
    return getattr(import_module(module), function)(path)


@ended_at_once()
def kind_of(path: str | Path) -> str:
    """What a result file holds: "trajectory", "sweep", "fit" or "bench"; raises as `open_result`."""
    from vibsim.results.hdf5_file import damage_named, open_hdf5

    with damage_named(Path(path)), open_hdf5(Path(path)) as file:
        return str(file.attrs.get("vibsim_kind", "trajectory"))


def is_result_file(path: str | Path) -> bool:
    """Whether `path` is a regular file that begins as an HDF5 file does; of a pipe nothing is read."""
    from vibsim.results.hdf5_file import check_signature

    try:
        check_signature(Path(path))
    except ResultFileError:
        return False
    return True


def open_trajectory_file(path: str | Path):
    """The Result in a trajectory file."""
    from vibsim.results.result import Result
    from vibsim.results.trajectory_file import TrajectoryFile

    file = TrajectoryFile(path)
    return Result(file.attrs, file.samples, file.events, case=file.case, digits=file.digits)

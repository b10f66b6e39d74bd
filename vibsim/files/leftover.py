"""What a run that was killed, or that came to no end, has left beside its output as NAME.partial."""

from pathlib import Path

from vibsim.files.errors import ResultFileError
from vibsim.files.signals import ended_at_once


def partial_path(target: Path) -> Path:
    """Where an output is written before it is whole: NAME.partial beside the target."""
    return target.with_name(target.name + ".partial")


def check_leftover(path: str | Path, force: bool = False) -> None:
    """Raise ResultFileError where NAME.partial beside an output is being written, or holds a part of a run.

    `force` lets a part of a run be replaced. What holds nothing that can be read is in nobody's way.
    """
    partial = partial_path(Path(path).absolute().resolve())
    if not partial.is_file():
        return
    if is_locked(partial):
        raise ResultFileError(f"{path}.partial: another run is writing it")
    reached = 0.0 if force else held_until(partial)
    if reached > 0.0:
        what = f"holds a run that did not come to its end, until {reached:g} s"
        raise ResultFileError(f"{path}.partial: {what}; kept (force=True replaces it)")


@ended_at_once()
def held_until(partial: Path) -> float:
    """Time [s] of the last sample in an unfinished trajectory file; 0 without one, or without such a file."""
    import h5py

    from vibsim.files.attributes import read_attr

    try:
        with h5py.File(partial, "r") as file:
            time = file["time"]
            is_run = read_attr(file, "vibsim_kind", "trajectory") == "trajectory"
            return float(time[-1]) if is_run and len(time) else 0.0
    except (OSError, KeyError, RuntimeError, TypeError, ValueError):
        return 0.0


def is_locked(path: Path) -> bool:
    """Whether another process has the file open and locked, as HDF5 does while it writes."""
    try:
        import fcntl
    except ImportError:  # where there are no such locks, the system itself refuses to open the file twice
        return False
    try:
        with open(path, "rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False

"""Output that appears whole or not at all: written beside its target, then renamed.

For every kind of output file: an existing one stays as it is unless `force`.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from vibsim.files.errors import ResultFileError, reason
from vibsim.files.signals import held_back
from vibsim.files.writers import check_leftover, open_partial

RESULT_SUFFIXES = (".h5", ".hdf5")


def check_result_name(path: str | Path) -> None:
    """Raises ResultFileError for a file name whose suffix promises another format than that of results."""
    suffix = Path(path).suffix
    if suffix.lower() not in RESULT_SUFFIXES:
        suffix_text = f"suffix {suffix}" if suffix else "no suffix"
        exported = "; for CSV or MAT: vibsim export" if suffix.lower() in (".csv", ".mat") else ""
        raise ResultFileError(f"{path}: {suffix_text}; results are HDF5 files, .h5 or .hdf5{exported}")


def check_result_output(path: str | Path, force: bool = False) -> Path:
    """As `check_output`, for a file of results. Raises ResultFileError, also for its suffix."""
    check_result_name(path)
    return check_output(path, force)


def check_output(path: str | Path, force: bool = False) -> Path:
    """Absolute path of an output file that may be written (links followed).

    Raises ResultFileError when it, or a part of a run beside it, exists and `force` is not given, when it is
    not a regular file or being written, or when its folder is missing or not writable.
    """
    try:
        target = Path(path).absolute().resolve()
        if target.exists():
            _check_existing(path, target, force)
        check_leftover(path, force)  # fails where that name is too long
        folder = target.parent
        if not folder.is_dir():
            raise ResultFileError(f"{path}: cannot write: folder {folder} does not exist")
        if not os.access(folder, os.W_OK | os.X_OK, effective_ids=os.access in os.supports_effective_ids):
            raise ResultFileError(f"{path}: cannot write: folder {folder} is not writable")
    except (OSError, RuntimeError, ValueError) as error:
        raise ResultFileError(f"{path}: cannot write: {reason(error)}") from error
    return target


def _check_existing(path: str | Path, target: Path, force: bool) -> None:
    if target.is_dir():
        raise ResultFileError(f"{path}: cannot write: is a folder")
    if not target.is_file():
        raise ResultFileError(f"{path}: cannot write: is not a regular file")
    if not force:
        raise ResultFileError(f"{path}: exists; kept (force=True replaces it)")


def publish(partial: Path, target: Path, force: bool = False) -> None:
    """Make a finished partial file durable and give it its name: fsync, rename, fsync of the folder.

    Raises ResultFileError where that cannot be, or where another has come under that name and `force` is not
    given.
    """
    try:
        with held_back():
            _fsync(partial)
            if force or not _linked(partial, target):
                os.replace(partial, target)
            if os.name == "posix":
                _fsync(target.parent)
    except OSError as error:
        raise ResultFileError(f"{target}: cannot write: {reason(error)}") from error


def _linked(partial: Path, target: Path) -> bool:
    """Whether a partial file has got a name that nothing had.

    False on a disk without links, where nothing has it yet. Raises ResultFileError where something has.
    """
    try:
        os.link(partial, target)
    except OSError:
        if os.path.lexists(target):
            raise ResultFileError(f"{target}: appeared meanwhile; kept (force=True replaces it)") from None
        return False
    partial.unlink()
    return True


@contextmanager
def output_file(path: str | Path, force: bool = False, encoding: str | None = None) -> Iterator[IO[Any]]:
    """A file to write to, binary or of an encoding; published when the block ends, removed when it raises.

    Other programs may write to the path that is its `name`. Two writers of one output have two such files.
    """
    target = check_output(path, force)
    partial, file = target, None
    try:
        with held_back():
            descriptor, partial = open_partial(target)
            file = open(  # noqa: SIM115
                partial,
                "w+b" if encoding is None else "w+",
                encoding=encoding,
                newline=None if encoding is None else "",
                opener=lambda *_: descriptor,
            )
        yield file
        file.flush()
        if os.name != "posix":  # what is open cannot be renamed there
            file.close()
        publish(partial, target, force)
    except OSError as error:
        raise ResultFileError(f"{path}: cannot write: {reason(error)}") from error
    finally:
        if file is not None:
            with held_back(), suppress(OSError):
                partial.unlink(missing_ok=True)
            with held_back(), suppress(OSError):  # of a full disk, once more
                file.close()


def _fsync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)

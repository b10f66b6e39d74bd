"""HDF5 files that vibsim wrote, opened for reading; whatever else is there is refused in one line."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from vibsim import __version__
from vibsim.results.errors import ResultFileError
from vibsim.results.output_file import reason
from vibsim.results.provenance import FORMAT
from vibsim.results.structure import damaged

SIGNATURE = b"\x89HDF\r\n\x1a\n"


def open_hdf5(path: Path) -> h5py.File:
    """Open an HDF5 file that vibsim wrote, of a format that this version reads, or raise ResultFileError."""
    check_signature(path)
    try:
        file = h5py.File(path, "r")
    except (OSError, RuntimeError) as error:
        raise ResultFileError(f"{path}: {_open_failure(error)}") from error
    try:
        with damage_named(path):
            _check_format(path, file)
    except BaseException:
        file.close()
        raise
    return file


def _check_format(path: Path, file: h5py.File) -> None:
    written = file.attrs.get("vibsim_format")
    if written is None:
        raise ResultFileError(f"{path}: is an HDF5 file, but not one that vibsim wrote")
    if getattr(written, "shape", None) != () or written.dtype.kind not in "iu" or written < 1:
        raise damaged(path, "the attribute vibsim_format is not a whole number from 1 on")
    if written > FORMAT:
        version = file.attrs.get("vibsim_version", "a newer version")
        found = f"has format {int(written)}, written by vibsim {version}"
        raise ResultFileError(f"{path}: {found}; this is vibsim {__version__}, which reads up to {FORMAT}")


def check_signature(path: Path) -> None:
    """Raise ResultFileError unless `path` is a readable file that begins as an HDF5 file does."""
    try:
        if not stat.S_ISREG(mode := os.stat(path).st_mode) and not stat.S_ISDIR(mode):
            raise ResultFileError(f"{path}: is not a regular file")
        with open(path, "rb") as file:
            start = file.read(len(SIGNATURE))
    except (OSError, ValueError) as error:
        raise ResultFileError(f"{path}: {reason(error)}") from error
    if not start:
        raise ResultFileError(f"{path}: is empty")
    if start != SIGNATURE:
        raise ResultFileError(f"{path}: is not an HDF5 file")


@contextmanager
def damage_named(path: Path) -> Iterator[None]:
    """Turn whatever HDF5 raises over a damaged file into a ResultFileError."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise damaged(path, reason(error)) from error


def _open_failure(error: Exception) -> str:
    text = str(error)
    if "truncated" in text:
        return "is truncated: it ends before the end that it names"
    if "lock" in text:
        return "is being written by another run"
    return f"damaged: {reason(error)}"

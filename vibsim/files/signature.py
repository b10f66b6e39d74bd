"""How HDF5 files begin; told without loading HDF5."""

import os
import stat
from pathlib import Path

from vibsim.files.errors import ResultFileError, reason

SIGNATURE = b"\x89HDF\r\n\x1a\n"


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

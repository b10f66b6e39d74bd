"""Room on disk for HDF5, made before it is needed, so that a full disk is noticed while the file is whole.

A write that fails inside HDF5 leaves a file that may not open again. Room that is reserved first lets every
later write succeed; when it cannot be reserved, nothing has been touched yet.
"""

import errno
import os
from pathlib import Path

DISK_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


def reserve(path: Path, used: int, size: int) -> bool:
    """Reserve `size` bytes behind the first `used` bytes of a file; False without room."""
    try:
        with open(path, "r+b") as file:
            _extend(file.fileno(), used, size)
    except OSError as error:
        return error.errno not in DISK_FULL
    return True


def release(path: Path, used: int) -> None:
    """Give back what was reserved behind the first `used` bytes of a closed file."""
    if path.stat().st_size > used:
        os.truncate(path, used)


def detach(descriptor: int) -> None:
    """Let whatever is still written to an open file go to a temporary one, after a write to it has failed.

    HDF5 insists on writing what it holds when a file is closed, and brings the process down when it cannot.
    """
    from tempfile import TemporaryFile

    with TemporaryFile() as elsewhere:
        os.dup2(elsewhere.fileno(), descriptor)


def _extend(descriptor: int, start: int, count: int) -> None:
    """Allocate `count` bytes from `start`; where the system has no call for that, by writing zeros."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(descriptor, start, count)
        return
    os.lseek(descriptor, start, os.SEEK_SET)
    while count > 0:
        count -= os.write(descriptor, bytes(min(count, 1 << 20)))

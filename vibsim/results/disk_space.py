"""Reserve space on disk before HDF5 needs it, so that a full disk is noticed while the file is still whole.

A write that fails inside HDF5 leaves a file that may not open again. Space that is reserved first makes every
later write succeed; when the reservation fails nothing has been touched yet.
"""

import errno
import os
from pathlib import Path

MARGIN = 1 << 20  # bytes kept for what HDF5 writes besides the data: indices, attributes, the last chunks
DISK_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


def reserve(descriptor: int, path: Path, used: int, wanted: int) -> bool:
    """Reserve `wanted` bytes and a margin behind the first `used` bytes of an open file; False without room.

    Where the file system cannot reserve, the free space is looked at instead.
    """
    if not hasattr(os, "posix_fallocate"):
        return _free_space(path) >= wanted + MARGIN
    try:
        os.posix_fallocate(descriptor, 0, used + wanted + MARGIN)
    except OSError as error:
        return error.errno not in DISK_FULL
    return True


def release(path: Path, used: int) -> None:
    """Give back what was reserved behind the first `used` bytes of a closed file."""
    if path.stat().st_size > used:
        os.truncate(path, used)


def _free_space(path: Path) -> int:
    import shutil

    return shutil.disk_usage(path.parent).free

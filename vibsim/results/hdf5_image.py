"""HDF5 files that are written whole: made in memory, so that a full disk fails in one plain write.

A write that fails inside HDF5 leaves a file that it insists on closing, and an error in words of its own.
"""

from collections.abc import Callable
from pathlib import Path

import h5py

from vibsim.results.output_file import output_file

LIBVER = ("earliest", "v110")  # opens in every HDF5 since 1.10, h5netcdf and netCDF4
STEP = 1 << 20  # bytes by which the image grows


def write_hdf5(path: Path, fill: Callable[[h5py.File], None]) -> None:
    """Write what `fill` puts into a new file to `path`, replacing what is there in one instant.

    Raises ResultFileError where it cannot be written; then what was there is still there.
    """
    options = {"driver": "core", "backing_store": False, "block_size": STEP}
    with h5py.File(path.name, "w", libver=LIBVER, **options) as file:
        fill(file)
        file.flush()
        image = file.id.get_file_image()
    with output_file(path, force=True) as partial:
        partial.write_bytes(image)

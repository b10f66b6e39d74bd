"""A trajectory as a MATLAB file (version 5): the columns by name, a struct `events`, a struct `info`."""

from pathlib import Path

import numpy as np

from vibsim.files.errors import ResultFileError
from vibsim.files.output_file import output_file
from vibsim.results.result import Result
from vibsim.results.windows import Window, rows_within

LARGEST = (1 << 31) - 1  # bytes: version 5 counts them in 32 bits, and MATLAB reads up to here


def write_mat(result: Result, path: str | Path, window: Window, force: bool = False) -> None:
    """Write the samples and events within the window [s] to `path`, SI units.

    Raises ResultFileError when `path` exists and `force` is not given, cannot be written, or gets too large.
    """
    samples = rows_within(result.column("time"), window)
    events = rows_within(result.event_column("t"), window)
    columns = {name: result.column(name) for name in result}
    bytes_needed = (samples.stop - samples.start) * sum(column.dtype.itemsize for column in columns.values())
    if bytes_needed > LARGEST:
        size_text = f"would hold {bytes_needed / 2**30:.1f} GB"
        raise ResultFileError(f"{path}: {size_text}, a MAT file takes 2 GB; export a window, or as CSV")
    from scipy.io import savemat

    contents: dict[str, object] = {name: column[samples] for name, column in columns.items()}
    contents["events"] = {name: result.event_column(name)[events] for name in result.events}
    contents["info"] = {name: _plain(value) for name, value in result.attrs.items()}
    with output_file(path, force) as file:
        savemat(file, contents, do_compression=True, oned_as="column")


def _plain(value: object) -> object:
    return np.float64(value) if isinstance(value, int | float) else value

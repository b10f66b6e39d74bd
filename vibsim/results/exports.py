"""A trajectory as CSV (RFC 4180): one line of column names, then one line per sample or event, SI units.

Numbers are written so that they read back as the same double. Rows are read and written in pieces: memory
does not grow with the file.
"""

from pathlib import Path
from typing import Any

import numpy as np

from vibsim.results.columns import tables_of
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.labelled import PIECE
from vibsim.results.output_files import output_file
from vibsim.results.result import Result
from vibsim.results.windows import Window, pieces, rows_within


def write_csv(
    result: Result, path: str | Path, window: Window, force: bool = False, events: bool = False
) -> None:
    """Write the samples (or the `events`) within the window [s] to `path`.

    Raises ResultFileError when `path` exists and `force` is not given, or cannot be written.
    """
    names = list(result.events) if events else result.keys()
    words = _words(result, events)
    columns = [result.event_column(name) if events else result.column(name) for name in names]
    with output_file(path, force, "ascii") as file:
        file.write(",".join(names) + "\r\n")
        for piece in pieces(rows_within(columns[0], window), PIECE):
            values = [
                _texts(column[piece].tolist(), words.get(name))
                for name, column in zip(names, columns, strict=True)
            ]
            file.writelines(",".join(row) + "\r\n" for row in zip(*values, strict=True))


def _words(result: Result, events: bool) -> dict[str, dict[int, str]]:
    """Columns of codes, which are written as words: names of their values."""
    tables = tables_of(result.case.scene())
    columns = tables.events if events else tables.samples
    return {
        name: {code: word for word, code in column.flags.items()}
        for name, column in columns.items()
        if column.flags
    }


def _texts(values: list[Any], words: dict[int, str] | None) -> list[str]:
    if words is not None:
        return [words.get(code, str(code)) for code in values]
    return [repr(value) for value in values]


# A trajectory as a MATLAB file (version 5): the columns by name, a struct `events`, a struct `info`.


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

"""A trajectory as CSV (RFC 4180): one line of column names, then one line per sample or event, SI units.

Numbers are written so that they read back as the same double. Rows are read and written in pieces: memory
does not grow with the file.
"""

from pathlib import Path

from vibsim.physics.modes import EVENT_NAMES
from vibsim.results.output_file import output_file
from vibsim.results.result import Result
from vibsim.results.windows import Window, pieces, rows_within

PIECE = 16384  # rows


def write_csv(
    result: Result, path: str | Path, window: Window, force: bool = False, events: bool = False
) -> None:
    """Write the samples (or the `events`) within the window [s] to `path`.

    Raises ResultFileError when `path` exists and `force` is not given, or cannot be written.
    """
    names = list(result.events) if events else result.keys()
    columns = [result.event_column(name) if events else result.column(name) for name in names]
    with output_file(path, force) as partial, open(partial, "w", encoding="ascii", newline="") as file:
        file.write(",".join(names) + "\r\n")
        for piece in pieces(rows_within(columns[0], window), PIECE):
            values = [
                _texts(name, column[piece].tolist()) for name, column in zip(names, columns, strict=True)
            ]
            file.writelines(",".join(row) + "\r\n" for row in zip(*values, strict=True))


def _texts(name: str, values: list) -> list[str]:
    if name == "kind":
        return [EVENT_NAMES.get(code, str(code)) for code in values]
    return [repr(value) for value in values]

"""A tidy table as CSV (RFC 4180): one line of column names, then one line per row, SI units or the axis's.

Numbers are written so that they read back as the same double, codes as words; what is not known is empty.
"""

import csv
from pathlib import Path
from typing import Any

from vibsim.files.output_file import output_file
from vibsim.labelled.tidy import Tidy

PIECE = 16384  # rows


def write_table(table: Tidy, path: str | Path, force: bool = False) -> None:
    """Write a table to `path`, in pieces.

    Raises ResultFileError when `path` exists and `force` is not given, or cannot be written.
    """
    with output_file(path, force, "utf-8") as file:
        lines = csv.writer(file)
        lines.writerow(table.columns)
        for rows in table.pieces(PIECE):
            columns = [list(map(_text, table.told(name, rows).tolist())) for name in table.columns]
            lines.writerows(zip(*columns, strict=True))


def _text(value: Any) -> str:
    if value is None or value != value:
        return ""
    return value if isinstance(value, str) else repr(value)

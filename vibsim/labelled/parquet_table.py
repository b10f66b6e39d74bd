"""A tidy table as Parquet: units and meanings in the metadata of the columns, codes as dictionaries."""

import json
from pathlib import Path
from typing import Any

from vibsim.files.output_file import output_file
from vibsim.files.plain_data import plain
from vibsim.labelled.extras import extra
from vibsim.labelled.tidy import Tidy


def write_parquet(table: Tidy, path: str | Path, force: bool = False, rows: slice = slice(None)) -> None:
    """Write a table, or some of its rows, to `path`; root attributes as JSON under the key `vibsim`.

    Raises MissingExtra without pyarrow, and ResultFileError when `path` exists and `force` is not given, or
    cannot be written.
    """
    arrow, parquet = extra("pyarrow", "parquet"), extra("pyarrow.parquet", "parquet")
    arrays = {name: _array(arrow, table, name, rows) for name in table.columns}
    fields = [
        arrow.field(name, array.type, metadata=_described(table, name)) for name, array in arrays.items()
    ]
    about = {"vibsim": json.dumps(plain(table.arrays.attrs))}
    with output_file(path, force) as file:
        parquet.write_table(arrow.table(list(arrays.values()), arrow.schema(fields, metadata=about)), file)


def _array(arrow: Any, table: Tidy, name: str, rows: slice) -> Any:
    column, values = table.columns[name], table.told(name, rows)
    if column.flags:
        return arrow.array(values, arrow.string()).dictionary_encode()
    if column.dtype == "text":
        return arrow.array(values.tolist(), arrow.string())
    return arrow.array(values)


def _described(table: Tidy, name: str) -> dict[str, str]:
    column = table.columns[name]
    return {"long_name": column.long_name, **({"units": column.units} if column.units else {})}

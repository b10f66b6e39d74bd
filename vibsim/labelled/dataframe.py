"""Arrays as a pandas DataFrame: one row per point, codes as words."""

from typing import Any

from vibsim.labelled.arrays import Arrays
from vibsim.labelled.extras import extra
from vibsim.labelled.tidy import Tidy


def dataframe_of(arrays: Arrays, along: str = "") -> Any:
    """The DataFrame, its index the coordinates of the rows; units by column in `attrs["units"]`.

    along : as of `Tidy`

    Raises MissingExtra without pandas, and ValueError for a dimension that there is not.
    """
    pandas = extra("pandas", "pandas")
    table = Tidy(arrays, along)
    frame = pandas.DataFrame({name: _series(pandas, table, name) for name in table.columns}, copy=False)
    frame.attrs["units"] = {name: column.units for name, column in table.columns.items() if column.units}
    scales = [name for name in table.dims if name in table.columns]
    return frame if arrays.numbered or not scales else frame.set_index(scales)


def _series(pandas: Any, table: Tidy, name: str) -> Any:
    column = table.columns[name]
    if not column.flags:
        return table.values(name)
    return pandas.Categorical(table.told(name), categories=list(column.flags))

"""Base of every kind of result: shows itself, and becomes an xarray Dataset or a pandas DataFrame."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases.problems import counted, one_line
from vibsim.lazy import FRONT, named
from vibsim.results.file_contents import Column, Dataset
from vibsim.results.hdf5_reading import plain
from vibsim.results.output_files import output_file

# Arrays with names, units and dimensions, as they stand in a result file.


@dataclass(frozen=True)
class Arrays:
    """Arrays that share dimensions.

    Attributes
    ----------
    declared : what each array is: name, unit, meaning, dimensions. The array that has the name of its only
        dimension is the coordinate along it
    read : an array by its name, shaped as its dimensions say
    attrs : where the arrays come from
    rows : dimensions of one row of a table, such as ("omega0", "c", "direction") of a sweep. Arrays with one
        further dimension make tables of their own, with a row for each position along it too
    numbered : whether rows are told apart by their number rather than by their coordinates
    shown : columns to look at first: one along the axis, and two over it
    """

    declared: tuple[Dataset, ...]
    read: Callable[[str], np.ndarray]
    rows: tuple[str, ...]
    attrs: Mapping[str, Any] = field(default_factory=dict)
    numbered: bool = False
    shown: tuple[str, ...] = ()

    @classmethod
    def of_values(
        cls,
        declared: Sequence[Dataset],
        values: Mapping[str, Any],
        rows: tuple[str, ...],
        attrs: Mapping[str, Any],
        shown: tuple[str, ...],
    ) -> "Arrays":
        """Arrays whose values are at hand by name, each shaped by the lengths of its coordinates."""
        lengths = {dataset.name: len(values[dataset.name]) for dataset in declared if dataset.is_scale}
        dims = {dataset.name: dataset.dims for dataset in declared}

        def read(name: str) -> np.ndarray:
            return np.reshape(np.asarray(values[name]), [lengths[each] for each in dims[name]])

        return cls(tuple(declared), read, rows, attrs, shown=shown)

    @cached_property
    def datasets(self) -> dict[str, Dataset]:
        """Dataset of each array, by its name (without the group in which it stands on file)."""
        return {dataset.name.rpartition("/")[2]: dataset for dataset in self.declared}

    @cached_property
    def lengths(self) -> dict[str, int]:
        """Length of every dimension."""
        lengths: dict[str, int] = {}
        for name, dataset in self.datasets.items():
            if not set(dataset.dims) <= set(lengths):
                lengths |= dict(zip(dataset.dims, np.shape(self.read(name)), strict=True))
        return lengths

    @property
    def further(self) -> tuple[str, ...]:
        """Dimensions that only some arrays have: each makes a table of its own."""
        dims = (dimension for dataset in self.declared for dimension in dataset.dims)
        return tuple(name for name in dict.fromkeys(dims) if name not in self.rows)

    def column(self, name: str) -> Column:
        """Unit and meaning of an array."""
        return self.datasets[name].column


# What is shown of an object that is looked at: a heading and a few telling lines, in notebooks too.


LABEL_WIDTH = 16


class Shown:
    """An object that says two things of itself, `heading()` and `lines()`; what is shown of it follows."""

    def heading(self) -> str:
        """Heading of the result, in a line."""
        raise NotImplementedError

    def lines(self) -> list[tuple[str, str]]:
        """The few things that tell most about it: label and text."""
        raise NotImplementedError

    def __repr__(self) -> str:
        lines = [f"  {label:{LABEL_WIDTH}}{text}" for label, text in self.lines()]
        return "\n".join([f"<{type(self).__name__} {self.heading()}>", *lines])

    def _repr_html_(self) -> str:

        return html_of(f"{type(self).__name__} {self.heading()}", self.lines())


LISTED = 10  # names of columns that are listed


def few(names: Iterable[str]) -> str:
    """The first names, and how many more there are."""
    first = list(names)
    more = len(first) - LISTED
    return ", ".join(first[:LISTED]) + (f" and {more} more" if more > 0 else "")


class Labelled(Shown):
    """A result made of labelled arrays.

    A kind of result says three things: `arrays()`, `heading()` and `lines()`; the rest follows.

    >>> import vibsim
    >>> isinstance(vibsim.simulate("I-A", overrides={"run.t_end": "2 s"}), vibsim.Labelled)
    True
    """

    def arrays(self) -> Arrays:
        """Its arrays, with dimensions, units and attributes."""
        raise NotImplementedError

    def to_xarray(self) -> Any:
        """The result as an xarray Dataset: dimensions, coordinates, units and attributes as in the file.

        Raises MissingExtra (an ImportError) where xarray is not installed.

        >>> import vibsim
        >>> result = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "2 s"}))
        >>> data = result.to_xarray()
        >>> data["x1"].dims, data["x1"].attrs["units"]
        (('time',), 'm')
        """

        return dataset_of(self.arrays())

    def to_dataframe(self, along: str = "") -> Any:
        """The result as a pandas DataFrame, one row per point, codes as words; units in `attrs["units"]`.

        along : name of a dimension that only some arrays have, such as "section" of a sweep: the table holds
            these, with a row for each position along it

        Raises MissingExtra (an ImportError) where pandas is not installed, and ValueError for a dimension
        that there is not.

        >>> import vibsim
        >>> case = vibsim.load_case("II-B", {"run.t_end": "2 s"})
        >>> sweep = vibsim.sweep(case, {"c": [0.01, 0.02]}, section=3, jobs=1)
        >>> list(sweep.to_dataframe().index.names)
        ['c', 'direction']
        >>> len(sweep.to_dataframe("section"))
        6
        """

        return dataframe_of(self.arrays(), along)

    def plot(self, kind: str | None = None, **how: Any) -> Any:
        """Draw the result and return the matplotlib axes: those of its one panel, or a list of several.

        Everything that `vibsim.plot` takes, by name: `ax`, `window`, `detail`, `style`, `size` and so on.

        >>> import vibsim
        >>> result = vibsim.simulate(vibsim.load_case("II-B", {"run.t_end": "2 s"}))
        >>> axes = result.plot(kind="relative", window=(1, 2))
        >>> axes.get_xlabel()
        'Relative displacement $x_1 - x_2$ (µm)'
        """
        return named(FRONT["plot"])(self, kind, **how)

    def _repr_html_(self) -> str:

        return html_of(f"{type(self).__name__} {self.heading()}", self.lines(), self.arrays())


# Arrays over several dimensions as a tidy table: one row per point, coordinates in columns.


@dataclass(frozen=True)
class Tidy:
    """A table of all arrays whose dimensions are those of a row; or of those with one dimension more.

    Attributes
    ----------
    arrays : what the table is made of
    along : a dimension that only some arrays have, such as "section": the table holds these, with a row for
        each position along it, at each point where they have points too; empty: the others, with a row per
        point

    Raises ValueError for a dimension that there is not.
    """

    arrays: Arrays
    along: str = ""

    def __post_init__(self) -> None:
        if self.along and self.along not in self.arrays.further:
            listed = ", ".join(self.arrays.further) or "none"
            advice = (
                "; events are a table apart: result.events.to_dataframe()" if self.along == "events" else ""
            )
            raise ValueError(f"no further dimension is called {self.along!r}; there are: {listed}{advice}")

    @cached_property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of a row."""
        rows = self.arrays.rows
        if not self.along:
            return rows
        of_points = any({*rows, self.along} <= set(each.dims) for each in self.arrays.datasets.values())
        return (*rows, self.along) if of_points else (self.along,)

    @cached_property
    def columns(self) -> dict[str, Column]:
        """Coordinates first, then the arrays; by name."""
        scales = {name: self.arrays.column(name) for name in self.dims if name in self.arrays.datasets}
        others = {name: each for name, each in self.arrays.datasets.items() if not each.is_scale}
        return scales | {name: each.column for name, each in others.items() if self._has(each.dims)}

    def _has(self, dims: tuple[str, ...]) -> bool:
        return set(dims) <= set(self.dims) and (not self.along or self.along in dims)

    @property
    def count(self) -> int:
        """Number of rows."""
        return prod(self.arrays.lengths[name] for name in self.dims)

    def values(self, name: str, rows: slice = slice(None)) -> np.ndarray:
        """A column (n), or some of its rows."""
        dims, shape = self.arrays.datasets[name].dims, self._shape
        array = np.asarray(self.arrays.read(name))
        if dims == self.dims:
            return array.reshape(-1)[rows]
        places = np.unravel_index(np.arange(self.count)[rows], shape)
        return array[tuple(places[self.dims.index(dimension)] for dimension in dims)]

    def told(self, name: str, rows: slice = slice(None)) -> np.ndarray:
        """The same, codes as words (None for a code without one)."""
        column, values = self.columns[name], self.values(name, rows)
        return words_of(column, values) if column.flags else values

    def pieces(self, length: int) -> Iterator[slice]:
        """The rows in pieces of at most `length`."""
        for begin in range(0, self.count, length):
            yield slice(begin, min(begin + length, self.count))

    @property
    def _shape(self) -> tuple[int, ...]:
        return tuple(self.arrays.lengths[name] for name in self.dims)


# A tidy table as CSV (RFC 4180): one line of column names, then one line per row, SI units or the axis's.
#
# Numbers are written so that they read back as the same double, codes as words; what is not known is empty.


PIECE = 16384  # rows


def write_table(table: Tidy, path: str | Path, force: bool = False) -> None:
    """Write a table to `path`, in pieces.

    Raises ResultFileError when `path` exists and `force` is not given, or cannot be written.
    """
    import csv

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


# Arrays as a pandas DataFrame: one row per point, codes as words.


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


# A tidy table as Parquet: units and meanings in the metadata of the columns, codes as dictionaries.


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


# Arrays as an xarray Dataset, the same as xarray reads from the file.


DECODED = ("missing_value",)  # attributes that xarray takes out when it reads a file


def dataset_of(arrays: Arrays) -> Any:
    """The Dataset: dimensions, coordinates, units and attributes as in the file.

    Raises MissingExtra without xarray.
    """
    xarray = extra("xarray", "xarray")
    variables = {name: _variable(xarray, arrays, name) for name in arrays.datasets}
    scales = [name for name, dataset in arrays.datasets.items() if dataset.is_scale]
    data = {name: variable for name, variable in variables.items() if name not in scales}
    attrs = {name: value for name, value in arrays.attrs.items() if value is not None}
    return xarray.Dataset(data, {name: variables[name] for name in scales}, attrs)


def _variable(xarray: Any, arrays: Arrays, name: str) -> Any:
    dataset = arrays.datasets[name]
    described = dataset.column.attributes().items()
    attrs = {key: value for key, value in described if value is not None and key not in DECODED}
    values = np.asarray(arrays.read(name))
    if dataset.column.dtype == "text":
        values = values.astype(str)
    return xarray.Variable(dataset.dims, values, attrs)


# What a notebook shows of a result: its telling lines, and its columns when they are opened.


CELL = 'style="text-align:left;padding:0 1em 0 0;vertical-align:top"'


def html_of(heading: str, lines: Iterable[tuple[str, str]], arrays: Arrays | None = None) -> str:
    """The heading, a table of the lines, and a folded one of the columns; colours are the page's own."""
    from html import escape

    rows = "".join(_row(label, text) for label, text in lines)
    columns = "" if arrays is None else _columns(arrays)
    return f"<div><b>{escape(heading)}</b><table>{rows}</table>{columns}</div>"


def _columns(arrays: Arrays) -> str:
    columns = "".join(_column(name, arrays) for name in arrays.datasets)
    head = "".join(f"<th {CELL}>{word}</th>" for word in ("name", "dimensions", "unit", "what it is"))
    return (
        f"<details><summary>{counted(len(arrays.datasets), 'column')}</summary>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{columns}</tbody></table></details>"
    )


def _row(label: str, text: str) -> str:
    from html import escape

    return f"<tr><td {CELL}>{escape(label)}</td><td {CELL}>{escape(text)}</td></tr>"


def _column(name: str, arrays: Arrays) -> str:
    from html import escape

    dataset = arrays.datasets[name]
    dims = ", ".join(dataset.dims)
    cells = (name, dims, _unit(dataset.column), dataset.column.long_name)
    return "<tr>" + "".join(f"<td {CELL}>{escape(cell)}</td>" for cell in cells) + "</tr>"


def _unit(column: Column) -> str:
    return ", ".join(column.flags) if column.flags else column.units or ""


# Codes as the words that they stand for.


def words_of(column: Column, codes: np.ndarray) -> np.ndarray:
    """The words of codes (an object array of their shape); None for a code without a word, such as NaN."""
    words = np.full(np.shape(codes), None, dtype=object)
    for word, code in column.flags.items():
        words[np.asarray(codes) == code] = word
    return words


# Packages that vibsim does without until something asks for them.


class MissingExtra(ImportError):
    """A package that is not installed; the message names the extra of vibsim that brings it.

    >>> import vibsim
    >>> try:
    ...     table = vibsim.simulate("I-A", overrides={"t_end": "1 s"}).to_dataframe()
    ... except vibsim.MissingExtra as missing:
    ...     print(missing)
    """


def extra(package: str, name: str) -> Any:
    """The package, imported. Raises MissingExtra that names the extra `name`, which brings it, or says why
    what is installed cannot be imported.
    """
    try:
        return import_module(package)
    except ImportError as error:
        missing = (error.name or "").partition(".")[0] == package.partition(".")[0]
        if missing and isinstance(error, ModuleNotFoundError):
            message = f"this needs {package}, which is not installed: pip install 'vibsim[{name}]'"
        else:  # what it needs itself is not there, or too old
            message = f"this needs {package}, which cannot be imported: {one_line(str(error))}"
        raise MissingExtra(message) from None

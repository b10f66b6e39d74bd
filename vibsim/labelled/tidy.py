"""Arrays over several dimensions as a tidy table: one row per point, coordinates in columns."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import prod

import numpy as np

from vibsim.files.declarations import Column
from vibsim.labelled.arrays import Arrays
from vibsim.labelled.words import words_of


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

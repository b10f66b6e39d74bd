"""Arrays with names, units and dimensions, as they stand in a result file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from vibsim.files.declarations import Column, Dataset


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
        """What each array is, by its name (without the group in which it stands on file)."""
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

"""Decimal texts written to an HDF5 group in batches: fixed-length ASCII strings along a dimension scale."""

from collections.abc import Mapping
from typing import Any

import h5py
import numpy as np

from vibsim.files.attributes import write_attrs
from vibsim.files.declarations import Column

CHUNK = 1024  # rows that HDF5 reads at a time
ROWS = "event"  # scale of a table that has no other: its rows counted
COUNTER = Column(None, "row of the table of events", dtype="i4")


class DigitsStream:
    """Columns of texts of one group, filled by `append`.

    Parameters
    ----------
    group : h5py group; columns : what they mean, by name; width : characters of a text
    batch : rows written at a time, a multiple of CHUNK
    scale : scale of the rows; None: the rows are counted in a scale of this group
    """

    def __init__(
        self, group: h5py.Group, columns: Mapping[str, Column], width: int, batch: int, scale: Any = None
    ):
        self.batch, self.width = batch, width
        self.rows = self.waiting = 0
        self._parts: list[Mapping[str, np.ndarray]] = []
        self._counter = _create(group, ROWS, COUNTER, "i4") if scale is None else None
        if self._counter is not None:
            self._counter.make_scale(ROWS)
        self._datasets = {name: _create(group, name, column, f"S{width}") for name, column in columns.items()}
        for dataset in self._datasets.values():
            dataset.dims[0].attach_scale(scale if scale is not None else self._counter)

    def append(self, rows: Mapping[str, np.ndarray]) -> None:
        """Take rows (name -> 1-D array of bytes, all of one length); they wait in memory until `write`."""
        self._parts.append(rows)
        self.waiting += len(next(iter(rows.values())))

    def waiting_bytes(self, more: int = 0) -> int:
        """Room on file that the rows in memory, and so many `more`, take at most [bytes]."""
        return (self.waiting + more) * self.width * len(self._datasets)

    def write(self, everything: bool = False) -> None:
        """Write the whole batches that wait; with `everything` also the rest, which goes on to wait."""
        whole = self.waiting - self.waiting % self.batch
        count = self.waiting if everything else whole
        if count == 0:
            return
        rest: dict[str, np.ndarray] = {}
        reached = self.rows + count
        for name, dataset in self._datasets.items():
            values = np.concatenate([part[name] for part in self._parts])
            dataset.resize((reached,))
            dataset[self.rows :] = values[:count]
            rest[name] = values[whole:].copy()
        if self._counter is not None:
            self._counter.resize((reached,))
            self._counter[self.rows :] = np.arange(self.rows, reached, dtype="i4")
        self.rows += whole
        self.waiting -= whole
        self._parts = [rest]


def _create(group: Any, name: str, column: Column, dtype: str) -> h5py.Dataset:
    dataset = group.create_dataset(
        name, (0,), dtype, maxshape=(None,), chunks=(CHUNK,), compression=1, shuffle=True, fletcher32=True
    )
    write_attrs(dataset.id, column.attributes())
    return dataset

"""A table of columns of unknown length, written to an HDF5 group in whole chunks.

As a rule only whole chunks are written before the end: HDF5 then never moves a chunk, so the file is dense.
The rest of a table that grows slowly can be written too; it is written again when its chunk is full. h5py's
low-level interface makes twenty columns in 3 ms instead of 30.
"""

from collections.abc import Mapping
from math import ceil
from typing import Any

import numpy as np
from h5py import h5d, h5ds, h5p, h5s, h5t

from vibsim.files.attributes import write_attrs
from vibsim.files.chunk_encoding import LEAST_NOISE, encoded
from vibsim.files.declarations import Column

FILE_TYPES = {"f8": ("<f8", h5t.IEEE_F64LE), "i1": ("i1", h5t.STD_I8LE), "i2": ("<i2", h5t.STD_I16LE)}


class DatasetStream:
    """Columns of one HDF5 group along one dimension scale (the first column), filled by `append`.

    group : low-level id of the group; columns : by name; chunk : rows per chunk
    """

    def __init__(self, group: Any, columns: Mapping[str, Column], chunk: int):
        self.chunk = chunk
        self.rows = 0  # rows on file in whole chunks
        self.waiting = 0  # rows in memory
        self._parts: list[Mapping[str, np.ndarray]] = []
        self._columns = columns
        self._datasets = {name: _create(group, name, column, chunk) for name, column in columns.items()}
        self._row_bytes = sum(np.dtype(column.dtype).itemsize for column in columns.values())
        first, *others = self._datasets
        h5ds.set_scale(self._datasets[first], first.encode())
        for name in others:
            h5ds.attach_scale(self._datasets[name], self._datasets[first], 0)

    def append(self, rows: Mapping[str, np.ndarray]) -> None:
        """Take rows (name -> 1-D array, all of one length); they wait in memory until `write`."""
        self._parts.append(rows)
        self.waiting += len(next(iter(rows.values())))

    def waiting_bytes(self, more: int = 0) -> int:
        """Room on file that the rows in memory, and so many `more`, take at most [bytes].

        Up to some 2000 rows the unused end of a chunk is compressed away; beyond, it may be stored as it is.
        """
        rows = self.waiting + more
        return self._row_bytes * (rows if rows < LEAST_NOISE else self.chunk * ceil(rows / self.chunk))

    def write(self, everything: bool = False) -> None:
        """Write the whole chunks that wait; with `everything` also the rest, which goes on to wait."""
        whole = self.waiting - self.waiting % self.chunk
        count = self.waiting if everything else whole
        if count == 0:
            return
        rest: dict[str, np.ndarray] = {}
        for name, dataset in self._datasets.items():
            values = np.concatenate([part[name] for part in self._parts])
            stored = FILE_TYPES[self._columns[name].dtype][0]
            self._write_column(dataset, values[:count].astype(stored, copy=False))
            rest[name] = values[whole:].copy()
        self.rows += whole
        self.waiting -= whole
        self._parts = [rest]

    def _write_column(self, dataset: Any, values: np.ndarray) -> None:
        dataset.set_extent((self.rows + len(values),))
        for start in range(0, len(values), self.chunk):
            piece = values[start : start + self.chunk]
            if len(piece) < self.chunk:
                piece = np.concatenate([piece, np.zeros(self.chunk - len(piece), piece.dtype)])
            dataset.write_direct_chunk((self.rows + start,), encoded(piece))


def _create(group: Any, name: str, column: Column, chunk: int) -> Any:
    filters = h5p.create(h5p.DATASET_CREATE)
    filters.set_chunk((chunk,))
    filters.set_shuffle()
    filters.set_deflate(1)
    filters.set_fletcher32()
    space = h5s.create_simple((0,), (h5s.UNLIMITED,))
    dataset = h5d.create(group, name.encode(), FILE_TYPES[column.dtype][1], space, filters)
    write_attrs(dataset, column.attributes())
    return dataset

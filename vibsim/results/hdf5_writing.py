"""HDF5 files that are written whole, made in memory, and tables that grow while they are computed.

A write that fails inside HDF5 leaves a file that it insists on closing, and an error in words of its own: a
file that is made in memory meets a full disk in one plain write.
"""

import zlib
from collections.abc import Iterable, Mapping
from itertools import groupby
from math import ceil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5d, h5ds, h5p, h5s, h5t

from vibsim.results.file_contents import Column, Dataset
from vibsim.results.hdf5_reading import write_attrs
from vibsim.results.output_files import output_file

# Opens in every HDF5 since 1.10, h5netcdf and netCDF4; 'earliest' keeps a file that grows readable after a
# kill: the newer formats mark an open file and refuse it later.
LIBVER = ("earliest", "v110")
STEP = 1 << 20  # bytes by which the image grows
FOR_INDEX = 2048  # bytes that the index of a compressed dataset takes: a short scale is smaller as it is
COMPRESSED = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}


def write_hdf5(
    path: Path, attrs: Mapping[str, Any], declared: Iterable[Dataset], values: Mapping[str, Any]
) -> None:
    """Write a file of these root attributes and datasets to `path`, replacing what is there in one instant.

    values : what stands in each dataset, by name; its shape is told by the scales
    Raises ResultFileError where it cannot be written; then what was there is still there.
    """
    options = {"driver": "core", "backing_store": False, "block_size": STEP}
    with h5py.File(path.name, "w", libver=LIBVER, **options) as file:
        write_attrs(file.id, attrs)
        write_datasets(file, declared, values)
        file.flush()
        image = file.id.get_file_image()
    with output_file(path, force=True) as file:
        file.write(image)


def write_datasets(file: h5py.File, declared: Iterable[Dataset], values: Mapping[str, Any]) -> None:
    """Write datasets to an open file: scales first, then what is attached to them."""
    scales: dict[str, h5py.Dataset] = {}
    for dataset in sorted(declared, key=lambda each: not each.is_scale):
        if dataset.is_scale:
            scales[dataset.name] = _written(file, dataset, values[dataset.name])
            h5ds.set_scale(scales[dataset.name].id, dataset.dims[0].encode())
            continue
        group = dataset.name.rpartition("/")[0]
        own = [scales[f"{group}/{name}" if group else name] for name in dataset.dims]
        item = _written(file, dataset, np.reshape(values[dataset.name], [len(scale) for scale in own]))
        for dimension, scale in enumerate(own):
            h5ds.attach_scale(item.id, scale.id, dimension)


def _written(file: h5py.File, dataset: Dataset, values: Any) -> h5py.Dataset:
    text = dataset.column.dtype == "text"
    array = np.asarray(values, object if text else dataset.column.dtype)
    plain = array.size == 0 or (dataset.is_scale and array.nbytes <= FOR_INDEX)
    options = {"dtype": h5py.string_dtype()} if text else {} if plain else COMPRESSED
    item = file.create_dataset(dataset.name, data=array, **options)
    write_attrs(item.id, dataset.column.attributes())
    return item


# Tables of unknown length, written to an HDF5 group while they grow.
#
# As a rule only whole batches are written before the end: HDF5 then never moves a chunk, so the file is
# dense. The rest of a table that grows slowly can be written too; it is written again when its batch is full.


class Stream:
    """Columns of one HDF5 group, filled by `append`.

    datasets : by name; batch : rows written at a time
    """

    def __init__(self, datasets: Mapping[str, Any], batch: int):
        self.batch = batch
        self.rows = 0  # rows on file in whole batches
        self.waiting = 0  # rows in memory
        self._datasets = datasets
        self._parts: list[Mapping[str, np.ndarray]] = []

    def append(self, rows: Mapping[str, np.ndarray]) -> None:
        """Take rows (name -> 1-D array, all of one length); they wait in memory until `write`."""
        self._parts.append(rows)
        self.waiting += len(next(iter(rows.values())))

    def write(self, everything: bool = False) -> None:
        """Write the whole batches that wait; with `everything` also the rest, which goes on to wait."""
        whole = self.waiting - self.waiting % self.batch
        count = self.waiting if everything else whole
        if count == 0:
            return
        rest: dict[str, np.ndarray] = {}
        for name, dataset in self._datasets.items():
            values = np.concatenate([part[name] for part in self._parts])
            self._write_column(name, dataset, values[:count])
            rest[name] = values[whole:].copy()
        self._write_counter(self.rows + count)
        self.rows += whole
        self.waiting -= whole
        self._parts = [rest]

    def waiting_bytes(self, more: int = 0) -> int:
        """Room on file that the rows in memory, and so many `more`, take at most [bytes]."""
        raise NotImplementedError

    def _write_column(self, name: str, dataset: Any, values: np.ndarray) -> None:
        """Write values of a column behind the rows that are on file."""
        raise NotImplementedError

    def _write_counter(self, count: int) -> None:
        """Write the numbers of the rows, where no column is their scale."""


FILE_TYPES = {"f8": ("<f8", h5t.IEEE_F64LE), "i1": ("i1", h5t.STD_I8LE), "i2": ("<i2", h5t.STD_I16LE)}


class DatasetStream(Stream):
    """Numbers along one dimension scale, the first column, through h5py's low-level interface, which makes
    twenty columns in 3 ms instead of 30.

    group : low-level id of the group; columns : by name; chunk : rows per chunk
    """

    def __init__(self, group: Any, columns: Mapping[str, Column], chunk: int):
        made = {name: _create_dataset(group, name, column, chunk) for name, column in columns.items()}
        super().__init__(made, chunk)
        self._columns = columns
        self._row_bytes = sum(np.dtype(column.dtype).itemsize for column in columns.values())
        first, *others = made
        h5ds.set_scale(made[first], first.encode())
        for name in others:
            h5ds.attach_scale(made[name], made[first], 0)

    def waiting_bytes(self, more: int = 0) -> int:
        """As above. Up to some 2000 rows the unused end of a chunk is compressed away; beyond, it may be
        stored as it is.
        """
        rows = self.waiting + more
        return self._row_bytes * (rows if rows < LEAST_NOISE else self.batch * ceil(rows / self.batch))

    def _write_column(self, name: str, dataset: Any, values: np.ndarray) -> None:
        values = values.astype(FILE_TYPES[self._columns[name].dtype][0], copy=False)
        dataset.set_extent((self.rows + len(values),))
        for start in range(0, len(values), self.batch):
            piece = values[start : start + self.batch]
            if len(piece) < self.batch:
                piece = np.concatenate([piece, np.zeros(self.batch - len(piece), piece.dtype)])
            dataset.write_direct_chunk((self.rows + start,), encoded(piece))


def _create_dataset(group: Any, name: str, column: Column, chunk: int) -> Any:
    filters = h5p.create(h5p.DATASET_CREATE)
    filters.set_chunk((chunk,))
    filters.set_shuffle()
    filters.set_deflate(1)
    filters.set_fletcher32()
    space = h5s.create_simple((0,), (h5s.UNLIMITED,))
    dataset = h5d.create(group, name.encode(), FILE_TYPES[column.dtype][1], space, filters)
    write_attrs(dataset, column.attributes())
    return dataset


# One chunk of a column as HDF5 stores it: shuffle, gzip 1, fletcher32, in that order.
#
# HDF5 has the same filters and reads with them what is written here. Here the low mantissa bytes of a
# trajectory, which are noise and cost gzip most of its time, are recognised and stored as they are: three
# times as fast, for some 15 % more bytes on disk.


ZLIB_HEADER = b"\x78\x01"  # deflate, 32 kB window, fastest
LAST_BLOCK = b"\x03\x00"  # an empty one that ends a deflate stream
SAMPLED = 8  # every eighth byte is looked at to tell noise
ROW = 512  # words that a checksum sums at a time: eight times as fast as word by word
COLUMN = np.arange(ROW, dtype="u8")
NOISE = 0.94  # noise takes this part of the 256 values or more: 2048 random bytes take 0.9997 of them

LEAST_NOISE = int(NOISE * 256 * SAMPLED)  # values in a chunk, below which none of it can be taken for noise


def encoded(values: np.ndarray) -> bytes:
    """Bytes of a whole chunk (1-D array, little endian) after the three filters."""
    deflated = _deflated(_byte_planes(values))
    return deflated + fletcher32(deflated).to_bytes(4, "little")


def _byte_planes(values: np.ndarray) -> np.ndarray:
    """The shuffle filter: all first bytes, then all second bytes, ... (shape bytes per value x values)."""
    return np.ascontiguousarray(values.view("u1").reshape(len(values), values.itemsize).T)


def _deflated(planes: np.ndarray) -> bytes:
    """A zlib stream of the planes, compressed or stored plane by plane (RFC 1950, RFC 1951)."""
    stream = [ZLIB_HEADER]
    for noise, group in groupby(planes, key=_is_noise):
        part = zlib.compressobj(0 if noise else 1, zlib.DEFLATED, -zlib.MAX_WBITS)
        stream += [part.compress(plane) for plane in group]
        stream.append(part.flush(zlib.Z_FULL_FLUSH))
    return b"".join([*stream, LAST_BLOCK, zlib.adler32(planes.data).to_bytes(4, "big")])


def _is_noise(plane: np.ndarray) -> bool:
    counts = np.bincount(plane[::SAMPLED], minlength=256)
    return int(np.count_nonzero(counts)) >= NOISE * 256


def fletcher32(data: bytes) -> int:
    """Fletcher's checksum over big-endian 16-bit words as HDF5 has it: sums modulo 65535, in 1 to 65535."""
    count = (len(data) + 1) // 2
    rows = np.frombuffer(data + bytes(-len(data) % (2 * ROW)), ">u2").reshape(-1, ROW)
    by_row, by_column = rows.sum(axis=1, dtype="u8"), rows.sum(axis=0, dtype="u8")
    sum1 = int(by_row.sum())
    # word i, in row r and column c, counts count - i times; i = ROW r + c
    places = ROW * int(by_row @ np.arange(len(rows), dtype="u8")) + int(by_column @ COLUMN)
    return _folded(count * sum1 - places) << 16 | _folded(sum1)


def _folded(total: int) -> int:
    return (total - 1) % 65535 + 1 if total else 0


# Decimal texts: fixed-length ASCII strings.


CHUNK = 1024  # rows that HDF5 reads at a time
ROWS = "event"  # scale of a table that has no other: its rows counted
COUNTER = Column(None, "row of the table of events", dtype="i4")


class DigitsStream(Stream):
    """Texts along a dimension scale.

    Parameters
    ----------
    group : h5py group; columns : what they mean, by name; width : characters of a text
    batch : rows written at a time, a multiple of CHUNK
    scale : scale of the rows; None: the rows are counted in a scale of this group
    """

    def __init__(
        self, group: h5py.Group, columns: Mapping[str, Column], width: int, batch: int, scale: Any = None
    ):
        self.width = width
        self._counter = _create_digits(group, ROWS, COUNTER, "i4") if scale is None else None
        if self._counter is not None:
            self._counter.make_scale(ROWS)
        made = {name: _create_digits(group, name, column, f"S{width}") for name, column in columns.items()}
        for dataset in made.values():
            dataset.dims[0].attach_scale(scale if scale is not None else self._counter)
        super().__init__(made, batch)

    def waiting_bytes(self, more: int = 0) -> int:
        """As above."""
        return (self.waiting + more) * self.width * len(self._datasets)

    def _write_column(self, name: str, dataset: Any, values: np.ndarray) -> None:
        dataset.resize((self.rows + len(values),))
        dataset[self.rows :] = values

    def _write_counter(self, count: int) -> None:
        if self._counter is not None:
            self._counter.resize((count,))
            self._counter[self.rows :] = np.arange(self.rows, count, dtype="i4")


def _create_digits(group: Any, name: str, column: Column, dtype: str) -> h5py.Dataset:
    dataset = group.create_dataset(
        name, (0,), dtype, maxshape=(None,), chunks=(CHUNK,), compression=1, shuffle=True, fletcher32=True
    )
    write_attrs(dataset.id, column.attributes())
    return dataset

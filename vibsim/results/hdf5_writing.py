"""HDF5 files that are written whole: made in memory, so that a full disk fails in one plain write.

A write that fails inside HDF5 leaves a file that it insists on closing, and an error in words of its own.
"""

import errno
import os
import re
import shutil
import socket
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import groupby
from math import ceil
from pathlib import Path
from secrets import token_hex
from typing import IO, Any

import h5py
import numpy as np
from h5py import h5d, h5ds, h5p, h5s, h5t

from vibsim.results.file_contents import Column, Dataset
from vibsim.results.hdf5_reading import ResultFileError, read_attr, reason, write_attrs
from vibsim.signals import ended_at_once, held_back

LIBVER = ("earliest", "v110")  # opens in every HDF5 since 1.10, h5netcdf and netCDF4
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
    for dataset in sorted(declared, key=lambda each: not each.is_scale):
        group = dataset.name.rpartition("/")[0]
        if dataset.is_scale:
            _written(file, dataset, values[dataset.name]).make_scale(dataset.dims[0])
            continue
        scales = [file[f"{group}/{name}"] for name in dataset.dims]
        item = _written(file, dataset, np.reshape(values[dataset.name], [len(scale) for scale in scales]))
        for dimension, scale in zip(item.dims, scales, strict=True):
            dimension.attach_scale(scale)


def _written(file: h5py.File, dataset: Dataset, values: Any) -> h5py.Dataset:
    text = dataset.column.dtype == "text"
    array = np.asarray(values, object if text else dataset.column.dtype)
    plain = array.size == 0 or (dataset.is_scale and array.nbytes <= FOR_INDEX)
    options = {"dtype": h5py.string_dtype()} if text else {} if plain else COMPRESSED
    item = file.create_dataset(dataset.name, data=array, **options)
    write_attrs(item.id, dataset.column.attributes())
    return item


# Output that appears whole or not at all: written beside its target, then renamed.
#
# For every kind of output file: an existing one stays as it is unless `force`.


RESULT_SUFFIXES = (".h5", ".hdf5")


def check_result_name(path: str | Path) -> None:
    """Raises ResultFileError for a file name whose suffix promises another format than that of results."""
    suffix = Path(path).suffix
    if suffix.lower() not in RESULT_SUFFIXES:
        suffix_text = f"suffix {suffix}" if suffix else "no suffix"
        exported = "; for CSV or MAT: vibsim export" if suffix.lower() in (".csv", ".mat") else ""
        raise ResultFileError(f"{path}: {suffix_text}; results are HDF5 files, .h5 or .hdf5{exported}")


def check_result_output(path: str | Path, force: bool = False) -> Path:
    """As `check_output`, for a file of results. Raises ResultFileError, also for its suffix."""
    check_result_name(path)
    return check_output(path, force)


def check_output(path: str | Path, force: bool = False) -> Path:
    """Absolute path of an output file that may be written (links followed).

    Raises ResultFileError when it, or a part of a run beside it, exists and `force` is not given, when it is
    not a regular file or being written, or when its folder is missing or not writable.
    """
    try:
        target = Path(path).absolute().resolve()
        if target.exists():
            _check_existing(path, target, force)
        check_leftover(path, force)  # fails where that name is too long
        folder = target.parent
        if not folder.is_dir():
            raise ResultFileError(f"{path}: cannot write: folder {folder} does not exist")
        if not os.access(folder, os.W_OK | os.X_OK, effective_ids=os.access in os.supports_effective_ids):
            raise ResultFileError(f"{path}: cannot write: folder {folder} is not writable")
    except (OSError, RuntimeError, ValueError) as error:
        raise ResultFileError(f"{path}: cannot write: {reason(error)}") from error
    return target


def _check_existing(path: str | Path, target: Path, force: bool) -> None:
    if target.is_dir():
        raise ResultFileError(f"{path}: cannot write: is a folder")
    if not target.is_file():
        raise ResultFileError(f"{path}: cannot write: is not a regular file")
    if not force:
        raise ResultFileError(f"{path}: exists; kept (force=True replaces it)")


def publish(partial: Path, target: Path, force: bool = False) -> None:
    """Make a finished partial file durable and give it its name: fsync, rename, fsync of the folder.

    Raises ResultFileError where that cannot be, or where another has come under that name and `force` is not
    given.
    """
    try:
        with held_back():
            _fsync(partial)
            if force or not _linked(partial, target):
                os.replace(partial, target)
            if os.name == "posix":
                _fsync(target.parent)
    except OSError as error:
        raise ResultFileError(f"{target}: cannot write: {reason(error)}") from error


def _linked(partial: Path, target: Path) -> bool:
    """Whether a partial file has got a name that nothing had.

    False on a disk without links, where nothing has it yet. Raises ResultFileError where something has.
    """
    try:
        os.link(partial, target)
    except OSError:
        if os.path.lexists(target):
            raise ResultFileError(f"{target}: appeared meanwhile; kept (force=True replaces it)") from None
        return False
    partial.unlink()
    return True


@contextmanager
def output_file(path: str | Path, force: bool = False, encoding: str | None = None) -> Iterator[IO[Any]]:
    """A file to write to, binary or of an encoding; published when the block ends, removed when it raises.

    Other programs may write to the path that is its `name`. Two writers of one output have two such files.
    """
    target = check_output(path, force)
    partial, file = target, None
    try:
        with held_back():
            descriptor, partial = open_partial(target)
            file = open(  # noqa: SIM115
                partial,
                "w+b" if encoding is None else "w+",
                encoding=encoding,
                newline=None if encoding is None else "",
                opener=lambda *_: descriptor,
            )
        yield file
        file.flush()
        if os.name != "posix":  # what is open cannot be renamed there
            file.close()
        publish(partial, target, force)
    except OSError as error:
        raise ResultFileError(f"{path}: cannot write: {reason(error)}") from error
    finally:
        if file is not None:
            with held_back(), suppress(OSError):
                partial.unlink(missing_ok=True)
            with held_back(), suppress(OSError):  # of a full disk, once more
                file.close()


def _fsync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


# A table of columns of unknown length, written to an HDF5 group in whole chunks.
#
# As a rule only whole chunks are written before the end: HDF5 then never moves a chunk, so the file is dense.
# The rest of a table that grows slowly can be written too; it is written again when its chunk is full. h5py's
# low-level interface makes twenty columns in 3 ms instead of 30.


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
        self._datasets = {
            name: _create_dataset(group, name, column, chunk) for name, column in columns.items()
        }
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


# Decimal texts written to an HDF5 group in batches: fixed-length ASCII strings along a dimension scale.


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
        self._counter = _create_digits(group, ROWS, COUNTER, "i4") if scale is None else None
        if self._counter is not None:
            self._counter.make_scale(ROWS)
        self._datasets = {
            name: _create_digits(group, name, column, f"S{width}") for name, column in columns.items()
        }
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


def _create_digits(group: Any, name: str, column: Column, dtype: str) -> h5py.Dataset:
    dataset = group.create_dataset(
        name, (0,), dtype, maxshape=(None,), chunks=(CHUNK,), compression=1, shuffle=True, fletcher32=True
    )
    write_attrs(dataset.id, column.attributes())
    return dataset


# Who writes an output, and what a writer that was killed has left beside it.
#
# What grows for long (a run, or the points that a journal keeps) is written by one process at a time, which
# holds NAME.lock. What is written in one go is first a file of a name of its own, NAME.xxxxxxxx.partial: of
# two who write one output at a time each publishes its own, whole. Neither needs the locks of HDF5, which
# many clusters switch off (HDF5_USE_FILE_LOCKING=FALSE).


try:
    import fcntl
except ImportError:  # Windows, where a file that is open cannot be removed
    fcntl = None  # type: ignore[assignment]

NO_LOCKS = {errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL}  # of disks that have none
TRIES = 100  # to make a file whose name others make and remove at the same time
ours: set[Path] = set()  # lock files that this process holds
OWNER_BYTES = 200  # of a lock file: process and machine of its owner


class Lock:
    """The right to write an output, held until `release`, and no longer than this process lives.

    Where the disk has flock, the system lets go of NAME.lock when its owner dies. Where it has none, that
    NAME.lock can be made by one process only is the lock; that of a dead process of this machine is removed.

    Raises ResultFileError where another writer has it, or where it cannot be made.
    """

    def __init__(self, target: Path, shown: str | Path):
        self.path = lock_path(target)
        self._descriptor = -1
        with held_back():
            try:
                self._descriptor = _acquired(self.path, shown)
            except OSError as error:
                raise ResultFileError(f"{shown}: cannot write: {reason(error)}") from error
            with suppress(OSError):  # on a full disk it names nobody, and locks all the same
                os.ftruncate(self._descriptor, 0)
                os.write(self._descriptor, f"{os.getpid()} {socket.gethostname()}\n".encode())
            ours.add(self.path)

    def release(self) -> None:
        """Let others write the output."""
        with held_back():
            if self._descriptor < 0:
                return
            ours.discard(self.path)
            if fcntl is None:
                os.close(self._descriptor)
            with suppress(OSError):
                self.path.unlink()
            if fcntl is not None:
                os.close(self._descriptor)
            self._descriptor = -1

    __del__ = release


def lock_path(target: Path) -> Path:
    """NAME.lock beside an output."""
    return target.with_name(target.name + ".lock")


def check_unlocked(target: Path, shown: str | Path) -> None:
    """Raise ResultFileError where another process has the lock of an output; remove that of a dead one."""
    path = lock_path(target)
    if path not in ours and path.exists():
        with suppress(OSError):
            descriptor = _acquired(path, shown)
            path.unlink(missing_ok=True)
            os.close(descriptor)


def _acquired(path: Path, shown: str | Path) -> int:
    """Descriptor of the lock file, locked. Raises ResultFileError where another has it, OSError."""
    for _ in range(TRIES):  # it may come and go meanwhile
        descriptor = _try_to_acquire(path, shown)
        if descriptor >= 0:
            return descriptor
    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))


def _try_to_acquire(path: Path, shown: str | Path) -> int:
    """As above; -1 where it came or went in between, or cannot be made."""
    try:
        if fcntl is None:
            path.unlink(missing_ok=True)
        made = not path.exists()
        descriptor = os.open(path, os.O_RDWR | (os.O_CREAT | os.O_EXCL if made else 0), 0o666)
    except (FileExistsError, FileNotFoundError):
        return -1
    except PermissionError:
        if fcntl is None:
            raise _refused(path, shown, "") from None
        raise
    try:
        held = _held(descriptor, path, shown, made)
    except BaseException:
        os.close(descriptor)
        raise
    if held:
        return descriptor
    os.close(descriptor)
    return -1


def _held(descriptor: int, path: Path, shown: str | Path, made: bool) -> bool:
    """Whether an open lock file is locked now, and still the one of its path.

    made : whether this process has made it. Raises ResultFileError where another has it.
    """
    if fcntl is None:
        return made
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise _refused(path, shown, _owner(descriptor)) from None
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
        owner = _owner(descriptor)
        if not made and not _is_dead(owner):
            raise _refused(path, shown, owner, f"; where it has ended, remove {path.name}") from None
        if not made and _is_at(descriptor, path):
            path.unlink()
        return made
    return _is_at(descriptor, path)


def _refused(path: Path, shown: str | Path, owner: str, remedy: str = "") -> ResultFileError:
    process, _, machine = owner.partition(" ")
    who = f" (process {process} on {machine})" if machine else ""
    return ResultFileError(f"{shown}: another command is writing it{who}{remedy}")


def _owner(descriptor: int) -> str:
    """What a lock file says of its owner: process and machine."""
    os.lseek(descriptor, 0, os.SEEK_SET)
    return os.read(descriptor, OWNER_BYTES).decode("utf-8", "replace").strip()


def _is_dead(owner: str) -> bool:
    """Whether the owner of a lock file is a process of this machine that has ended."""
    process, _, machine = owner.partition(" ")
    if machine != socket.gethostname() or not process.isdigit():
        return False
    try:
        os.kill(int(process), 0)
    except ProcessLookupError:
        return True
    except OSError:  # of another user
        pass
    return False


def _is_at(descriptor: int, path: Path) -> bool:
    """Whether an open file is the one that the path leads to."""
    try:
        return os.path.samestat(os.fstat(descriptor), os.stat(path))
    except FileNotFoundError:
        return False


def open_partial(target: Path, folder: bool = False) -> tuple[int, Path]:
    """A new file, or folder, beside an output, under a name of its own: its descriptor and its path.

    It is locked as long as it is open. Those that dead writers of the output have left are removed; where
    there is no flock nothing says which are, and they stay. Raises OSError. Signals are to be held back.
    """
    _remove_dead(target)
    for _ in range(TRIES):
        path = unique_path(target)
        try:
            if folder:
                path.mkdir()
            descriptor = os.open(path, os.O_RDONLY if folder else os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            continue
        if _locked(descriptor) is not False and _is_at(descriptor, path):
            return descriptor, path
        os.close(descriptor)  # taken for one that a dead writer has left, and removed
    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))


def unique_path(target: Path) -> Path:
    """NAME.xxxxxxxx.partial beside an output."""
    return target.with_name(f"{target.name}.{token_hex(4)}.partial")


def _remove_dead(target: Path) -> None:
    """Remove what dead writers of an output have left."""
    pattern = re.compile(re.escape(target.name) + r"\.[0-9a-f]{8}\.partial")
    left = []
    with suppress(OSError), os.scandir(target.parent) as entries:
        left = [Path(entry.path) for entry in entries if pattern.fullmatch(entry.name)]
    for path in left:
        with suppress(OSError):
            descriptor = os.open(path, os.O_RDONLY)
            try:
                if _locked(descriptor) and _is_at(descriptor, path):
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
            finally:
                os.close(descriptor)


def _locked(descriptor: int) -> bool | None:
    """Lock an open file: whether that went, None where there are no locks."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno in NO_LOCKS:
            return None
        raise
    return True


def partial_path(target: Path) -> Path:
    """Where a run is written before it is whole: NAME.partial beside the target."""
    return target.with_name(target.name + ".partial")


def check_leftover(path: str | Path, force: bool = False) -> None:
    """Raise ResultFileError where a run is being written to an output, or NAME.partial holds a part of one.

    `force` lets a part of a run be replaced. What holds nothing that can be read is in nobody's way.
    """
    target = Path(path).absolute().resolve()
    with suppress(FileNotFoundError, NotADirectoryError):
        os.lstat(unique_path(target))  # fails where that name is too long
    check_unlocked(target, path)
    partial = partial_path(target)
    reached = 0.0 if force or not partial.is_file() else held_until(partial)
    if reached > 0.0 and not (target.exists() and partial.samefile(target)):
        what = f"holds a run that did not come to its end, until {reached:g} s"
        raise ResultFileError(f"{path}.partial: {what}; kept (force=True replaces it)")


@ended_at_once()
def held_until(partial: Path) -> float:
    """Time [s] of the last sample in an unfinished trajectory file; 0 without one, or without such a file."""
    import h5py

    try:
        with h5py.File(partial, "r") as file:
            time = file["time"]
            is_run = read_attr(file, "vibsim_kind", "trajectory") == "trajectory"
            return float(time[-1]) if is_run and len(time) else 0.0
    except (OSError, KeyError, RuntimeError, TypeError, ValueError):
        return 0.0

"""A trajectory written to an HDF5 file while it is being computed.

The file grows as NAME.partial, is flushed every few megabytes, and every ten seconds where these take
longer (a killed run leaves a file that opens, holding what the last flush held), and gets its name when it
is whole. Memory does not grow with the length of the run.
"""

import errno
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import repeat
from pathlib import Path
from typing import Any, NoReturn

import h5py
import numpy as np

from vibsim.physics.numbers import text_width
from vibsim.results.columns import Tables
from vibsim.results.file_contents import Dataset
from vibsim.results.hdf5_reading import ResultFileError, detach, reason, release, reserve, write_attrs
from vibsim.results.hdf5_writing import LIBVER, DatasetStream, DigitsStream, Stream, write_datasets
from vibsim.results.output_files import (
    Lock,
    check_leftover,
    check_result_output,
    held_until,
    partial_path,
    publish,
)
from vibsim.results.trajectory_file import digit_columns
from vibsim.signals import held_back

SAMPLE_CHUNK = 16384  # rows: 128 kB per column, 82 s at 5 ms; a window reads few chunks, a run writes few
EVENT_CHUNK = 2048
FLUSH_BYTES = 4 << 20  # flushed at a time, so at most some 5 MB of samples are lost with a killed run
LONGEST = 10.0  # seconds of computing that are lost at most with a killed run that fills its chunks slowly
FOR_COLUMN = 4 << 10  # bytes that a column takes besides its rows: header, attributes, index; 3.5 kB measured
FOR_INDEX = 2200  # bytes of a node in the index of a column's chunks
FOR_ATTRIBUTE = 128  # bytes that an attribute takes besides its value
FOR_FILE = 16 << 10  # bytes that the root takes besides long attributes


class TrajectoryWriter:
    """Streams samples and events to `path`; nothing is under that name before `finish`.

    Parameters
    ----------
    path : the target; kept if it exists unless `force`
    tables : the columns of its samples and events
    attrs : root attributes known at the start; every later one by `update`
    """

    def __init__(self, path: str | Path, tables: Tables, attrs: Mapping[str, Any], force: bool = False):
        self.target = check_result_output(path, force)
        self.partial = partial_path(self.target)
        self.shown = f"{path}.partial"
        self.force = force
        self._path = path
        with held_back():
            self._lock = Lock(self.target, path)
            try:
                check_leftover(path, force)  # once more: another may have been killed in between
                self._create(tables, attrs)
            except BaseException:
                self._lock.release()
                raise

    def _create(self, tables: Tables, attrs: Mapping[str, Any]) -> None:
        self._unflushed = 0
        self._flushed = time.monotonic()
        self._reserved = 0  # size [bytes] up to which there is room
        self._indexed = False  # whether rows are on file
        count = len(tables.samples) + len(tables.events)
        self._besides = FOR_FILE + _size_of(attrs) + FOR_COLUMN * count
        self.streams: list[Stream] = []
        try:
            self.partial.unlink(missing_ok=True)  # it may be another name of a whole file
            self._file = h5py.File(self.partial, "w", libver=LIBVER)
        except OSError as error:
            raise ResultFileError(f"{self._path}: cannot write: {reason(error)}") from error
        if not self._make_room():
            self._file.close()
            self.partial.unlink()
            raise ResultFileError(f"{self._path}: disk full")
        self.update(attrs)
        self.samples = DatasetStream(self._file.id, tables.samples, SAMPLE_CHUNK)
        self.events = DatasetStream(self._file.create_group("events").id, tables.events, EVENT_CHUNK)
        self.streams += [self.samples, self.events]
        self._besides -= (FOR_COLUMN - FOR_INDEX) * count
        self._file.flush()

    def append(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take one block of samples and events (name -> 1-D array)."""
        rows = [len(samples["time"]), len(events["t"])] * (len(self.streams) // 2)
        ahead = [2 * count for count in rows]  # room for the next block too, where there is that much
        if not (self._make_room(ahead) or self._make_room(rows)):
            self._write_last()
        self._take(samples, events)
        if self.samples.waiting >= SAMPLE_CHUNK or self.events.waiting >= EVENT_CHUNK:
            self._write()
        if time.monotonic() - self._flushed > LONGEST:
            self._write(everything=True)

    def _take(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        self.samples.append(samples)
        self.events.append(events)

    def update(self, attrs: Mapping[str, Any]) -> None:
        """Set root attributes; one that is None is left out."""
        write_attrs(self._file.id, attrs)

    def attach(self, declared: Sequence[Dataset], values: Mapping[str, Any]) -> None:
        """Write small datasets that are made at once, by name, beside the tables."""
        self._besides += sum(FOR_COLUMN + np.asarray(values[each.name]).nbytes for each in declared)
        if not self._make_room():
            self._write_last()
        try:
            write_datasets(self._file, declared, values)
        except (OSError, RuntimeError) as error:
            raise self._lost(error) from error

    def finish(self, attrs: Mapping[str, Any]) -> Path:
        """Write what waits and the last attributes, and give the file its name; returns that path."""
        try:
            self._complete(attrs)
            publish(self.partial, self.target, self.force)
        except ResultFileError as error:
            if self.partial.exists() and self.shown not in str(error):
                raise ResultFileError(f"{error}; the run is in {self.shown}") from error
            raise
        finally:
            self._lock.release()
        return self.target

    def keep(self, attrs: Mapping[str, Any]) -> None:
        """Write what waits and the last attributes, and close the file, leaving it under its partial name;
        without a sample it is removed.
        """
        try:
            self._complete(attrs)
            if held_until(self.partial) == 0.0:
                self.partial.unlink(missing_ok=True)
        finally:
            self._lock.release()

    def _complete(self, attrs: Mapping[str, Any]) -> None:
        if self._file:
            self._besides += _size_of(attrs)
            if not self._make_room():
                self._write_last()
            self._write(everything=True)
            self.update(attrs)
            self._close_file()

    def drop(self) -> None:
        """Close the file and remove it."""
        try:
            self._close_file()
            self.partial.unlink()
        finally:
            self._lock.release()

    def close(self) -> None:
        """Close the file as it is, and let others write it."""
        try:
            self._close_file()
        finally:
            self._lock.release()

    def _close_file(self) -> None:
        if not self._file:
            return
        try:
            self._file.flush()
            used = self._file.id.get_filesize()
            self._file.close()
            release(self.partial, used)
        except (OSError, RuntimeError) as error:
            raise ResultFileError(f"{self.shown}: cannot write: {reason(error)}") from error

    def _write(self, everything: bool = False) -> None:
        if not self._indexed:
            self._besides *= 2  # from now on an index may have to be split, which takes two nodes
            self._indexed = True
        try:
            for stream in self.streams:
                self._unflushed += stream.waiting_bytes()
                stream.write(everything)
            if self._unflushed >= FLUSH_BYTES or everything:
                self._file.flush()
                self._unflushed, self._flushed = 0, time.monotonic()
        except (OSError, RuntimeError) as error:
            raise self._lost(error) from error

    def _write_last(self) -> NoReturn:
        """The disk is full: write what waits, as far as there is room for it, and end."""
        if self._needed() > self._reserved:
            raise self._lost(OSError(errno.ENOSPC, "no room for what waits"))
        self._write(everything=True)
        self._close_file()
        raise ResultFileError(self._ended_by("disk full"))

    def _ended_by(self, cause: str) -> str:
        """Why the closed file is not finished, and what it holds; it is removed where that is nothing."""
        reached = held_until(self.partial)
        if reached > 0.0:
            return f"{self.shown}: {cause}; it holds the run until {reached:g} s"
        self.partial.unlink()
        return f"{self.shown.removesuffix('.partial')}: {cause}; nothing is stored"

    def _lost(self, error: Exception) -> ResultFileError:
        """Close the file as the last flush left it, after a write that has failed; what to raise."""
        detach(self._file.id.get_vfd_handle())
        with suppress(ResultFileError):
            self._close_file()
        return ResultFileError(self._ended_by(f"cannot write: {reason(error)}"))

    def _needed(self, more: Iterable[int] = repeat(0)) -> int:
        """Size of the file [bytes] with what waits, `more` rows per stream, and what is written besides."""
        rows = sum(stream.waiting_bytes(extra) for stream, extra in zip(self.streams, more, strict=False))
        return int(self._file.id.get_filesize() + rows + self._besides)

    def _make_room(self, more: Iterable[int] = repeat(0)) -> bool:
        """Reserve what is needed; False where there is no room for it."""
        needed = self._needed(more)
        if needed > self._reserved:
            used = self._file.id.get_filesize()
            if not reserve(self.partial, used, needed - used):
                return False
            self._reserved = needed
        return True


def _size_of(attrs: Mapping[str, Any]) -> int:
    """Bytes that attributes take on file, about."""
    return FOR_ATTRIBUTE * len(attrs) + sum(
        2 * len(value) if isinstance(value, str) else getattr(value, "nbytes", 0) for value in attrs.values()
    )


class TruthWriter(TrajectoryWriter):
    """A trajectory writer that also takes texts of `digits` digits: groups /digits and /digits/events."""

    def __init__(
        self,
        path: str | Path,
        tables: Tables,
        attrs: Mapping[str, Any],
        digits: int,
        force: bool = False,
    ):
        super().__init__(path, tables, attrs, force)
        states, happened = digit_columns(tables)
        width = text_width(digits)
        group = self._file.create_group("digits")
        time = self._file["time"]
        self.sample_digits = DigitsStream(group, states, width, SAMPLE_CHUNK, time)
        self.event_digits = DigitsStream(group.create_group("events"), happened, width, EVENT_CHUNK)
        self.streams += [self.sample_digits, self.event_digits]
        self._besides += FOR_COLUMN * (2 * len(states) + 2)
        self._file.flush()

    def append_digits(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take the digits of one block, before its samples and events."""
        self._digits = samples, events

    def _take(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        super()._take(samples, events)
        self.sample_digits.append(self._digits[0])
        self.event_digits.append(self._digits[1])

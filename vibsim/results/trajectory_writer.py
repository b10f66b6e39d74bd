"""Write a trajectory to an HDF5 file while it is being computed.

The file grows as NAME.partial, is flushed every few megabytes (a killed run leaves a file that opens, holding
what the last flush held) and gets its name when it is whole. Memory does not grow with the length of the run.
"""

import errno
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vibsim.results.attributes import write_attrs
from vibsim.results.columns import event_columns
from vibsim.results.dataset_stream import DatasetStream
from vibsim.results.disk_space import MARGIN, detach, release, reserve
from vibsim.results.errors import ResultFileError
from vibsim.results.output_file import check_output, is_locked, partial_path, publish, reason

SAMPLE_CHUNK = 16384  # rows: 128 kB per column, 82 s at 5 ms; a window reads few chunks, a run writes few
EVENT_CHUNK = 2048
FLUSH_BYTES = 4 << 20  # flushed at a time, so at most some 5 MB of samples are lost with a killed run

# 'earliest' keeps the file readable after a kill: the newer formats mark an open file and refuse it later.
LIBVER = ("earliest", "v110")


class TrajectoryWriter:
    """Streams samples and events to `path`; nothing is under that name before `finish`.

    Parameters
    ----------
    path : the target; kept if it exists unless `force`
    columns : names of the sampled columns, `time` first
    attrs : root attributes known at the start; every later one by `update`
    """

    def __init__(
        self, path: str | Path, columns: tuple[str, ...], attrs: Mapping[str, Any], force: bool = False
    ):
        self.target = check_output(path, force)
        self.partial = partial_path(self.target)
        self.shown = f"{path}.partial"
        self.force = force
        self._unflushed = 0
        if is_locked(self.partial):  # HDF5 would empty the file before it finds that out
            raise ResultFileError(f"{self.shown}: another run is writing it")
        try:
            self._file = h5py.File(self.partial, "w", libver=LIBVER)
        except OSError as error:
            raise ResultFileError(f"{self.shown}: cannot write: {reason(error)}") from error
        if not self._reserve(0):
            self._file.close()
            self.partial.unlink()
            raise ResultFileError(f"{path}: disk full")
        self.update(attrs)
        self.samples = DatasetStream(self._file.id, columns, SAMPLE_CHUNK)
        self.events = DatasetStream(self._file.create_group("events").id, event_columns(columns), EVENT_CHUNK)
        self.streams: list[Any] = [self.samples, self.events]
        self._file.flush()

    def append(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take one block of samples and events (name -> 1-D array)."""
        self.samples.append(samples)
        self.events.append(events)
        if self.samples.waiting >= SAMPLE_CHUNK or self.events.waiting >= EVENT_CHUNK:
            self._write()

    def update(self, attrs: Mapping[str, Any]) -> None:
        """Set root attributes; one that is None is left out."""
        write_attrs(self._file.id, attrs)

    def finish(self, attrs: Mapping[str, Any]) -> Path:
        """Write what waits and the last attributes, and give the file its name; returns that path."""
        self.keep(attrs)
        publish(self.partial, self.target, self.force)
        return self.target

    def keep(self, attrs: Mapping[str, Any]) -> None:
        """Write what waits and the last attributes, and close the file, leaving it under its partial name."""
        if self._file:
            self._write(everything=True)
            self.update(attrs)
            self.close()

    def close(self) -> None:
        """Close the file as it is."""
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
        size = sum(stream.waiting_bytes() for stream in self.streams)
        full = not self._reserve(size)
        try:
            if full and size > MARGIN // 2:
                raise OSError(errno.ENOSPC, "no room for what waits")
            for stream in self.streams:
                stream.write(everything or full)
            self._unflushed += size
            if self._unflushed >= FLUSH_BYTES:
                self._file.flush()
                self._unflushed = 0
        except (OSError, RuntimeError) as error:
            detach(self._file.id.get_vfd_handle())
            with suppress(ResultFileError):
                self.close()
            raise ResultFileError(f"{self.shown}: cannot write: {reason(error)}") from error
        if full:
            self.close()
            raise ResultFileError(f"{self.shown}: disk full; it holds what was computed until then")

    def _reserve(self, size: int) -> bool:
        return reserve(self.partial, self._file.id.get_filesize(), size + MARGIN)

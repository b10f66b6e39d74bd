"""A run of the engine recorded as it comes, judged on the way, in memory or in an HDF5 file."""

import errno
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property, partial
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

import h5py
import numpy as np

from vibsim.engine.blocks import Block
from vibsim.engine.blocks_ahead import BlocksAhead, Thinning, instants_per_sample, sampled_finer
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import Trajectory, flow_of, open_trajectory
from vibsim.physics.numbers import text_width
from vibsim.results.columns import Distances, Tables, tables_of
from vibsim.results.file_contents import Column, Dataset, origin, outcome
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
from vibsim.results.parallel_runs import GoOn
from vibsim.results.trajectory_file import digit_columns, doubt_attributes, exponent_attributes
from vibsim.results.trust_horizon import NoTrust, Rows, Trust
from vibsim.signals import held_back

if TYPE_CHECKING:
    from vibsim.cases import Case


# A run of the engine, recorded block by block into memory or a file.


Watch = Callable[[float], bool]  # given how far the run is worked out [s]; False stops it there


class Sink(Protocol):
    """Takes the blocks of a run."""

    def append(self, samples: Rows, events: Rows) -> None: ...


class Recording:
    """One run of a case: `start` has the attributes known before it, `into` runs it, `end` has the rest.

    The engine runs in a thread of its own, from `set_off` on where something is to be done before `into`.
    With `trust`, a second run beside it tells until when it is right. tangent : number of Lyapunov exponents
    that it takes along, and the time [s] from which they count.
    """

    def __init__(self, case: "Case", trust: bool = True, tangent: tuple[int, float] = (0, 0.0)):
        self.scene = case.scene()
        self.began = time.perf_counter()
        instants = instants_per_sample(self.scene) if trust else 1
        judged = sampled_finer(self.scene, instants)
        self._thinning = Thinning(instants)
        count, begin = tangent
        self.trajectory = open_trajectory(judged, ledger=True, tangent=count, tangent_from=begin)
        self._ahead = BlocksAhead(self.trajectory, partial(left_out, self.trajectory))
        self._origin = partial(origin, case, self.scene, flow_of(self.scene))
        self.t_reached = self._known_to = self._worked_to = 0.0
        self.complete = False
        self._distances = Distances(case, self.scene)
        self._trust: NoTrust[tuple[Rows, float]] = NoTrust()
        if trust:
            self._trust = Trust(case, judged, self._ahead.tell_news)
        self.tables = tables_of(self.scene).judged(self._trust.columns)

    @cached_property
    def start(self) -> dict[str, Any]:
        """Attributes known before the run."""
        return self._origin()

    def set_off(self) -> None:
        """Let the engine begin; to be followed by `into` or `close`."""
        self._ahead.start()
        self._trust.start()

    def close(self) -> None:
        """Let go of the engine, where it is."""
        self._ahead.close()
        self._trust.close()

    def into(self, sink: Sink, watch: Watch | None = None) -> None:
        """Run to the end, or until `watch` says stop; raises EngineError when the run fails."""

        def go_on() -> bool:
            return watch is None or watch(self.progress)

        self.set_off()
        try:
            try:
                self._run(sink, go_on)
            except EngineError:
                self._hand_on(sink, self._trust.rest(go_on))
                raise
            self._hand_on(sink, self._trust.rest(go_on))
        finally:
            self.close()

    def _run(self, sink: Sink, go_on: GoOn) -> None:
        """Hand on what the engine tells; where `go_on` says no, what it has computed by then."""
        going = True

        def goes_on() -> bool:
            nonlocal going
            going = going and go_on()
            return going

        def judge_what_waits() -> None:
            self._hand_on(sink, self._trust.ready(goes_on))

        for block, missing in self._ahead.blocks(goes_on, judge_what_waits):
            times = block.samples["time"][-1:].tolist()
            self._known_to = max(float(block.t_reached), *times, self._known_to)
            self._worked_to = block.worked_to
            tag = block.events, self._known_to
            self._hand_on(
                sink, self._trust.judged(block.samples, block.events["t"], missing, tag, go_on, going)
            )
            if not goes_on():
                self._ahead.stop()
        self.complete = going

    def _hand_on(self, sink: Sink, judged: Iterable[tuple[Rows, tuple[Rows, float]]]) -> None:
        """Give the sink blocks of samples, each with its events and the time [s] that is known then."""
        for rows, (events, known_to) in judged:
            samples = self._thinning.thinned(rows)
            sink.append(samples, events)
            self._distances.update(samples, events)
            self.t_reached = known_to

    @property
    def progress(self) -> float:
        """How far the run is worked out [s]: a third is the motion, a third what goes with it, such as the
        energy ledger, which a long stretch without events gets after its samples, and a third the companion,
        which may be a few blocks behind.
        """
        known = self._known_to
        return known - ((known - self._worked_to) + max(known - self._trust.t_reached, 0.0)) / 3

    def end(self) -> dict[str, Any]:
        """Attributes of what came of the run so far."""
        wall_time = time.perf_counter() - self.began
        totals = self.trajectory.totals
        known = outcome(totals, self.t_reached, self._distances.attrs, wall_time, self.complete)
        doubts = doubt_attributes(self.trajectory.doubts)
        return {**known, **doubts, **exponent_attributes(totals), **self._trust.attrs(self.t_reached)}


def left_out(trajectory: Trajectory, block: Block) -> np.ndarray | float:
    """Distance that completed chatter has left out at the samples of a block [m], wherever that ends."""
    ends = trajectory.left_out if trajectory.scene.rigid_stops else []
    if not ends:
        return 0.0
    times, distances = np.array([(-np.inf, 0.0), *ends]).T
    return np.asarray(distances[np.searchsorted(times, block.samples["time"], side="right") - 1])


class MemorySink:
    """Keeps the blocks of a run as arrays."""

    def __init__(self, tables: Tables):
        self._columns = tables
        self._samples: dict[str, list[np.ndarray]] = {name: [] for name in tables.samples}
        self._events: dict[str, list[np.ndarray]] = {name: [] for name in tables.events}

    def append(self, samples: Rows, events: Rows) -> None:
        for name, parts in self._samples.items():
            parts.append(samples[name])
        for name, parts in self._events.items():
            parts.append(events[name])

    def tables(self) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Samples and events, name -> 1-D array."""
        return _joined(self._samples, self._columns.samples), _joined(self._events, self._columns.events)


def _joined(parts: dict[str, list[np.ndarray]], columns: dict[str, Column]) -> dict[str, np.ndarray]:
    return {name: _one(arrays, columns[name].dtype) for name, arrays in parts.items()}


def _one(arrays: list[np.ndarray], dtype: Any) -> np.ndarray:
    if len(arrays) == 1:
        return arrays[0].astype(dtype, copy=False)
    return np.concatenate(arrays, dtype=dtype)


# A trajectory written to an HDF5 file while it is being computed.


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
        """Reason why the closed file is unfinished, and what it holds; it is removed if that is nothing."""
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

"""The store of what takes long: sweeps, fits, branches and loci, record by record, resumed after any end.

What is finished is appended to a journal, NAME.h5.journal, one record per line, as it comes. An HDF5 file
that is changed in place may not open again after a kill; a file that is only appended to loses at most its
last, unfinished line. Every line begins with a checksum of itself and of the task, and with its number: what
was damaged afterwards is noticed and left out, and what stands behind it is not lost. The journal is merged
into the HDF5 file whenever that is written anew, and removed at the end. One process at a time writes it, and
everybody may read it meanwhile.

SQLite would need the checksums all the same: its pages have none, and a damaged one makes the database
malformed as a whole. Its write-ahead log needs two more files, and shared memory that network disks lack.

Plans and records are plain data for JSON, written and read back by the fields of their dataclasses:

int, float, bool, str      as they are
complex                    [real part, imaginary part]
Fraction                   the shortest exact text
array of doubles           hex digits, five times as fast as decimals
tuple, NamedTuple          a list
dict[str, ...]             an object
a dataclass                an object, by the names of its fields; see `stored` for other forms
"""

import hashlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from types import NoneType, TracebackType
from typing import Any, Generic, NamedTuple, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from vibsim.cases.problems import counted
from vibsim.cases.quantities import decimal_text, exact_number
from vibsim.results.hdf5_reading import ResultFileError, reason, reserve
from vibsim.results.output_files import Lock, check_leftover, check_result_output
from vibsim.signals import held_back


class StoredField(NamedTuple):
    """Rules by which a field of a dataclass is stored.

    name : under which; empty: its own; None: it is not stored, and whoever reads brings it
    write, read : of its value and its plain data, where they do not follow from its type
    """

    name: str | None = ""
    write: Callable[[Any], Any] | None = None
    read: Callable[[Any], Any] | None = None


def stored(*how: Any) -> dict[str, StoredField]:
    """The metadata of a field that is stored otherwise than by its name and type, see `StoredField`."""
    return {"stored": StoredField(*how)}


BESIDE = stored(None)


def plain_data(value: Any) -> dict[str, Any]:
    """A dataclass as plain data."""
    plain = {}
    for name, stored_name, write in _writers(type(value)):  # type: ignore[arg-type]
        here = getattr(value, name)
        plain[stored_name] = here if write is None else write(here)
    return plain


@cache
def _writers(kind: Any) -> list[tuple[str, str, Callable[[Any], Any] | None]]:
    """Of each field of a dataclass that is stored: its name, the stored one, what writes it."""
    return [
        (name, form.name or name, form.write or _writer(part))
        for name, part, form in _fields(kind)
        if form.name is not None
    ]


def _writer(kind: Any) -> Callable[[Any], Any] | None:
    """The function that writes values of a kind; None where they are plain data."""
    origin, parts = get_origin(kind), get_args(kind)
    if kind in LEAVES or (origin is dict and parts[1] in LEAVES):
        return None
    return list if origin is tuple and parts[1:] == (...,) and parts[0] in LEAVES else partial(_written, kind)


def from_plain(kind: Any, data: Mapping[str, Any], **known: Any) -> Any:
    """The dataclass of a kind that `plain_data` wrote down; a field without data has its default.

    known : fields that are taken from here, in it and in the dataclasses within it

    Raises KeyError, TypeError or ValueError for data that are none of this kind.
    """
    values = {name: known[name] for name, _, _ in _fields(kind) if name in known}
    for name, part, form in _fields(kind):
        if name not in known and (form.name or name) in data:
            here = data[form.name or name]
            values[name] = form.read(here) if form.read else _read(part, here, known)
    return kind(**values)


@cache
def _fields(kind: Any) -> list[tuple[str, Any, StoredField]]:
    """Name, type and form of the fields of a dataclass; the type of one that is not stored is left open."""
    listed = []
    for each in fields(kind):
        form, part = each.metadata.get("stored", StoredField()), each.type
        if isinstance(part, str) and form.name is not None:
            part = eval(part, vars(sys.modules[kind.__module__]))
        listed.append((each.name, part, form))
    return listed


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"a text was expected, got {value!r:.60}")
    return value


LEAVES: dict[Any, Callable[[Any], Any]] = {int: int, float: float, bool: bool, str: _text}
READERS = LEAVES | {
    complex: lambda pair: complex(*pair),
    Fraction: exact_number,
    np.ndarray: lambda digits: np.frombuffer(bytes.fromhex(digits), "<f8"),
}
WRITERS: dict[Any, Callable[[Any], Any]] = {
    complex: lambda number: [number.real, number.imag],
    Fraction: decimal_text,
    np.ndarray: lambda array: array.astype("<f8").tobytes().hex(),
}


def _written(kind: Any, value: Any) -> Any:
    """A value of a kind as plain data."""
    if kind in LEAVES or value is None:
        return value
    if kind in WRITERS:
        return WRITERS[kind](value)
    if is_dataclass(value):
        return value.plain() if hasattr(value, "plain") else plain_data(value)
    if isinstance(value, dict):
        part = get_args(kind)[1]
        return value if part in LEAVES else {name: _written(part, one) for name, one in value.items()}
    if isinstance(value, tuple):
        return [_written(part, one) for part, one in zip(_parts(kind, len(value)), value, strict=True)]
    return _written(type(value), value)


def _read(kind: Any, data: Any, known: Mapping[str, Any]) -> Any:
    """The value of a kind that `_written` wrote down."""
    if kind in READERS:
        return READERS[kind](data)
    if is_dataclass(kind):
        return from_plain(kind, data, **known)
    if get_origin(kind) is dict:
        part = get_args(kind)[1]
        return dict(data) if part in LEAVES else {name: _read(part, one, known) for name, one in data.items()}
    if NoneType in get_args(kind):
        return None if data is None else _read(get_args(kind)[0], data, known)
    parts = _parts(kind, len(data))
    values = tuple(_read(part, one, known) for part, one in zip(parts, data, strict=True))
    return kind(*values) if hasattr(kind, "_fields") else values


def _parts(kind: Any, count: int) -> Sequence[Any]:
    """The types of so many values of a tuple or NamedTuple."""
    parts = tuple(get_type_hints(kind).values()) if hasattr(kind, "_fields") else get_args(kind)
    return [parts[0]] * count if parts[-1] is ... else parts


# The store of what takes long: sweeps, fits, branches and loci, record by record, resumed after any end.


LEAST_PAUSE = 10.0  # seconds between two writings of the HDF5 file while records come in
LARGEST_SHARE = 0.02  # of the time that writing it may take
SUFFIX = ".journal"
CHECKSUM = 16  # hex digits

T = TypeVar("T")
R = TypeVar("R")  # a record: what is computed at a time
Self = TypeVar("Self", bound="Store[Any]")


class Store(Generic[R]):
    """Records of one plan: in memory, and with a path on file.

    On file it goes on from what the file and its journal hold, and keeps every record from then on. Used as a
    context manager: at its end, whatever ended it, the file holds all records and the journal is gone.

    plan : has a `fingerprint`, which tells it from others
    path : of the HDF5 file; None: the records are kept in memory alone
    force : whether a file that is there is replaced

    Raises ResultFileError where the file holds anything else (unless `force`), where another process writes
    it, or where it cannot be written.

    attrs : root attributes of the file; notes : what the user should know of what was there before
    """

    what: str  # that is stored, for messages
    record: type  # of R, a dataclass
    patient = False  # whether it begins though the file cannot be written: the journal keeps what comes

    def __init__(self, plan: Any, path: str | Path | None = None, force: bool = False):
        self.plan = plan
        self.make_memory()
        self.attrs: dict[str, Any] = self.origin()
        self.notes: list[str] = []
        self.complete = False  # whether all there is to come has come
        self.path: Path | None = None
        self.shown = path or ""  # the path as the user calls it
        self._on_file: tuple[bool, bool] | None = None  # all that is in memory; `complete`; None: no file yet
        self._next = 0.0  # when the file is written next
        if path is not None:
            self.path = check_result_output(path, force=True)
            check_leftover(path, force)
            self._journal = Journal(self.path, self.what, path)
            try:
                self._go_on(self.path.exists(), force)
            except BaseException:
                self._journal.close(remove=False)
                raise

    def _go_on(self, there: bool, force: bool) -> None:
        """Take over what the file, where it is there, and the journal hold; they must be of this plan."""
        if force:
            self._journal.restart(self.plan.fingerprint)
            return
        if there:
            attrs = self.take_stored()
            self.attrs["date_created"] = attrs["date_created"]
            self._on_file = (True, bool(attrs["complete"]))
        waiting = list(self._journal.read(self.plan.fingerprint))
        for record in self.following(from_plain(self.record, each) for each in waiting):
            self._take(record)
        self.notes += self._journal.notes()
        self._journal.go_on(self.plan.fingerprint, waiting)

    # What a store of a kind says of it.

    def make_memory(self) -> None:
        """Make what records are kept in."""
        raise NotImplementedError

    def origin(self) -> dict[str, Any]:
        """Attributes that are known before the first record."""
        raise NotImplementedError

    def take(self, record: R) -> None:
        """Keep a record in memory."""
        raise NotImplementedError

    def take_stored(self) -> dict[str, Any]:
        """Take over what the file `shown` holds; its attributes. Raises ResultFileError where it is of
        another plan.
        """
        raise NotImplementedError

    def following(self, waiting: Iterable[R]) -> Iterable[R]:
        """Those that are to be taken of the records that wait in the journal."""
        return waiting

    def write(self, path: Path) -> None:
        """Write the file. Raises ResultFileError."""
        raise NotImplementedError

    @property
    def has_file(self) -> bool:
        """Whether there is enough in memory for a file."""
        return True

    # How it is kept.

    def __enter__(self: Self) -> Self:
        try:
            self.publish()
        except BaseException as error:
            if not (self.patient and isinstance(error, ResultFileError)):
                self._journal.close(remove=False)
                raise
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.path is None:
            return
        published = False
        try:
            self._journal.give_back()
            self.publish()
            published = True
        except ResultFileError as failure:
            raise self._journal.kept_after(failure) from failure
        finally:
            self._journal.close(remove=published)

    def add(self, records: Iterable[R]) -> None:
        """Keep records. The journal has them even where there is no room for the file beside its old self."""
        batch = list(records)
        for record in batch:
            self._take(record)
        if self.path is None:
            return
        self._journal.add(map(plain_data, batch))
        if time.monotonic() >= self._next:
            try:
                self.publish()
            except ResultFileError:  # what is wrong is said at the end
                self._next = time.monotonic() + LEAST_PAUSE

    def _take(self, record: R) -> None:
        self.take(record)
        if self._on_file is not None:
            self._on_file = (False, self._on_file[1])

    def publish(self) -> None:
        """Write the file anew if need be; then the journal, whose records are in it, begins anew."""
        if self.path is None or not self.has_file:
            return
        began = time.monotonic()
        if self._on_file is None or self._on_file < (True, self.complete):
            self.write(self.path)
            self._on_file = (True, self.complete)
        self._journal.restart(self.plan.fingerprint)
        ended = time.monotonic()
        self._next = ended + max(LEAST_PAUSE, (ended - began) / LARGEST_SHARE)


class Journal:
    """The journal beside the file `target`, which is locked until the journal is closed.

    what, shown : is written there, and into which file as the user calls it; for messages

    `damaged` counts the records that `read` has left out. Raises ResultFileError where another writer has the
    lock, or where the journal cannot be written.
    """

    def __init__(self, target: Path, what: str, shown: str | Path = ""):
        self.path = journal_path(target)
        self.damaged = 0
        self._what = what
        self._fingerprint = ""
        self._records = 0  # with the header
        self._whole = False  # whether everything on file can be gone on from
        try:
            with held_back():
                self._lock = Lock(target, shown or target)
                self._descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            self._lock.release()
            raise ResultFileError(f"{self.path}: cannot write: {reason(error)}") from error
        self._end = self._reserved = 0  # bytes written, and bytes that there is room for

    def read(self, fingerprint: str) -> Iterator[Any]:
        """The records of the task of that fingerprint as plain data: no damaged ones, and no unfinished line.


        Raises ResultFileError when there are records of another task.
        """
        header: dict[str, Any] | None = None
        for number, line in enumerate(_whole_lines(self.path)):
            if number == 0:
                header = _record(line, "")
                self.damaged += header is None
            elif header is not None and header != {"fingerprint": fingerprint}:
                held = f"points of another {self._what} are waiting in it"
                raise ResultFileError(f"{self.path}: {held}; force=True drops them")
            elif (record := _record(line, fingerprint)) is None:
                self.damaged += 1
            else:
                yield record
        self._whole = not self.damaged and header == {"fingerprint": fingerprint}

    def notes(self) -> list[str]:
        """Remarks for the user on what `read` came upon."""
        if not self.damaged:
            return []
        return [f"{self.path}: {counted(self.damaged, 'damaged record')} left out; computed again"]

    def go_on(self, fingerprint: str, records: Sequence[Any]) -> None:
        """Make ready for more records behind those that `read` has given; damaged ones are taken out."""
        if not self._whole:
            self.restart(fingerprint)
            self.add(records)
            return
        self._fingerprint, self._records = fingerprint, len(records) + 1
        self._end = sum(map(len, _whole_lines(self.path)))
        self.give_back()

    def restart(self, fingerprint: str) -> None:
        """Begin anew: no records, the fingerprint on the first line; what was reserved is given back."""
        header = _line(0, {"fingerprint": fingerprint}, "")
        if fingerprint != self._fingerprint:
            os.ftruncate(self._descriptor, 0)
        self._end = self._records = 0
        self._append([header])
        self._fingerprint = fingerprint
        self.give_back()

    def reserve(self, size: int) -> bool:
        """Make sure of room on disk for `size` bytes of records to come; False where there is none."""
        if self._end + size <= self._reserved:
            return True
        if not reserve(self.path, self._end, size):
            self.give_back()
            return False
        self._reserved = self._end + size
        return True

    def give_back(self) -> None:
        """Give back the room that was reserved and not used."""
        os.ftruncate(self._descriptor, self._end)
        self._reserved = self._end

    def add(self, records: Iterable[Any]) -> None:
        """Append records; they are kept whatever happens to this process afterwards."""
        numbered = enumerate(records, self._records)
        self._append([_line(number, one, self._fingerprint) for number, one in numbered])

    def _append(self, lines: list[bytes]) -> None:
        data = b"".join(lines)
        try:
            written = 0
            os.lseek(self._descriptor, self._end, os.SEEK_SET)
            while written < len(data):
                written += os.write(self._descriptor, data[written:])
        except OSError as error:
            raise ResultFileError(f"{self.path}: cannot write: {reason(error)}") from error
        self._end += len(data)
        self._records += len(lines)

    def kept_after(self, failure: ResultFileError) -> ResultFileError:
        """Error to raise where the file cannot be written: its text names what the journal holds."""
        if self._records < 2:  # the header alone
            return failure
        remedy = f"{failure}; what was computed is kept in {self.path.name}"
        return ResultFileError(f"{remedy}, and the same command resumes it")

    def close(self, remove: bool) -> None:
        """Let go of the lock; with `remove`, or where it holds no records, of the file as well."""
        with held_back():
            empty = self._records == 1 or not os.fstat(self._descriptor).st_size
            os.close(self._descriptor)
            if remove or empty:
                self.path.unlink(missing_ok=True)
            self._lock.release()


def _line(number: int, content: dict[str, Any], fingerprint: str) -> bytes:
    """One line: checksum, number, content; the checksum covers the sweep as well."""
    text = f"{number} {json.dumps(content)}"
    return f"{_checksum(text.encode(), fingerprint)} {text}\n".encode()


def _record(line: bytes, fingerprint: str) -> dict[str, Any] | None:
    """Record of a line; None for a damaged one, or one of another sweep."""
    checksum, _, text = line.rstrip(b"\n").partition(b" ")
    if checksum != _checksum(text, fingerprint).encode():
        return None
    record: dict[str, Any] = json.loads(text.partition(b" ")[2])
    return record


def _checksum(text: bytes, fingerprint: str) -> str:
    return hashlib.sha256(fingerprint.encode() + b" " + text).hexdigest()[:CHECKSUM]


def journal_path(target: Path) -> Path:
    """NAME.h5.journal beside the target."""
    return target.with_name(target.name + SUFFIX)


class Waiting:
    """Records that wait in the journal beside a file for being taken into it, for those who only read.

    To be made before the file is read: what is taken up in between is then in both, and nothing in neither.
    """

    def __init__(self, path: str | Path):
        try:
            self._lines = list(_whole_lines(journal_path(Path(path).absolute().resolve())))
        except (OSError, ValueError):  # most files have none
            self._lines = []

    def records(self, fingerprint: str, kind: type[T]) -> list[T]:
        """The records of the task of that fingerprint, dataclasses of a kind; none that are damaged."""
        if not self._lines or _record(self._lines[0], "") != {"fingerprint": fingerprint}:
            return []
        records = (_record(line, fingerprint) for line in self._lines[1:])
        return [from_plain(kind, each) for each in records if each is not None]


def _whole_lines(path: Path) -> Iterator[bytes]:
    """The lines that were written to their end; behind them there may be room that was reserved."""
    with open(path, "rb") as file:
        for line in file:
            if line.endswith(b"\n"):
                yield line

"""A journal: what is finished, one record per line, appended to NAME.h5.journal as it comes.

An HDF5 file that is changed in place may not open again after a kill; a file that is only appended to loses
at most its last, unfinished line. Every line begins with a checksum of itself and of the task, and with its
number: what was damaged afterwards is noticed and left out, and what stands behind it is not lost. The
journal is merged into the HDF5 file whenever that is written anew, and removed at the end. One process at a
time writes it, and everybody may read it meanwhile.

SQLite would need the checksums all the same: its pages have none, and a damaged one makes the database
malformed as a whole. Its write-ahead log needs two more files, and shared memory that network disks lack.
"""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from vibsim.results.hdf5_reading import ResultFileError, reason, reserve
from vibsim.results.output_files import Lock
from vibsim.signals import held_back

SUFFIX = ".journal"
CHECKSUM = 16  # hex digits


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
        """The records of the task of that fingerprint, without damaged ones and an unfinished last line.

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
                yield self._from_plain(record)
        self._whole = not self.damaged and header == {"fingerprint": fingerprint}

    def notes(self) -> list[str]:
        """What the user should know of what `read` came upon."""
        if not self.damaged:
            return []
        count = f"{self.damaged} damaged record{'s' if self.damaged > 1 else ''}"
        return [f"{self.path}: {count} left out; computed again"]

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
        self._append([_line(number, self._plain(one), self._fingerprint) for number, one in numbered])

    def _plain(self, record: Any) -> dict[str, Any]:
        """A record as plain data for JSON."""
        plain: dict[str, Any] = record
        return plain

    def _from_plain(self, plain: dict[str, Any]) -> Any:
        """The record that `_plain` wrote down."""
        return plain

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
        """What to raise where the file cannot be written: its text names what the journal holds."""
        if self._records < 2:  # the header alone
            return failure
        remedy = f"{failure}; what was computed is kept in {self.path.name}"
        return ResultFileError(f"{remedy}, and the same command goes on from there")

    def close(self, remove: bool) -> None:
        """Let go of the lock; with `remove`, or where it is empty, of the file as well."""
        with held_back():
            empty = not os.fstat(self._descriptor).st_size
            os.close(self._descriptor)
            if remove or empty:
                self.path.unlink(missing_ok=True)
            self._lock.release()


def _line(number: int, content: dict[str, Any], fingerprint: str) -> bytes:
    """One line: checksum, number, content; the checksum covers the sweep as well."""
    text = f"{number} {json.dumps(content)}"
    return f"{_checksum(text.encode(), fingerprint)} {text}\n".encode()


def _record(line: bytes, fingerprint: str) -> dict[str, Any] | None:
    """What a line holds; None for a damaged one, or one of another sweep."""
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
    """What waits in the journal beside a file for being taken into it, for those who only read.

    To be made before the file is read: what is taken up in between is then in both, and nothing in neither.
    """

    def __init__(self, path: str | Path):
        try:
            self._lines = list(_whole_lines(journal_path(Path(path).absolute().resolve())))
        except (OSError, ValueError):  # most files have none
            self._lines = []

    def records(self, fingerprint: str) -> list[dict[str, Any]]:
        """The records of the task of that fingerprint, as plain data; none that are damaged."""
        if not self._lines or _record(self._lines[0], "") != {"fingerprint": fingerprint}:
            return []
        return [record for line in self._lines[1:] if (record := _record(line, fingerprint)) is not None]


def _whole_lines(path: Path) -> Iterator[bytes]:
    """The lines that were written to their end; behind them there may be room that was reserved."""
    with open(path, "rb") as file:
        for line in file:
            if line.endswith(b"\n"):
                yield line

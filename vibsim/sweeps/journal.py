"""The journal of a sweep: finished points, one per line, appended to NAME.h5.journal as they come.

An HDF5 file that is changed in place may not open again after a kill; a file that is only appended to loses
at most its last, unfinished line. The journal is merged into the HDF5 file whenever that is written anew,
and removed at the end. It is also the lock: one process at a time holds it.
"""

import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.results.errors import ResultFileError
from vibsim.results.output_file import reason
from vibsim.sweeps.point import Point

try:
    import fcntl
except ImportError:  # no such locks on this platform: there the user keeps two sweeps off one file
    fcntl = None  # type: ignore[assignment]

SUFFIX = ".journal"


class Journal:
    """The journal beside the file `target`, locked until it is closed; `what` is written there, for messages.

    Raises ResultFileError when another process holds it, or when it cannot be written.
    """

    def __init__(self, target: Path, what: str = "sweep"):
        self.path = journal_path(target)
        try:
            self._descriptor = _open_locked(self.path, target, what)
        except OSError as error:
            raise ResultFileError(f"{self.path}: cannot write: {reason(error)}") from error

    def read(self) -> tuple[str, Iterator[Point]]:
        """Fingerprint of the sweep and its points, up to a broken line; none of a new journal."""
        lines = _whole_lines(self.path)
        fingerprint = str(next(lines, {}).get("fingerprint", ""))
        return fingerprint, map(_point, lines)

    def restart(self, fingerprint: str) -> None:
        """Begin anew: no points, the fingerprint on the first line."""
        os.ftruncate(self._descriptor, 0)
        self._append([{"fingerprint": fingerprint}])

    def mend(self) -> None:
        """Cut off a line that was not written to its end, so that more can be appended."""
        whole = sum(len(text) for text, _ in _texts(self.path))
        os.ftruncate(self._descriptor, whole)

    def add(self, points: Iterable[Point]) -> None:
        """Append points; they are kept whatever happens to this process afterwards."""
        self._append(map(_line, points))

    def _append(self, lines: Iterable[dict]) -> None:
        text = "".join(json.dumps(line) + "\n" for line in lines)
        try:
            with os.fdopen(os.dup(self._descriptor), "ab") as file:
                file.write(text.encode())
        except OSError as error:
            raise ResultFileError(f"{self.path}: cannot write: {reason(error)}") from error

    def close(self, remove: bool) -> None:
        """Let go of the lock; with `remove`, or where it is empty, of the file as well."""
        if remove or not os.fstat(self._descriptor).st_size:
            self.path.unlink(missing_ok=True)
        os.close(self._descriptor)


def _line(point: Point) -> dict[str, Any]:
    """A point as plain data. Arrays are the hex digits of their doubles: five times as fast as decimals."""
    return {
        **vars(point),
        "arrays": {name: array.astype("<f8").tobytes().hex() for name, array in point.arrays.items()},
    }


def _point(line: dict[str, Any]) -> Point:
    """The point that `_line` wrote down."""
    arrays = {name: np.frombuffer(bytes.fromhex(digits), "<f8") for name, digits in line["arrays"].items()}
    return Point(**{**line, "index": tuple(line["index"]), "arrays": arrays})


def journal_path(target: Path) -> Path:
    """NAME.h5.journal beside the target."""
    return target.with_name(target.name + SUFFIX)


def _open_locked(path: Path, target: Path, what: str) -> int:
    """Open and lock; once more when the file was removed by its last owner in between."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            if fcntl is not None:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.exists(path) and os.path.samestat(os.fstat(descriptor), os.stat(path)):
                return descriptor
        except BlockingIOError:
            os.close(descriptor)
            raise ResultFileError(f"{target}: another {what} is writing it") from None
        os.close(descriptor)


def _whole_lines(path: Path) -> Iterator[dict]:
    """The lines that were written to their end."""
    return (line for _, line in _texts(path))


def _texts(path: Path) -> Iterator[tuple[bytes, dict]]:
    """The same with their bytes on file."""
    with open(path, "rb") as file:
        for text in file:
            try:
                line = json.loads(text) if text.endswith(b"\n") else None
            except ValueError:
                line = None
            if not isinstance(line, dict):
                return
            yield text, line

"""A trajectory file opened for reading: attributes and columns when they are asked for."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vibsim import __version__
from vibsim.results.attributes import read_attrs
from vibsim.results.columns import in_file_order
from vibsim.results.digits import Digits
from vibsim.results.errors import ResultFileError
from vibsim.results.output_file import reason
from vibsim.results.provenance import FORMAT

SIGNATURE = b"\x89HDF\r\n\x1a\n"


class TrajectoryFile:
    """An HDF5 file of one trajectory; raises ResultFileError for everything that is not one."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        with damage_named(self.path):
            self._file = open_hdf5(self.path)
            self.samples = FileColumns(self.path, self._file)
            self.events = FileColumns(self.path, self._file["events"])
            self.digits = self._digits(self._file.get("digits"))

    @cached_property
    def attrs(self) -> dict[str, Any]:
        """Root attributes, read when they are asked for: who has just written the file knows them."""
        with damage_named(self.path):
            return read_attrs(self._file)

    def _digits(self, group: h5py.Group | None) -> Digits | None:
        if group is None:
            return None
        return Digits(FileColumns(self.path, group), FileColumns(self.path, group["events"]))

    def close(self) -> None:
        """Let go of the file; columns not read so far can then not be read."""
        self._file.close()


class FileColumns(Mapping[str, np.ndarray]):
    """The columns of one HDF5 group, read whole on first access and kept; `column` reads slices instead."""

    def __init__(self, path: Path, group: h5py.Group):
        self._path = path
        self._group = group
        self._names = in_file_order(name for name, item in group.items() if isinstance(item, h5py.Dataset))
        self._kept: dict[str, np.ndarray] = {}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._kept:
            self._kept[name] = self.column(name)[:]
        return self._kept[name]

    def column(self, name: str) -> "FileColumn":
        """One column, not read yet; KeyError when there is none of this name."""
        if name not in self._names:
            raise KeyError(name)
        return FileColumn(self._path, self._group, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


class FileColumn:
    """One column on file: `column[a:b]` and `column[i]` read that much, `len` reads nothing."""

    def __init__(self, path: Path, group: h5py.Group, name: str):
        self._path = path
        with damage_named(path):
            self._dataset = group[name]
        self.dtype = self._dataset.dtype

    def __len__(self) -> int:
        return int(self._dataset.shape[0])

    def __getitem__(self, rows: Any) -> Any:
        try:
            return self._dataset[rows]
        except (OSError, RuntimeError) as error:
            raise ResultFileError(f"{self._path}: damaged: {reason(error)}") from error


def open_hdf5(path: Path) -> h5py.File:
    """Open an HDF5 file that vibsim wrote, of a format that this version reads, or raise ResultFileError."""
    check_signature(path)
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise ResultFileError(f"{path}: {_open_failure(error)}") from error
    written = file.attrs.get("vibsim_format")
    if written is None:
        file.close()
        raise ResultFileError(f"{path}: is an HDF5 file, but not one that vibsim wrote")
    if int(written) > FORMAT:
        version = file.attrs.get("vibsim_version", "a newer version")
        file.close()
        found = f"has format {int(written)}, written by vibsim {version}"
        raise ResultFileError(f"{path}: {found}; this is vibsim {__version__}, which reads up to {FORMAT}")
    return file


def check_signature(path: Path) -> None:
    """Raise ResultFileError unless `path` is a readable file that begins as an HDF5 file does."""
    try:
        with open(path, "rb") as file:
            start = file.read(len(SIGNATURE))
    except OSError as error:
        raise ResultFileError(f"{path}: {reason(error)}") from error
    if not start:
        raise ResultFileError(f"{path}: is empty")
    if start != SIGNATURE:
        raise ResultFileError(f"{path}: is not an HDF5 file")


@contextmanager
def damage_named(path: Path) -> Iterator[None]:
    """Turn whatever HDF5 raises over a damaged file into a ResultFileError."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise ResultFileError(f"{path}: damaged: {reason(error)}") from error


def _open_failure(error: OSError) -> str:
    text = str(error)
    if "truncated" in text:
        return "is truncated: it ends before the end that it names"
    if "lock" in text:
        return "is being written by another run"
    return f"damaged: {reason(error)}"

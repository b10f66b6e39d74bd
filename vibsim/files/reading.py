"""HDF5 files that vibsim wrote, opened for reading; whatever else is there is refused in one line."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from vibsim import __version__
from vibsim.files.attributes import read_attr, read_attrs
from vibsim.files.checking import check_datasets, check_values, checked_attributes, damaged
from vibsim.files.declarations import Attribute, Dataset
from vibsim.files.errors import ResultFileError, reason
from vibsim.files.provenance import FORMAT
from vibsim.files.signature import check_signature


def open_hdf5(path: Path) -> h5py.File:
    """Open an HDF5 file that vibsim wrote, of a format that this version reads, or raise ResultFileError."""
    check_signature(path)
    try:
        file = h5py.File(path, "r")
    except (OSError, RuntimeError) as error:
        raise ResultFileError(f"{path}: {_open_failure(error)}") from error
    try:
        with damage_named(path):
            _check_format(path, file)
    except BaseException:
        file.close()
        raise
    return file


@contextmanager
def opened(path: Path, kind: str) -> Iterator[h5py.File]:
    """The open file of a kind, such as "sweep"; ResultFileError for everything that is not one."""
    with damage_named(path), open_hdf5(path) as file:
        check_kind(path, file, kind)
        yield file


def check_kind(path: Path, file: h5py.File, kind: str) -> None:
    """Raise ResultFileError for an open file of another kind."""
    stored = read_attr(file, "vibsim_kind", "trajectory")
    if stored != kind:
        raise ResultFileError(f"{path}: holds a {stored}, not a {kind}")


def read_attributes(path: Path, file: h5py.File, declared: Sequence[Attribute]) -> dict[str, Any]:
    """The root attributes as plain values, checked. Raises ResultFileError."""
    return checked_attributes(path, read_attrs(file), declared)


def read_datasets(
    path: Path, file: h5py.File, declared: Sequence[Dataset], lengths: Mapping[str, int]
) -> dict[str, Any]:
    """What stands in each dataset, by name, checked. Raises ResultFileError."""
    check_datasets(path, file, declared, lengths)
    values = {dataset.name: read_values(file, dataset) for dataset in declared}
    for dataset in declared:
        if dataset.column.dtype != "text":
            check_values(path, dataset, values[dataset.name])
    return values


def read_values(file: h5py.File, dataset: Dataset) -> Any:
    """What stands in a dataset, as an array."""
    item = file[dataset.name]
    return item.asstr()[...] if dataset.column.dtype == "text" else item[...]


def _check_format(path: Path, file: h5py.File) -> None:
    written = read_attr(file, "vibsim_format")
    if written is None:
        raise ResultFileError(f"{path}: is an HDF5 file, but not one that vibsim wrote")
    if getattr(written, "shape", None) != () or written.dtype.kind not in "iu" or written < 1:
        raise damaged(path, "the attribute vibsim_format is not a whole number from 1 on")
    if written > FORMAT:
        version = read_attr(file, "vibsim_version", "a newer version")
        newer = f"has format {int(written)}, written by vibsim {version}"
        raise ResultFileError(f"{path}: {newer}; this is vibsim {__version__}, which reads up to {FORMAT}")


@contextmanager
def damage_named(path: Path) -> Iterator[None]:
    """Turn whatever HDF5 raises over a damaged file into a ResultFileError."""
    try:
        yield
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise damaged(path, reason(error)) from error


def _open_failure(error: Exception) -> str:
    text = str(error)
    if "truncated" in text:
        return "is truncated: it ends before the end that it names"
    if "lock" in text:
        return "is being written by another run"
    return f"damaged: {reason(error)}"

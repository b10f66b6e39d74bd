"""The check of a file against the attributes and datasets that are declared of it.

A file is checked once, when it is opened. The numbers in it are checked when they are read, by the same
declarations: a long run is not read through to look at its first second.
"""

import errno
import math
import os
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from math import ceil, isfinite, isnan, prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from h5py import h5a, h5s, h5t

from vibsim import __version__
from vibsim.cases.problems import CaseError, counted
from vibsim.results.file_contents import EXTENDED, FORMAT, LIST, NUMBER, ROWS, WHOLE, Attribute, Dataset
from vibsim.results.file_contents import TEXT as file_contents_TEXT

if TYPE_CHECKING:
    from vibsim.cases import Case


# What can go wrong with a result file, said in one line.


class ResultFileError(Exception):
    """A file that cannot be read or written: missing, foreign, damaged, too new, in the way, disk full.

    >>> import vibsim
    >>> try:
    ...     vibsim.open_result("none.h5")
    ... except vibsim.ResultFileError as error:
    ...     print(error)
    none.h5: No such file or directory
    """


def reason(error: BaseException) -> str:
    """The cause of an error in one line, without errno numbers and paths."""
    number = getattr(error, "errno", None)
    if number in DISK_FULL:
        return "disk full"
    said = error.args[0] if isinstance(error, KeyError) and error.args else error  # str() quotes a key
    text = os.strerror(number) if number else str(said) or type(error).__name__
    return text.strip().splitlines()[0]


KINDS: dict[str, Callable[[Any], bool]] = {
    file_contents_TEXT: lambda value: isinstance(value, str) and _encodable(value),
    WHOLE: lambda value: isinstance(value, int),
    NUMBER: lambda value: isinstance(value, int | float) and isfinite(value),
    EXTENDED: lambda value: isinstance(value, int | float) and not isnan(value),
    LIST: lambda value: _numbers(value, 1),
    ROWS: lambda value: _numbers(value, 2),
}


def damaged(path: object, what: str) -> ResultFileError:
    """The error that says what is wrong with a file."""
    return ResultFileError(f"{path}: damaged: {what}")


def checked_attributes(
    path: object, attrs: Mapping[str, Any], declared: Sequence[Attribute]
) -> dict[str, Any]:
    """The attributes as declared; of others, which anybody may have added, the texts and finite numbers.

    Raises ResultFileError unless those declared are there and of their kinds.
    """
    for attribute in declared:
        name, value = attribute.name, attrs.get(attribute.name)
        if value is None:
            if not attribute.optional or np.any(attrs.get(attribute.where, 0)):
                raise damaged(path, f"the attribute {name} is missing")
        elif not KINDS[attribute.kind](value):
            raise damaged(path, f"the attribute {name} is not {attribute.kind}")
        elif attribute.allowed and value not in attribute.allowed:
            raise damaged(path, f"the attribute {name} is {value}; allowed: {_listed(attribute.allowed)}")
    known = {attribute.name for attribute in declared}
    return {
        name: value
        for name, value in attrs.items()
        if _encodable(name) and (name in known or KINDS[file_contents_TEXT](value) or KINDS[NUMBER](value))
    }


def check_datasets(
    path: object, file: h5py.File, declared: Iterable[Dataset], lengths: Mapping[str, int] | None = None
) -> dict[str, int]:
    """Raise ResultFileError unless the datasets are there, of their types, shapes and wholly on file.

    lengths : of dimensions, where they are known. Returns those of all.
    """
    dimension_lengths = dict(lengths or {})
    for dataset in declared:
        item = _hard_linked(file, dataset.name)
        if not isinstance(item, h5py.Dataset):
            raise damaged(path, f"the dataset {dataset.name} is missing")
        if not _of_type(item.dtype, dtype := dataset.column.dtype):
            raise damaged(path, f"{dataset.name} holds {_type_name(item.dtype)}, not {TYPES[dtype]}")
        if item.shape is None or len(item.shape) != len(dataset.dims):
            had = "nothing" if item.shape is None else counted(len(item.shape), "dimension")
            raise damaged(path, f"{dataset.name} has {had}, not {len(dataset.dims)}")
        for dimension, length in zip(dataset.dims, item.shape, strict=True):
            if dimension_lengths.setdefault(dimension, length) != length:
                expected = f"the {dimension_lengths[dimension]} along {dimension.strip('/')}"
                raise damaged(
                    path, f"{dataset.name} has {counted(length, 'value')} where there should be {expected}"
                )
        if not _wholly_on_file(item):
            raise damaged(
                path, f"{dataset.name} claims {counted(item.size, 'value')}, more than the file holds"
            )
    return dimension_lengths


def check_values(path: object, dataset: Dataset, values: Any) -> None:
    """Raise ResultFileError where numbers read from a dataset cannot be right."""
    name, array = dataset.name, np.asarray(values)
    codes = dataset.allowed if array.dtype.kind in "iu" else frozenset()
    if codes and (wrong := set(np.unique(array).tolist()) - codes):
        raise damaged(path, f"{name} has the value {min(wrong)}; allowed: {_listed(sorted(codes))}")
    if dataset.column.dtype == "S" and not set(np.unique(array.view("u1")).tolist()) <= set(DIGITS):
        raise damaged(path, f"{name} has a text that is no number")
    if array.dtype.kind != "f" or dataset.gaps:
        return
    low, high = dataset.span
    wrong = array[~(np.isfinite(array) & (array >= low) & (array <= high))]
    if wrong.size:
        raise damaged(path, f"{name} has the value {wrong.flat[0]:g}")
    if dataset.ascending and array.ndim and (array[1:] < array[:-1]).any():
        raise damaged(path, f"{name} does not ascend")


DIGITS = b"0123456789+-.e\0"  # of a number written out, and what fills it up to its width
TYPES = {
    "f8": "numbers of 64 bits",
    "i1": "whole numbers of 8 bits",
    "i2": "whole numbers of 16 bits",
    "i4": "whole numbers of 32 bits",
    "i8": "whole numbers of 64 bits",
    "S": "texts of one length",
    "text": "texts",
}


def _of_type(dtype: np.dtype, expected: str) -> bool:
    if expected == "text":
        string = h5py.check_string_dtype(dtype)
        return string is not None and string.length is None
    return dtype.kind == expected if expected == "S" else dtype.newbyteorder("=") == np.dtype(expected)


def _type_name(dtype: np.dtype) -> str:
    if h5py.check_string_dtype(dtype):
        return "texts"
    return "references" if h5py.check_ref_dtype(dtype) else f"values of type {dtype}"


def _hard_linked(file: h5py.File, name: str) -> Any:
    """Object of that name in this very file; None for nothing, and for what a link says is elsewhere."""
    place: Any = file
    for part in name.split("/"):
        if not isinstance(place, h5py.Group) or not isinstance(place.get(part, getlink=True), h5py.HardLink):
            return None
        place = place[part]
    return place


def _wholly_on_file(item: h5py.Dataset) -> bool:
    """Whether the file has room for what a dataset says that it holds, none of it in other files."""
    if item.is_virtual or item.external:
        return False
    if item.chunks is None:
        return bool(item.id.get_storage_size() >= item.size * item.id.get_type().get_size())
    chunks = prod(ceil(length / chunk) for length, chunk in zip(item.shape, item.chunks, strict=True))
    return bool(item.id.get_num_chunks() == chunks)


def _encodable(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _numbers(value: Any, rank: int) -> bool:
    if not isinstance(value, np.ndarray) or value.ndim != rank or value.dtype.kind not in "iuf":
        return False
    return not np.isnan(value).any()


def _listed(values: Iterable[object]) -> str:
    return ", ".join(map(str, values))


# HDF5 attributes: text, whole numbers, floats and small arrays, written the direct (fast) way.


TEXT = h5py.string_dtype()
PLAIN = (h5t.TypeStringID, h5t.TypeIntegerID, h5t.TypeFloatID)


def write_attrs(location: Any, attrs: Mapping[str, Any]) -> None:
    """Write attributes of an HDF5 object (low-level id): replaces those that exist, leaves out None."""
    for name, value in attrs.items():
        if value is not None:
            _write(location, name.encode(), value)


def read_attrs(location: Any) -> dict[str, Any]:
    """Attributes of a file, group or dataset as plain values: str, int, float, or an array.

    A name that is no UTF-8, which h5py gives as bytes, is none of ours, and left out, as is what is neither
    text nor numbers.
    """
    attrs = location.attrs
    return {
        name: _plain(attrs[name]) for name in attrs if isinstance(name, str) and _of_plain_type(attrs, name)
    }


def read_attr(location: Any, name: str, otherwise: Any = None) -> Any:
    """One attribute as h5py gives it; `otherwise` where there is none of text or numbers."""
    attrs = location.attrs
    return attrs[name] if name in attrs and _of_plain_type(attrs, name) else otherwise


def _of_plain_type(attrs: Any, name: str) -> bool:
    """Whether an attribute is text or numbers. Others are not even read: by a byte of it that another program
    or a disk has changed a text becomes a list of nothing known, over which HDF5 ends the process.
    """
    return isinstance(attrs.get_id(name).get_type(), PLAIN)


def _write(location: Any, name: bytes, value: Any) -> None:
    data = np.asarray(value, TEXT if isinstance(value, str) else None, order="C")
    space = h5s.create_simple(data.shape) if data.shape else h5s.create(h5s.SCALAR)
    if h5a.exists(location, name):
        h5a.delete(location, name)
    h5a.create(location, name, h5t.py_create(data.dtype, logical=True), space).write(data)


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


# Room on disk for HDF5, made before it is needed, so that a full disk is noticed while the file is whole.
#
# A write that fails inside HDF5 leaves a file that may not open again. Room that is reserved first lets every
# later write succeed; when it cannot be reserved, nothing has been touched yet.


DISK_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


def reserve(path: Path, used: int, size: int) -> bool:
    """Reserve `size` bytes behind the first `used` bytes of a file; False without room."""
    try:
        with open(path, "r+b") as file:
            _extend(file.fileno(), used, size)
    except OSError as error:
        return error.errno not in DISK_FULL
    return True


def release(path: Path, used: int) -> None:
    """Give back what was reserved behind the first `used` bytes of a closed file."""
    if path.stat().st_size > used:
        os.truncate(path, used)


def detach(descriptor: int) -> None:
    """Let whatever is still written to an open file go to a temporary one, after a write to it has failed.

    HDF5 insists on writing what it holds when a file is closed, and brings the process down when it cannot.
    """
    from tempfile import TemporaryFile

    with TemporaryFile() as elsewhere:
        os.dup2(elsewhere.fileno(), descriptor)


def _extend(descriptor: int, start: int, count: int) -> None:
    """Allocate `count` bytes from `start`; where the system has no call for that, by writing zeros."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(descriptor, start, count)
        return
    os.lseek(descriptor, start, os.SEEK_SET)
    while count > 0:
        count -= os.write(descriptor, bytes(min(count, 1 << 20)))


# Values as plain data for JSON.


def plain(value: Any) -> Any:
    """A value for JSON: arrays as lists, null for what is not finite."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, bytes):
        return value.decode("utf-8", "backslashreplace")
    return None if isinstance(value, float) and not math.isfinite(value) else value


# The case in a result file.


WRONG = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError, CaseError)


@contextmanager
def understood(path: Path, else_damaged: str) -> Iterator[None]:
    """Turn whatever is raised over data that make no sense into a ResultFileError that says so."""
    try:
        yield
    except WRONG as error:
        raise damaged(path, else_damaged) from error


def stored_case(path: Path, attrs: Mapping[str, Any]) -> "Case":
    """The case that the attributes of a file describe. Raises ResultFileError where they do not."""
    from vibsim.cases import Case

    try:
        case = Case.from_resolved_json(attrs["case_resolved_json"])
    except CaseError as error:
        problem = error.problems[0]
        key = f"{problem.key}: " if problem.key else ""
        raise damaged(path, f"the attribute case_resolved_json: {key}{problem.message}") from error
    except RecursionError as error:
        raise damaged(path, "the attribute case_resolved_json is nested too deep") from error
    return replace(case, text=attrs["case_yaml"], source=str(path))


# HDF5 files that vibsim wrote, opened for reading; whatever else is there is refused in one line.


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
    """Values of each dataset, by name, checked. Raises ResultFileError."""
    check_datasets(path, file, declared, lengths)
    values = {dataset.name: read_values(file, dataset) for dataset in declared}
    for dataset in declared:
        if dataset.column.dtype != "text":
            check_values(path, dataset, values[dataset.name])
    return values


def read_values(file: h5py.File, dataset: Dataset) -> Any:
    """Values of a dataset, as an array."""
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


# How HDF5 files begin; told without loading HDF5.


SIGNATURE = b"\x89HDF\r\n\x1a\n"


def check_signature(path: Path) -> None:
    """Raise ResultFileError unless `path` is a readable file that begins as an HDF5 file does."""
    try:
        if not stat.S_ISREG(mode := os.stat(path).st_mode) and not stat.S_ISDIR(mode):
            raise ResultFileError(f"{path}: is not a regular file")
        with open(path, "rb") as file:
            start = file.read(len(SIGNATURE))
    except (OSError, ValueError) as error:
        raise ResultFileError(f"{path}: {reason(error)}") from error
    if not start:
        raise ResultFileError(f"{path}: is empty")
    if start != SIGNATURE:
        raise ResultFileError(f"{path}: is not an HDF5 file")

"""The check of a file against the attributes and datasets that are declared of it.

A file is checked once, when it is opened. The numbers in it are checked when they are read, by the same
declarations: a long run is not read through to look at its first second.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import ceil, isfinite, isnan, prod
from typing import Any

import h5py
import numpy as np

from vibsim.files.declarations import (
    EXTENDED,
    LIST,
    NUMBER,
    ROWS,
    TEXT,
    WHOLE,
    Attribute,
    Dataset,
)
from vibsim.files.errors import ResultFileError

KINDS: dict[str, Callable[[Any], bool]] = {
    TEXT: lambda value: isinstance(value, str) and _encodable(value),
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
        if _encodable(name) and (name in known or KINDS[TEXT](value) or KINDS[NUMBER](value))
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
            had = "nothing" if item.shape is None else f"{len(item.shape)}"
            raise damaged(path, f"{dataset.name} has {had} dimensions, not {len(dataset.dims)}")
        for dimension, length in zip(dataset.dims, item.shape, strict=True):
            if dimension_lengths.setdefault(dimension, length) != length:
                expected = f"the {dimension_lengths[dimension]} along {dimension.strip('/')}"
                raise damaged(path, f"{dataset.name} has {length} values where there should be {expected}")
        if not _wholly_on_file(item):
            raise damaged(path, f"{dataset.name} claims {item.size} values, more than the file holds")
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
    """What has the name in this very file; None for nothing, and for what a link says is elsewhere."""
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

"""Plans and records as plain data for JSON, and back, by the fields of their dataclasses.

int, float, bool, str      as they are
complex                    [real part, imaginary part]
Fraction                   the shortest exact text
array of doubles           hex digits, five times as fast as decimals
tuple, NamedTuple          a list
dict[str, ...]             an object
a dataclass                an object, by the names of its fields; see `stored` for other forms
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from fractions import Fraction
from functools import cache
from types import NoneType
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np

from vibsim.cases.quantities import decimal_text, exact_number


class StoredField(NamedTuple):
    """How a field of a dataclass is stored.

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
    plain, whole = {}, type(value)
    for name, kind, form in _fields(whole):  # type: ignore[arg-type]
        if form.name is not None:
            here = getattr(value, name)
            plain[form.name or name] = form.write(here) if form.write else _written(kind, here)
    return plain


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

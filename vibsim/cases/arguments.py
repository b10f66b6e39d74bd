"""Arguments of Python calls, checked at the edge: an error names the argument and what it may be."""

from collections.abc import Iterable, Mapping
from operator import index
from typing import Any


def whole_number(name: str, value: Any, least: int) -> int:
    """A whole number, at least `least`. Raises TypeError for what is none, ValueError for a lesser one."""
    try:
        number = index(value)
    except TypeError:
        number = None
    if number is None or isinstance(value, bool):
        raise TypeError(f"{name} must be a whole number, got {value!r:.60}")
    if number < least:
        raise ValueError(f"{name} must be at least {least}, got {number}")
    return number


def by_key(name: str, values: Any, example: str) -> Mapping[str, Any]:
    """Values by keys of a case; None: none. Raises TypeError for what is no dict."""
    if values is None:
        return {}
    if not isinstance(values, Mapping) or not all(isinstance(key, str) for key in values):
        raise TypeError(f"{name} must be a dict such as {example}, got {values!r:.60}")
    return values


def texts(name: str, values: Any) -> list[str]:
    """Texts, or one of them. Raises TypeError for anything else."""
    listed = (
        [values] if isinstance(values, str) else list(values) if isinstance(values, Iterable) else [values]
    )
    for value in listed:
        if not isinstance(value, str):
            raise TypeError(f"{name} must be a text or a list of texts, got {value!r:.60}")
    return listed

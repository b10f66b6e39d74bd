"""Rows of a table that lie within a span of time."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from typing import Any

Window = tuple[float, float]


def rows_within(time: Sequence[float] | Any, window: Window) -> slice:
    """Rows whose ascending `time` [s] lies within the window, both ends included."""
    return slice(bisect_left(time, window[0]), bisect_right(time, window[1]))


def pieces(rows: slice, length: int) -> Iterator[slice]:
    """The rows in pieces of at most `length`."""
    for start in range(rows.start, rows.stop, length):
        yield slice(start, min(start + length, rows.stop))

"""Rows of a table that lie within a span of time."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from typing import Any

Window = tuple[float, float]


def read_window(window: object) -> Window:
    """A span of time [s] as a user writes it: (100, 110), or the text `100:110`, `:20` or `100:`.

    An open end is infinite. Raises ValueError for anything else, and for a span without length.
    """
    if isinstance(window, str):
        return _ordered(_ends_of(window), f"{window}")
    try:
        first, last = (float(instant) for instant in window)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        words = 'a span is (first, last) in seconds, or a text such as "100:110"'
        raise ValueError(f"{words}, got {window!r:.60}") from None
    return _ordered((first, last), f"{first:g}:{last:g}")


def _ends_of(text: str) -> Window:
    first, colon, last = text.partition(":")
    try:
        span = (float(first) if first.strip() else -math.inf, float(last) if last.strip() else math.inf)
    except ValueError:
        span = (math.nan, math.nan)
    if not colon or math.isnan(span[0]) or math.isnan(span[1]):
        raise ValueError(f"{text!r} is not a span: write FIRST:LAST in seconds, such as 100:110")
    return span


def _ordered(span: Window, text: str) -> Window:
    if not span[0] < span[1]:
        raise ValueError(f"the span {text} is empty: its first instant must come before its last")
    return span


def rows_within(time: Sequence[float] | Any, window: Window) -> slice:
    """Rows whose ascending `time` [s] lies within the window, both ends included."""
    return slice(bisect_left(time, window[0]), bisect_right(time, window[1]))


def pieces(rows: slice, length: int) -> Iterator[slice]:
    """The rows in pieces of at most `length`."""
    for start in range(rows.start, rows.stop, length):
        yield slice(start, min(start + length, rows.stop))

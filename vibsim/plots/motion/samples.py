"""Samples of a run, read window by window and block by block, so that memory does not grow with the file."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from vibsim.plots.errors import PlotError
from vibsim.plots.motion.envelope import Envelope
from vibsim.plots.motion.natural_frequencies import shortest_period
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span

BLOCK = 1 << 18  # rows: 2 MB per column
SHORTEST = 10  # windows without samples to the shortest period, at most
POINTS_PER_COLUMN = 4  # what an envelope keeps; a series shorter than that is drawn as it is

Series = tuple[np.ndarray, np.ndarray]


def whole_span(result: Any) -> Span:
    """First and last sampled instant [s]."""
    time = result.column("time")
    if len(time) < 2:
        raise PlotError(f"{result.case.name}: the run holds {len(time)} samples: nothing to draw")
    return float(time[0]), float(time[-1])


def window_of(subject: Subject, asked: Span | None) -> Span:
    """The part of `asked` (None: everything) that the run covers; PlotError when it covers nothing of it."""
    first, last = whole_span(subject.result)
    if asked is None:
        return first, last
    window = max(first, asked[0]), min(last, asked[1])
    if not window[0] < window[1]:
        covered = f"{subject.path}, which covers {first:g} to {last:g} s"
        raise PlotError(f"window {asked[0]:g}:{asked[1]:g} lies outside {covered}")
    _check_length(subject, window)
    return window


def _check_length(subject: Subject, window: Span) -> None:
    """PlotError for a window of fewer than two samples in which hardly anything moves: an empty picture."""
    within, period = rows(subject.result, window), shortest_period(subject.scene)
    if within.stop - within.start < 2 and (period is None or window[1] - window[0] < period / SHORTEST):
        shown = f"{window[0]:.9g}:{window[1]:.9g}"
        raise PlotError(f"window {shown} is too short: {subject.path} has nothing to draw in it")


def shown(subject: Subject, asked: Span | None, fallback: Callable[[Subject, Span], Span]) -> Span:
    """The part of `asked` that the run covers; without a wish, what `fallback` makes of all."""
    window = window_of(subject, asked)
    return fallback(subject, window) if asked is None else window


def common_window(subjects: Sequence[Subject], asked: Span | None) -> Span:
    """From the earliest to the latest instant that any of the subjects shows of `asked`."""
    windows = [window_of(subject, asked) for subject in subjects]
    return min(first for first, _ in windows), max(last for _, last in windows)


def shared_window(subjects: Sequence[Subject], asked: Span | None) -> Span:
    """The span that all the subjects cover, of `asked`."""
    windows = [window_of(subject, asked) for subject in subjects]
    return max(first for first, _ in windows), min(last for _, last in windows)


def rows(result: Any, span: Span) -> slice:
    """The samples within the span, both ends included."""
    time = result.column("time")
    return slice(bisect_left(time, span[0]), bisect_right(time, span[1]))


def blocks(result: Any, names: tuple[str, ...], span: Span) -> Iterator[dict[str, np.ndarray]]:
    """The samples within the span: blocks of columns by name, each up to BLOCK rows."""
    within = rows(result, span)
    for start in range(within.start, within.stop, BLOCK):
        part = slice(start, min(start + BLOCK, within.stop))
        yield {name: np.asarray(result.column(name)[part]) for name in names}


def samples(result: Any, names: tuple[str, ...], span: Span) -> dict[str, np.ndarray]:
    """All samples within the span, for spans known to be short."""
    within = rows(result, span)
    return {name: np.asarray(result.column(name)[within]) for name in names}


def series(result: Any, names: tuple[str, ...], span: Span, columns: int) -> dict[str, Series]:
    """Columns against time within the span, (t, values); envelopes where there is more than can be seen.

    columns : pixel columns across the axes
    """
    within = rows(result, span)
    if within.stop - within.start <= POINTS_PER_COLUMN * columns:
        values = samples(result, ("time", *names), span)
        return {name: (values["time"], values[name]) for name in names}
    envelopes = {name: Envelope(*span, columns) for name in names}
    for block in blocks(result, ("time", *names), span):
        for name, envelope in envelopes.items():
            envelope.add(block["time"], block[name])
    return {name: envelope.points() for name, envelope in envelopes.items()}

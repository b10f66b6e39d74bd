"""A short stretch of a run as smooth as the motion: samples, events, and instants between them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vibsim.plots.natural_frequencies import shortest_period
from vibsim.plots.samples import rows, samples
from vibsim.plots.view import Span

PER_PERIOD = 40  # instants per shortest period: chords of 9 degrees, round at any print size
AT_MOST = 40_000  # instants to be evaluated


def dense(result: Any, names: tuple[str, ...], span: Span) -> dict[str, np.ndarray]:
    """Columns `time` and `names` within the span, with the events and as many instants between as the motion needs.

    Every sample and every event within the span is among the rows, as stored; the instants between are evaluated by the
    engine (`result.at`). A span too long for that comes back as samples alone.
    """
    stored = samples(result, ("time", *names), span)
    between = _instants_between(result, stored["time"], span)
    if between is None:
        return stored
    t = np.asarray(result.events["t"])
    marked = (t >= span[0]) & (t <= span[1])
    events = {"time": t[marked], **{name: np.asarray(result.events[name])[marked] for name in names}}
    evaluated = {"time": between, **(result.at(between) if len(between) else events)}
    if not len(between):
        evaluated = {name: np.empty(0) for name in stored}
    time = np.concatenate([stored["time"], events["time"], evaluated["time"]])
    order = np.argsort(time, kind="stable")
    return {
        name: np.concatenate([stored[name], events[name], np.asarray(evaluated[name])])[order] for name in stored
    }


def is_short(result: Any, span: Span) -> bool:
    """Whether a span is short enough to be made dense."""
    within = rows(result, span)
    return within.stop - within.start <= AT_MOST


def _instants_between(result: Any, time: np.ndarray, span: Span) -> np.ndarray | None:
    """Equally spaced instants between the samples [s]; None when there would be too many."""
    period = shortest_period(result.case.scene())
    knots = np.unique(np.concatenate([[span[0]], time, [span[1]]]))
    if period is None or len(knots) < 2:
        return np.empty(0)
    pieces = np.maximum(np.ceil(PER_PERIOD * np.diff(knots) / period), 1)
    if pieces.sum() > AT_MOST:
        return None
    parts = [np.linspace(a, b, int(n) + 1)[1:-1] for a, b, n in zip(knots[:-1], knots[1:], pieces, strict=True)]
    return np.concatenate(parts) if parts else np.empty(0)

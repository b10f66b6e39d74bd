"""Events of a run within a span, and the impacts among them: the instants at which contact begins."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import Any

import numpy as np

from vibsim.physics.modes import EVENT_KINDS
from vibsim.plots.view import Span

Events = dict[str, np.ndarray]


def events_within(result: Any, names: tuple[str, ...] | None, span: Span, before: int = 0) -> Events:
    """Event columns by name within the span, both ends included; of a file only those rows are read.

    Parameters
    ----------
    names : columns, or None for all
    before : how many events before the span to add, as far as there are any
    """
    column = getattr(result.events, "column", result.events.__getitem__)
    t = column("t")
    within = slice(max(0, bisect_left(t, span[0]) - before), bisect_right(t, span[1]))
    return {name: np.asarray(column(name)[within]) for name in (result.events if names is None else names)}


def events_of(result: Any, kind: str, span: Span, *names: str) -> tuple[np.ndarray, ...]:
    """Times [s] and the columns `names` of the events of one kind (see EVENT_KINDS) within the span."""
    events = events_within(result, ("t", "kind", *names), span)
    rows = events["kind"] == EVENT_KINDS[kind]
    return (events["t"][rows], *(events[name][rows] for name in names))


def impact_times(result: Any, span: Span) -> np.ndarray:
    """Instants of the impacts within the span [s], ascending."""
    return events_of(result, "contact_begin", span)[0]


def contact_spans(result: Any, span: Span) -> list[Span]:
    """The stretches of contact that meet the span, cut to it [s]."""
    events = events_within(result, ("t", "contact"), span, before=1)
    ends = np.append(events["t"][1:], span[1])
    stretches = [(max(a, span[0]), min(b, span[1])) for a, b in zip(events["t"], ends, strict=True)]
    return [(a, b) for (a, b), contact in zip(stretches, events["contact"], strict=True) if contact and a < b]

"""Impacts of a run: the instants at which contact begins, and the state there."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibsim.physics.modes import EVENT_KINDS
from vibsim.plots.view import Span


def events_of(result: Any, kind: str, span: Span, *names: str) -> tuple[np.ndarray, ...]:
    """Times [s] and the columns `names` of the events of one kind (see EVENT_KINDS) within the span."""
    t = np.asarray(result.events["t"])
    rows = (np.asarray(result.events["kind"]) == EVENT_KINDS[kind]) & (t >= span[0]) & (t <= span[1])
    return (t[rows], *(np.asarray(result.events[name])[rows] for name in names))


def impact_times(result: Any, span: Span) -> np.ndarray:
    """Instants of the impacts within the span [s], ascending."""
    return events_of(result, "contact_begin", span)[0]


def contact_spans(result: Any, span: Span) -> list[Span]:
    """The stretches of contact that meet the span, cut to it [s]."""
    begin, = events_of(result, "contact_begin", (-np.inf, span[1]))
    end, = events_of(result, "contact_end", (-np.inf, np.inf))
    following = np.searchsorted(end, begin)
    ends = np.append(end, np.inf)[following]
    return [(max(a, span[0]), min(b, span[1])) for a, b in zip(begin, ends, strict=True) if b > span[0]]

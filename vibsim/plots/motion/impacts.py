"""Events of a run within a span, and the impacts among them: contact begins, or a rigid stop is struck."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import Any

import numpy as np

from vibsim.engine.columns import part_columns
from vibsim.engine.modes.status import CONTACT, RESTING
from vibsim.physics.parts import Scene, columns_of
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span
from vibsim.results.motion.closing_velocity import IMPACT_CODES

Events = dict[str, np.ndarray]
PUSHING = (CONTACT, RESTING)  # a lifted stop exerts no force


def events_within(result: Any, names: tuple[str, ...] | None, span: Span, before: int = 0) -> Events:
    """Event columns by name within the span, both ends included; of a file only those rows are read.

    Parameters
    ----------
    names : columns, or None for all
    before : how many events before the span to add, as far as there are any
    """
    column = getattr(result.events, "column", result.events.__getitem__)
    t = column("t")
    first = max(0, bisect_left(t, span[0]) - before)
    if before and first:
        first = bisect_left(t, t[first])  # all events of that instant
    within = slice(first, bisect_right(t, span[1]))
    return {name: np.asarray(column(name)[within]) for name in (result.events if names is None else names)}


def impact_events(result: Any, span: Span, *names: str) -> tuple[np.ndarray, ...]:
    """Times [s] and the columns `names` of the impacts within the span."""
    events = events_within(result, ("t", "kind", *names), span)
    rows = np.isin(events["kind"], IMPACT_CODES)
    return (events["t"][rows], *(events[name][rows] for name in names))


def impact_times(result: Any, span: Span) -> np.ndarray:
    """Instants of the impacts within the span [s], ascending."""
    return impact_events(result, span)[0]


def impacts_of(subject: Subject, span: Span, column: str, *others: str) -> tuple[np.ndarray, ...]:
    """Times [s] and columns of the impacts within the span in which the body of `column` takes part."""
    t, part, *values = impact_events(subject.result, span, "part", column, *others)
    rows = np.isin(part, stops_of(subject.scene, column))
    return (t[rows], *(value[rows] for value in values))


def stops_of(scene: Scene, column: str) -> list[int]:
    """Numbers of the stops that end at the body of a column of states."""
    own = [i for i, body in enumerate(scene.bodies) if column in columns_of(body.name)]
    return [number for number, stop in enumerate(scene.stops) if {stop.P, stop.Q} & set(own)]


def contact_spans(subject: Subject, span: Span) -> list[Span]:
    """The stretches of contact, or of rest, at any stop that meet the span, cut to it [s]."""
    names = part_columns(subject.scene)[: len(subject.scene.stops)]
    events = events_within(subject.result, ("t", *names), span, before=1)
    touching = [np.isin(events[name], PUSHING) for name in names]
    contact = np.any(touching, axis=0)
    ends = np.append(events["t"][1:], span[1])
    stretches = [(max(a, span[0]), min(b, span[1])) for a, b in zip(events["t"], ends, strict=True)]
    return [(a, b) for (a, b), closed in zip(stretches, contact, strict=True) if closed and a < b]

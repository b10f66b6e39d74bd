"""A short stretch of a run as smooth as the motion: samples, events, and instants between them."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibsim.plots.motion.impacts import events_within
from vibsim.plots.motion.natural_frequencies import shortest_period, source_period
from vibsim.plots.motion.samples import samples
from vibsim.plots.view import Span

PER_PERIOD = 40  # instants per shortest period: chords of 9 degrees, round at any print size
AT_MOST = 40_000  # instants to be evaluated


def dense(
    result: Any, names: tuple[str, ...], span: Span, step: float | None = None
) -> dict[str, np.ndarray]:
    """Columns `time` and `names` within the span, the events, and instants between them.

    Every sample and every event within the span is among the rows, as stored, and before an event at which
    velocities jump the state in front of it; the instants between are evaluated by the engine, further
    apart where the span is too long for all of them. A span with too many events comes back as samples alone.
    """
    names = tuple(name for name in names if name != "time")
    stored = samples(result, ("time", *names), span)
    if len(events_within(result, ("t",), span)["t"]) > AT_MOST:
        return stored
    between = _instants_between(stored["time"], span, step or _fine_step(result.case.scene()))
    between = between[between <= result.t_reached]  # of a run that was killed, samples may reach further
    before, after = _event_rows(result, names, span)
    # a sample at the instant of an event is the state after it
    parts = [before, stored, after, {**states_at(result, names, between), "time": between}]
    order = np.argsort(np.concatenate([part["time"] for part in parts]), kind="stable")
    return {name: np.concatenate([part[name] for part in parts])[order] for name in stored}


def _event_rows(result: Any, names: tuple[str, ...], span: Span) -> tuple[dict[str, np.ndarray], ...]:
    """Columns `time` and `names` of the events within the span: the states in front of them, and after."""
    before = {name: f"before_{name}" for name in names if f"before_{name}" in result.events}
    events = events_within(result, ("t", *names, *before.values()), span)
    after = {"time": events["t"], **{name: events[name] for name in names}}
    if not before:
        return {name: values[:0] for name, values in after.items()}, after
    return after | {name: events[column] for name, column in before.items()}, after


def states_at(result: Any, names: tuple[str, ...], times: np.ndarray) -> dict[str, np.ndarray]:
    """Columns `names` at ascending instants `times` (n) [s], the engine restarted from stored events.

    As `result.at`, but of a file only the events between the first and the last instant are read.
    """
    from vibsim.results.restart import states_at as restarted

    if not len(times):
        return {name: np.empty(0) for name in names}
    events = events_within(result, None, (float(times[0]), float(times[-1])), before=1)
    states = restarted(result.case.scene(), events, times, result.t_reached)
    return {name: states[name] for name in names}


def samples_are_sparse(scene: Any) -> bool:
    """Whether a line through the samples would miss vibrations: fewer than four to a period of the source."""
    period = source_period(scene)
    return period is not None and scene.sample_time(1) > period / 4


def _fine_step(scene: Any) -> float | None:
    period = shortest_period(scene)
    return None if period is None else period / PER_PERIOD


def _instants_between(time: np.ndarray, span: Span, step: float | None) -> np.ndarray:
    """Equally spaced instants between the samples [s], at most about AT_MOST."""
    knots = np.unique(np.concatenate([[span[0]], time, [span[1]]]))
    if step is None:
        return np.empty(0)
    pieces = np.maximum(np.ceil(np.diff(knots) / step), 1)
    if pieces.sum() > AT_MOST:
        pieces = np.maximum(np.floor(pieces * (AT_MOST / pieces.sum())), 1)
    parts = [
        np.linspace(a, b, int(n) + 1)[1:-1] for a, b, n in zip(knots[:-1], knots[1:], pieces, strict=True)
    ]
    return np.concatenate([np.empty(0), *parts])

"""The stops in the plane of a relative motion, and what motions of two ends against each other are called."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.engine.columns import part_columns
from vibsim.engine.modes.status import CONTACT, RESTING
from vibsim.physics.parts import BASE, GROUND, RigidStop, Scene, Stop, columns_of
from vibsim.physics.rates import motor_columns, turning_columns
from vibsim.physics.two_blocks import is_papers
from vibsim.plots.samples import BLOCK, rows, shared_window, source_period
from vibsim.plots.sheet import Scale, as_text, seconds, symbol
from vibsim.plots.style import GREY, points
from vibsim.plots.subject import Subject
from vibsim.plots.view import PlotError, Span, View
from vibsim.results.columns import IMPACT_CODES

DISPLACEMENT = "$x_1 - x_2$"
VELOCITY = "$v_1 - v_2$"
STOP = "stop"  # what the short form of a case calls its stop
PAPERS = (STOP, "coupling")  # and all that is between its blocks


def difference(scene: Scene, part: Any, letter: str) -> str:
    """x_P - x_Q, or with v, in symbols; a term at rest left out, the base in capitals."""
    if part.name in PAPERS and is_papers(scene):
        return {"x": DISPLACEMENT, "v": VELOCITY}[letter]  # a fixed block 2 too
    first, second = (
        "" if end == GROUND else letter.upper() if end == BASE else _symbol(scene, end, letter)
        for end in (part.P, part.Q)
    )
    return f"${first} - {second}$" if first and second else f"${first}$" if first else f"$-{second}$"


def _symbol(scene: Scene, end: int, letter: str) -> str:
    return symbol(f"{letter}_{scene.end_name(end)}").strip("$")


def stop_position(stop: Stop | RigidStop, part: Any) -> float:
    """Where x_P - x_Q of a part between the same ends meets the stop [m]."""
    position = -stop.sense * stop.gap
    return float(position if stop.P == part.P else -position)


def stops_between(scene: Scene, part: Any) -> list[Stop | RigidStop]:
    """The stops between the ends of a part."""
    return [stop for stop in scene.stops if {stop.P, stop.Q} == {part.P, part.Q}]


def stop_label(stop: Stop | RigidStop) -> str:
    """What a stop is called beside its line: its name; the paper's is told by its equation."""
    if stop.name != STOP:
        return as_text(stop.name)
    return "$x_2 - x_1 = G$" if stop.sense > 0 else "$x_1 - x_2 = G$"


def draw_stop_line(axes: Axes, position: float, scale: Scale, text: str) -> None:
    """A stop at a relative displacement [m] as a dashed line across the axes, a text above it."""
    at = float(scale(position))
    axes.axvline(at, color=GREY, linewidth=0.6, linestyle=(0, (4, 2)), zorder=0, gid="stop")
    if text:
        axes.annotate(
            text, (at, 1), (0, 2), xycoords=("data", "axes fraction"), textcoords="offset points",
            ha="center", va="bottom", fontsize=points(7), color=GREY,
        )  # fmt: skip


# Events of a run within a span, and the impacts among them: contact begins, or a rigid stop is struck.


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
    own = [i for i, body in enumerate(scene.line) if column in columns_of(body.name)]
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


# Spans of time that suit a picture: the detail of a history, the steady end of a run.


DETAIL_PERIODS = 10
STEADY_PERIODS = 50
PERIODS_AT_MOST = 5000  # in the last half of a run, as far as it is shown by default


def period_of(subject: Subject, span: Span) -> float:
    """Period of the source [s], the motor's at the end of the span; a tenth of the span without rhythm."""
    phidot, turning = None, motor_columns(subject.scene) or turning_columns(subject.scene)
    if turning is not None:
        stop = rows(subject.result, span).stop
        tail = slice(max(0, stop - min(1000, BLOCK)), stop)
        phidot = float(np.mean(subject.result.column(turning[1])[tail]))
    return source_period(subject.scene, phidot) or (span[1] - span[0]) / 10


def round_number(length: float) -> float:
    """The nearest of 1, 2, 5, 10, 20, ... by ratio."""
    decade = 10.0 ** math.floor(math.log10(length))
    return min((step * decade for step in (1, 2, 5, 10)), key=lambda number: abs(math.log(number / length)))


def steady_span(subject: Subject, window: Span, periods: int = STEADY_PERIODS) -> Span:
    """The last `periods` of the source within the window, as a round number of seconds."""
    length = round_number(periods * period_of(subject, window))
    return max(window[0], window[1] - length), window[1]


def last_half(subject: Subject, window: Span) -> Span:
    """The second half of the run, at most its last 5000 periods; all of an orbit, which is settled."""
    if subject.holds_orbit:
        return window
    longest = PERIODS_AT_MOST * period_of(subject, window)
    return max((window[0] + window[1]) / 2, window[1] - longest), window[1]


def detail_span(subjects: Sequence[Subject], view: View) -> Span:
    """The span to enlarge: the view's detail, or the last ten periods in which the first run has impacts.

    Raises PlotError when the view's detail lies outside what is shown of every run.
    """
    window = shared_window(subjects, view.window)
    if view.detail is not None:
        return _within(window, view.detail)
    subject = subjects[0]
    length = round_number(DETAIL_PERIODS * period_of(subject, window))
    end = window[1]
    times = impact_times(subject.result, window) if subject.scene.has_stop else np.empty(0)
    if len(times) and times[-1] < end - length:
        end = min(end, float(times[-1]) + length / 5)
    return max(window[0], end - length), end


def _within(window: Span, asked: Span) -> Span:
    span = max(window[0], asked[0]), min(window[1], asked[1])
    if not span[0] < span[1]:
        raise PlotError(f"detail {asked[0]:g}:{asked[1]:g} lies outside what is shown, {seconds(window)}")
    return span

"""Spans of time that suit a picture: the detail of a history, the steady end of a run."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vibsim.plots.errors import PlotError
from vibsim.plots.motion.impacts import impact_times
from vibsim.plots.motion.natural_frequencies import source_period
from vibsim.plots.motion.samples import BLOCK, rows, shared_window
from vibsim.plots.page.quantities import seconds
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View

DETAIL_PERIODS = 10
STEADY_PERIODS = 50
PERIODS_AT_MOST = 5000  # in the last half of a run, as far as it is shown by default


def period_of(subject: Subject, span: Span) -> float:
    """Period of the source [s], the motor's at the end of the span; a tenth of the span without rhythm."""
    phidot = None
    if subject.scene.has_motor:
        stop = rows(subject.result, span).stop
        tail = slice(max(0, stop - min(1000, BLOCK)), stop)
        phidot = float(np.mean(subject.result.column("phidot")[tail]))
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

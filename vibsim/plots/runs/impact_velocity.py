"""Velocity at which the blocks meet the stop: over time, over the source's phase, and its histogram."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibsim.physics.period import common_period
from vibsim.plots.motion.impacts import events_within
from vibsim.plots.motion.samples import common_window, shown, window_of
from vibsim.plots.motion.spans import last_half
from vibsim.plots.motion.time_marks import trust_marks
from vibsim.plots.page.quantities import Scale, scale_for, seconds
from vibsim.plots.page.sheet import legend_above, letter_panels, note, sheet, time_axis
from vibsim.plots.style import BLUE, GREY, dot_size, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View
from vibsim.results.motion.closing_velocity import closing_velocities

BINS = 40
THINNEST = 0.012  # of the greatest velocity: a bar that can be seen
LONGEST_NOTE = 10  # characters above the narrow histogram
HEADROOM = 1.1  # beyond the longest bar of the histogram, and above the fastest impact
CLOSING = "Closing velocity"


@dataclass(frozen=True)
class Impacts:
    """Instants [s], closing velocities [m/s] (into the stop: > 0), phases of the source [turns]; (n)."""

    t: np.ndarray
    closing: np.ndarray
    phase: np.ndarray | None

    def within(self, span: Span) -> Impacts:
        """Those within a span [s]."""
        inside = (self.t >= span[0]) & (self.t <= span[1])
        return Impacts(
            self.t[inside], self.closing[inside], self.phase[inside] if self.phase is not None else None
        )


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Closing velocity of each impact against time; of a settled motion its histogram and phase.

    Histogram and phases are those of the last half of the run, unless the view has a window.
    """
    window = common_window(subjects, view.window)
    of_subjects = [impacts_of(subject, window_of(subject, window)) for subject in subjects]
    spans = [_settled(subject, view, impacts) for subject, impacts in zip(subjects, of_subjects, strict=True)]
    settled = [impacts.within(span) for impacts, span in zip(of_subjects, spans, strict=True)]
    scale = scale_for("m/s", *(impacts.closing for impacts in of_subjects))
    with_phase = any(impacts.phase is not None for impacts in of_subjects)
    figure = sheet(view, 8.8 if with_phase else 5.0)
    grid = figure.add_gridspec(2 if with_phase else 1, 2, width_ratios=(4, 1))
    over_time = figure.add_subplot(grid[0, 0])
    histogram = figure.add_subplot(grid[0, 1], sharey=over_time)
    over_phase = figure.add_subplot(grid[1, :]) if with_phase else None
    colours = [overlay(i)["color"] for i in range(len(subjects))] if len(subjects) > 1 else [BLUE]
    for subject, impacts, late, colour in zip(subjects, of_subjects, settled, colours, strict=True):
        _dots(over_time, impacts.t, scale(impacts.closing), colour, subject.name)
        _histogram(histogram, scale(late.closing), colour, filled=len(subjects) == 1)
        if over_phase is not None and late.phase is not None:
            _dots(over_phase, 360 * late.phase, scale(late.closing), colour, subject.name)
    _finish(over_time, histogram, over_phase, scale, window)
    _say(subjects, (over_time, histogram, over_phase), (window, spans), settled, colours)
    if len(subjects) > 1:
        legend_above(over_time, markerscale=5)
    letter_panels([axes for axes in (over_time, histogram, over_phase) if axes is not None])
    return figure


def _settled(subject: Subject, view: View, impacts: Impacts) -> Span:
    """The part of the run of which phases and frequencies are shown: the last half, or the view's window.

    All of the run where the last half has no impacts.
    """
    span = shown(subject, view.window, last_half)
    return span if len(impacts.within(span).t) else window_of(subject, view.window)


def _say(
    subjects: Sequence[Subject],
    panels: tuple[Axes, Axes, Axes | None],
    spans: tuple[Span, Sequence[Span]],
    settled: Sequence[Impacts],
    colours: Sequence[Any],
) -> None:
    """Marks of the trust horizons, and above each panel what it shows."""
    over_time, histogram, over_phase = panels
    lines = colours if len(subjects) > 1 else [GREY]
    trust = trust_marks(over_time, subjects, spans[0], lines)
    count = sum(len(impacts.t) for impacts in settled)
    words = f"{count} impact{'' if count == 1 else 's'}"
    listed = "; ".join(dict.fromkeys(map(seconds, spans[1])))
    if over_phase is None:
        note(over_time, "; ".join(filter(None, [trust, f"histogram: {words}, {listed}"])))
        return
    note(over_time, trust)
    note(over_phase, f"{words}, {listed}")
    if len(listed) <= LONGEST_NOTE:
        note(histogram, listed)


def impacts_of(subject: Subject, span: Span) -> Impacts:
    """The impacts of a run within the span, at all its stops; the phase is that of the common period of the
    forces and the base, or the angle of the rotor.
    """
    scene = subject.scene
    events = events_within(subject.result, None, span)
    t, closing = events["t"], closing_velocities(scene, events)
    rows, period = ~np.isnan(closing), common_period(scene)
    t, closing = t[rows], closing[rows]
    if scene.has_motor:
        return Impacts(t, closing, np.mod(events["phi"][rows] / (2 * math.pi), 1.0))
    if period is not None:
        turns = t * period.cycles + t * period.cycles_lo
        return Impacts(t, closing, np.mod(turns / period.turns, 1.0))
    return Impacts(t, closing, None)


def _dots(axes: Axes, x: np.ndarray, y: np.ndarray, colour: str, label: str) -> None:
    axes.plot(
        x, y, linestyle="none", marker="o", markersize=dot_size(len(x)), markeredgewidth=0, color=colour,
        label=label, gid="impacts", rasterized=len(x) > 5_000, clip_on=not len(x),
        zorder=2.6,
    )  # fmt: skip


def _histogram(axes: Axes, values: np.ndarray, colour: str, filled: bool) -> None:
    if len(values):
        counts, edges = np.histogram(values, *_bins(values))
        axes.stairs(counts, edges, orientation="horizontal", fill=filled, color=colour, linewidth=0.7)


def _bins(values: np.ndarray) -> tuple[int, tuple[float, float]]:
    """Number and range of the bins, of which none is too thin to be seen."""
    low, high = float(values.min()), float(values.max())
    thinnest = THINNEST * high
    bins = max(1, min(BINS, int((high - low) / thinnest))) if thinnest > 0 else BINS
    room = max(0.0, bins * thinnest - (high - low)) / 2
    return bins, (low - room, high + room)


def _finish(over_time: Axes, histogram: Axes, over_phase: Axes | None, scale: Scale, window: Span) -> None:
    over_time.set_ylabel(scale.label(CLOSING))
    time_axis(over_time, window)
    histogram.tick_params(labelleft=False)
    histogram.set_xlabel("Count")
    histogram.set_xlim(0, HEADROOM * max(histogram.get_xlim()[1], 1))
    histogram.xaxis.set_major_locator(MaxNLocator(2, integer=True))
    over_time.set_ylim(0, max(over_time.get_ylim()[1], HEADROOM * over_time.dataLim.y1))
    if over_phase is not None:
        over_phase.set_xlim(0, 360)
        over_phase.set_xticks(range(0, 361, 60))
        over_phase.set_ylim(over_time.get_ylim())
        over_phase.set_xlabel("Phase of the source at impact (°)")
        over_phase.set_ylabel(scale.label(CLOSING))

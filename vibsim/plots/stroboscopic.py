"""Stroboscopic section of the relative motion: the state once per period of the source."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.quantities import Scale, scale_for, seconds
from vibsim.plots.relative_motion import (
    DISPLACEMENT,
    VELOCITY,
    draw_stop,
    relative,
    state_names,
    stop_position,
)
from vibsim.plots.samples import shown
from vibsim.plots.sheet import legend_above, note, sheet
from vibsim.plots.spans import period_of
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.turns import states_at, turn_times
from vibsim.plots.view import Span, View

AT_MOST = 5000  # sections by default, and the number up to which each is evaluated by the engine
MARKERS = ("o", "s", "^", "D", "v", "x", "+")


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """v1 - v2 against x1 - x2 at phase 0 of the source; the last half of the run by default."""
    figure = sheet(view, 7.2)
    axes = figure.subplots()
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    drawn = [section(subject, span) for subject, span in zip(subjects, spans, strict=True)]
    scales = scale_for("m", *(y for y, _ in drawn)), scale_for("m/s", *(u for _, u in drawn))
    for i, (subject, (y, u)) in enumerate(zip(subjects, drawn, strict=True)):
        colour = overlay(i)["color"] if len(subjects) > 1 else BLUE
        axes.plot(
            scales[0](y), scales[1](u), linestyle="none", marker=MARKERS[i % len(MARKERS)], markersize=1.6,
            markeredgewidth=0.3, markerfacecolor="none" if len(subjects) > 1 else colour, color=colour,
            label=subject.name, gid="section", rasterized=len(y) > 20_000,
        )  # fmt: skip
    axes.margins(0.06)
    axes.set_xlabel(scales[0].label(f"Relative displacement {DISPLACEMENT}"))
    axes.set_ylabel(scales[1].label(f"Relative velocity {VELOCITY}"))
    note(axes, f"{sum(len(y) for y, _ in drawn)} sections, " + "; ".join(dict.fromkeys(map(seconds, spans))))
    if len(subjects) > 1:
        legend_above(axes, markerscale=2)
    elif subjects[0].scene.has_stop:
        _stop_if_near(axes, subjects[0], scales[0])
    return figure


def last_half(subject: Subject, window: Span) -> Span:
    """The second half of the run, at most its last 5000 periods."""
    longest = AT_MOST * period_of(subject, window)
    return max((window[0] + window[1]) / 2, window[1] - longest), window[1]


def section(subject: Subject, span: Span) -> tuple[np.ndarray, np.ndarray]:
    """Relative displacement [m] and velocity [m/s] (n) at each turn of the source within the span."""
    times = turn_times(subject.result, span)
    return relative(states_at(subject.result, state_names(subject.scene), times, AT_MOST + 1))


def _stop_if_near(axes: Axes, subject: Subject, scale: Scale) -> None:
    """The stop, unless it lies so far off that drawing it would squeeze the section."""
    low, high = axes.get_xlim()
    if low <= float(scale(stop_position(subject.scene))) <= high:
        draw_stop(axes, subject.scene, scale)

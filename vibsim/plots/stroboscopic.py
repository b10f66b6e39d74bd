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
from vibsim.plots.spans import PERIODS_AT_MOST, last_half
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.time_marks import trust_remark
from vibsim.plots.turns import states_at, turn_times
from vibsim.plots.view import Span, View

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
    count = sum(len(y) for y, _ in drawn)
    said = [f"{count} point{'' if count == 1 else 's'}", *dict.fromkeys(map(seconds, spans))]
    named = len(subjects) == 1 and subjects[0].scene.has_stop and _stop_if_near(axes, subjects[0], scales[0])
    note(axes, "; ".join(filter(None, [*said, trust_remark(subjects, spans)])), above=1 if named else 0)
    if len(subjects) > 1:
        legend_above(axes, markerscale=2)
    return figure


def section(subject: Subject, span: Span) -> tuple[np.ndarray, np.ndarray]:
    """Relative displacement [m] and velocity [m/s] (n) at each turn of the source within the span."""
    times = turn_times(subject.result, span)
    return relative(states_at(subject.result, state_names(subject.scene), times, PERIODS_AT_MOST + 1))


def _stop_if_near(axes: Axes, subject: Subject, scale: Scale) -> bool:
    """The stop, unless it lies so far off that drawing it would squeeze the section; whether it is drawn."""
    low, high = axes.get_xlim()
    near = low <= float(scale(stop_position(subject.scene))) <= high
    if near:
        draw_stop(axes, subject.scene, scale)
    return near

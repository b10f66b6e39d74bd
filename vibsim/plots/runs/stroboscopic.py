"""Stroboscopic section of the relative motion: the state once per period of the source."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motion.pairs import Pair, common_pairs, label_relative, relative_traces
from vibsim.plots.motion.relative_motion import draw_stop_line
from vibsim.plots.motion.samples import shown
from vibsim.plots.motion.spans import PERIODS_AT_MOST, last_half
from vibsim.plots.motion.time_marks import trust_remark
from vibsim.plots.motion.turns import states_at, turn_times
from vibsim.plots.page.quantities import Scale, scale_for, seconds
from vibsim.plots.page.sheet import legend_above, note, say_inside, sheet
from vibsim.plots.style import BLUE, MARKERS, dot_size, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View

LEAST = 1e-2  # of the extent of the motion: the least that is shown


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Relative velocity against relative displacement (`pair_of`) at the end of each period of the source.

    The last half of the run by default.
    """
    figure = sheet(view, 7.2)
    axes = figure.subplots()
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    pairs = common_pairs(subjects)
    drawn = [section(*each) for each in zip(subjects, pairs, spans, strict=True)]
    scales = scale_for("m", *(y for y, _ in drawn)), scale_for("m/s", *(u for _, u in drawn))
    for i, (subject, (y, u)) in enumerate(zip(subjects, drawn, strict=True)):
        colour = overlay(i)["color"] if len(subjects) > 1 else BLUE
        axes.plot(
            scales[0](y), scales[1](u), linestyle="none", marker=MARKERS[i % len(MARKERS)],
            markersize=dot_size(len(y)),
            markeredgewidth=0.3, markerfacecolor="none" if len(subjects) > 1 else colour, color=colour,
            label=subject.name, gid="section", rasterized=len(y) > 20_000,
        )  # fmt: skip
    axes.margins(0.06)
    _no_narrower_than_rounding(axes, subjects, pairs, spans, scales)
    label_relative(axes, pairs[0], scales)
    count = sum(len(y) for y, _ in drawn)
    if not count:
        say_inside(axes, "no period of the source ends here")
    remarks = [f"{count} point{'' if count == 1 else 's'}", *dict.fromkeys(map(seconds, spans))]
    named = count > 0 and len(subjects) == 1 and _stops_if_near(axes, pairs[0], scales[0])
    note(axes, "; ".join(filter(None, [*remarks, trust_remark(subjects, spans)])), above=1 if named else 0)
    if len(subjects) > 1:
        legend_above(axes, markerscale=2)
    return figure


def _no_narrower_than_rounding(
    axes: Axes,
    subjects: Sequence[Subject],
    pairs: Sequence[Pair],
    spans: Sequence[Span],
    scales: tuple[Scale, Scale],
) -> None:
    """Widen axes to a share of the motion: a periodic motion is a point, whose scatter is rounding."""
    traces = relative_traces(subjects, pairs, spans)
    motions = [each.x for each in traces], [each.y for each in traces]
    for axis, scale, values in zip((axes.xaxis, axes.yaxis), scales, motions, strict=True):
        low, high = axis.get_view_interval()
        least = LEAST * float(np.ptp(scale(np.concatenate(values))))
        if high - low < least:
            middle = (low + high) / 2
            axis.set_view_interval(middle - least / 2, middle + least / 2, ignore=True)


def section(subject: Subject, pair: Pair, span: Span) -> tuple[np.ndarray, np.ndarray]:
    """Relative displacement [m] and velocity [m/s] (n) at each turn of the source within the span."""
    times = turn_times(subject.result, span)
    names = tuple(name for name in pair.names if name != "time")
    states = states_at(subject.result, names, times, PERIODS_AT_MOST + 1)
    return pair.plane({**states, "time": times[times <= subject.result.t_reached]})


def _stops_if_near(axes: Axes, pair: Pair, scale: Scale) -> bool:
    """The stops, but for those so far off that they would squeeze the section; whether any is drawn."""
    low, high = axes.get_xlim()
    near = [(at, text) for at, text in pair.stops if low <= float(scale(at)) <= high]
    for at, text in near:
        draw_stop_line(axes, at, scale, text)
    return bool(near)

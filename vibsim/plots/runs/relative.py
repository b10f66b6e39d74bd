"""Phase portrait of the relative motion."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motion.pairs import common_pairs, label_relative, relative_traces
from vibsim.plots.motion.relative_motion import draw_stop_line
from vibsim.plots.motion.samples import shown
from vibsim.plots.motion.spans import steady_span
from vibsim.plots.motion.time_marks import trust_remark
from vibsim.plots.motion.trace import draw_trace
from vibsim.plots.page.quantities import scale_for, seconds
from vibsim.plots.page.sheet import legend_above, note, sheet
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

BESIDE_STOP = 20  # characters of a remark that has room beside the name of the stop


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Relative velocity against relative displacement, and the stop.

    The last 50 periods unless the view has a window.
    """
    figure = sheet(view, 7.2)
    axes = figure.subplots()
    relative_panel(axes, subjects, view)
    if len(subjects) > 1:
        legend_above(axes)
    return figure


def relative_panel(axes: Axes, subjects: Sequence[Subject], view: View) -> None:
    """The portrait in given axes."""
    spans = [shown(subject, view.window, steady_span) for subject in subjects]
    pairs = common_pairs(subjects)
    traces = relative_traces(subjects, pairs, spans)
    scales = scale_for("m", *(each.x for each in traces)), scale_for("m/s", *(each.y for each in traces))
    for i, (subject, each) in enumerate(zip(subjects, traces, strict=True)):
        look = {**overlay(i), "alpha": 0.7} if len(subjects) > 1 else {"color": BLUE}
        draw_trace(axes, each, scales, label=subject.name, gid="relative", **look)
    stops = dict.fromkeys(stop for pair in pairs for stop in pair.stops)
    for position, text in stops:
        draw_stop_line(axes, position, scales[0], text if len(subjects) == 1 else "")
    axes.margins(0.05)
    label_relative(axes, pairs[0], scales)
    remarks = [*dict.fromkeys(map(seconds, spans)), trust_remark(subjects, spans)]
    text = "; ".join(filter(None, remarks))
    crowded = len(text) > BESIDE_STOP or any(not name.startswith("$") for _, name in stops)
    note(axes, text, above=1 if len(subjects) == 1 and stops and crowded else 0)

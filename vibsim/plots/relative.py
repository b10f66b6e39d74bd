"""Phase portrait of the relative motion."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.quantities import scale_for, seconds
from vibsim.plots.relative_motion import DISPLACEMENT, VELOCITY, draw_stop, relative, state_names
from vibsim.plots.samples import shown
from vibsim.plots.sheet import legend_above, note, sheet
from vibsim.plots.spans import steady_span
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.time_marks import trust_remark
from vibsim.plots.trace import draw_trace, trace
from vibsim.plots.view import View

BESIDE_STOP = 20  # characters of a remark that has room beside the name of the stop


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """v1 - v2 against x1 - x2, and the stop; the last 50 periods unless the view has a window."""
    figure = sheet(view, 7.2)
    axes = figure.subplots()
    relative_panel(axes, subjects, view)
    if len(subjects) > 1:
        legend_above(axes)
    return figure


def relative_panel(axes: Axes, subjects: Sequence[Subject], view: View) -> None:
    """The portrait in given axes."""
    spans = [shown(subject, view.window, steady_span) for subject in subjects]
    traces = [
        trace(subject.result, state_names(subject.scene), relative, span)
        for subject, span in zip(subjects, spans, strict=True)
    ]
    scales = scale_for("m", *(each.x for each in traces)), scale_for("m/s", *(each.y for each in traces))
    for i, (subject, each) in enumerate(zip(subjects, traces, strict=True)):
        look = {**overlay(i), "alpha": 0.7} if len(subjects) > 1 else {"color": BLUE}
        draw_trace(axes, each, scales, label=subject.name, gid="relative", **look)
    with_stop = {(s.scene.stop_sign, s.scene.G): s.scene for s in subjects if s.scene.has_stop}
    for scene in with_stop.values():
        draw_stop(axes, scene, scales[0], label=len(subjects) == 1)
    axes.margins(0.05)
    axes.set_xlabel(scales[0].label(f"Relative displacement {DISPLACEMENT}"))
    axes.set_ylabel(scales[1].label(f"Relative velocity {VELOCITY}"))
    said = [*dict.fromkeys(map(seconds, spans)), trust_remark(subjects, spans)]
    text = "; ".join(filter(None, said))
    note(axes, text, above=1 if len(subjects) == 1 and with_stop and len(text) > BESIDE_STOP else 0)

"""Phase portraits of the blocks, as the paper draws them: velocity against displacement, drift included."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.quantities import scale_for, seconds
from vibsim.plots.samples import shown
from vibsim.plots.sheet import legend_above, note, sheet
from vibsim.plots.spans import steady_span
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.trace import Block, draw_trace, trace
from vibsim.plots.view import View


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """v1 against x1, and v2 against x2; the last 50 periods unless the view has a window."""
    blocks = [n for n in (1, 2) if any(f"x{n}" in subject.scene.columns() for subject in subjects)]
    wide = view.width == "page"
    figure = sheet(view, 7.2 if wide else 6.2 * len(blocks))
    grid = (1, len(blocks)) if wide else (len(blocks), 1)
    panels = figure.subplots(*grid, squeeze=False).ravel()
    for axes, block in zip(panels, blocks, strict=True):
        phase_panel(axes, subjects, view, block)
    if len(subjects) > 1:
        legend_above(panels[0])
    figure.align_ylabels()
    return figure


def phase_panel(axes: Axes, subjects: Sequence[Subject], view: View, block: int) -> None:
    """The portrait of block 1 or 2 in given axes, of the subjects in which it moves."""
    x, v = f"x{block}", f"v{block}"

    def plane(columns: Block):
        return columns[x], columns[v]

    drawn = []
    for i, subject in enumerate(subjects):
        if x in subject.scene.columns():
            span = shown(subject, view.window, steady_span)
            look = overlay(i, dashed=False) if len(subjects) > 1 else {"color": BLUE}
            drawn.append((subject, span, trace(subject.result, (x, v), plane, span), look))
    scales = (
        scale_for("m", *(each.x for _, _, each, _ in drawn)),
        scale_for("m/s", *(each.y for _, _, each, _ in drawn)),
    )
    for subject, _, each, look in drawn:
        draw_trace(axes, each, scales, label=subject.name, gid=x, **look)
    axes.margins(0.05)
    axes.set_xlabel(scales[0].label(f"Displacement $x_{block}$"))
    axes.set_ylabel(scales[1].label(f"Velocity $v_{block}$"))
    note(axes, "; ".join(dict.fromkeys(seconds(span) for _, span, _, _ in drawn)))

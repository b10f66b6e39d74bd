"""Displacements against the motor's instantaneous speed: the passage through resonance in one picture."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motor_speed import SPEED
from vibsim.plots.quantities import Scale, scale_for, seconds
from vibsim.plots.samples import window_of
from vibsim.plots.sheet import legend_above, note, sheet
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.trace import Block, draw_trace, trace
from vibsim.plots.view import View


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """x1 and x2 [m] against phidot / 2 pi [Hz]; the whole run unless the view has a window."""
    columns = [name for name in ("x1", "x2") if any(name in subject.scene.columns() for subject in subjects)]
    figure = sheet(view, 1.4 + 4.4 * len(columns))
    panels = figure.subplots(len(columns), 1, squeeze=False, sharex=True)[:, 0]
    for axes, column in zip(panels, columns, strict=True):
        displacement_frequency_panel(axes, subjects, view, column)
    panels[-1].set_xlabel(f"Motor speed {SPEED} (Hz)")
    spans = [window_of(subject, view.window) for subject in subjects]
    note(panels[0], "; ".join(dict.fromkeys(seconds(span) for span in spans)))
    if len(subjects) > 1:
        legend_above(panels[0])
    figure.align_ylabels()
    return figure


def displacement_frequency_panel(axes: Axes, subjects: Sequence[Subject], view: View, column: str) -> None:
    """x1 or x2, the `column`, in given axes."""

    def plane(columns: Block):
        return columns["phidot"] / (2 * math.pi), columns[column]

    moving = [(i, subject) for i, subject in enumerate(subjects) if column in subject.scene.columns()]
    traces = [
        trace(subject.result, ("phidot", column), plane, window_of(subject, view.window))
        for _, subject in moving
    ]
    scale = scale_for("m", *(each.y for each in traces))
    for (i, subject), each in zip(moving, traces, strict=True):
        look = overlay(i, dashed=False) if len(subjects) > 1 else {"color": BLUE}
        draw_trace(
            axes,
            each,
            (Scale(1.0, "Hz"), scale),
            label=subject.name,
            gid=column,
            **{"linewidth": 0.3, **look},
        )
    axes.margins(0.04)
    axes.set_ylabel(scale.label(f"Displacement $x_{column[1]}$"))

"""Phase portraits of the blocks, as the paper draws them: velocity against displacement, drift included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motion.samples import shown
from vibsim.plots.motion.spans import steady_span
from vibsim.plots.motion.time_marks import trust_remark
from vibsim.plots.motion.trace import Block, Trace, draw_impacts, draw_trace, impact_points, trace
from vibsim.plots.page.quantities import Scale, scale_for, seconds, symbol
from vibsim.plots.page.sheet import legend_above, letter_panels, note, sheet
from vibsim.plots.runs.drift import drift_rate
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View


@dataclass(frozen=True)
class Portrait:
    """The portrait of one block of one run: curve, impacts, span [s], drift taken out [m/s], and its look."""

    subject: Subject
    span: Span
    curve: Trace
    impacts: Trace | None
    drift: float
    look: dict[str, Any]


def draw(subjects: Sequence[Subject], view: View, less_drift: bool = False) -> Figure:
    """Velocity against displacement of each block; the last 50 periods unless the view has a window."""
    columns = moving(subjects)
    wide = view.width == "page"
    figure = sheet(view, 7.2 if wide else 6.2 * len(columns))
    grid = (1, len(columns)) if wide else (len(columns), 1)
    panels = list(figure.subplots(*grid, squeeze=False).ravel())
    phase_panels(panels, subjects, view, columns, less_drift)
    if len(subjects) > 1:
        legend_above(panels[0])
    letter_panels(panels)
    figure.align_ylabels()
    return figure


def moving(subjects: Sequence[Subject]) -> list[str]:
    """Columns of the displacements of blocks that move in any of the runs, in file order."""
    columns = [name for subject in subjects for name in subject.columns_in("m")]
    return list(dict.fromkeys(columns))


def phase_panels(
    panels: Sequence[Axes],
    subjects: Sequence[Subject],
    view: View,
    columns: Sequence[str],
    less_drift: bool = False,
) -> None:
    """The portraits of the blocks whose displacements are `columns`, in given axes, all in the same units.

    less_drift : whether to take the mean velocity of each block out, so that a steady motion closes
    """
    drawn = [_portraits(subjects, view, column, less_drift) for column in columns]
    every = [portrait.curve for portraits in drawn for portrait in portraits]
    scales = scale_for("m", *(each.x for each in every)), scale_for("m/s", *(each.y for each in every))
    for axes, column, portraits in zip(panels, columns, drawn, strict=True):
        _panel(axes, portraits, column, scales)
        less = " less drift" if less_drift else ""
        axes.set_xlabel(scales[0].label(f"Displacement {symbol(column)}{less}"))
        axes.set_ylabel(scales[1].label(f"Velocity {symbol('v' + column[1:])}{less}"))


def _portraits(subjects: Sequence[Subject], view: View, column: str, less_drift: bool) -> list[Portrait]:
    portraits = []
    for i, subject in enumerate(subjects):
        if column in subject.columns_in("m"):
            span = shown(subject, view.window, steady_span)
            look = {**overlay(i), "alpha": 0.7} if len(subjects) > 1 else {"color": BLUE}
            portraits.append(_portrait(subject, column, span, less_drift, look))
    return portraits


def _portrait(subject: Subject, column: str, span: Span, less_drift: bool, look: dict[str, Any]) -> Portrait:
    velocity = f"v{column[1:]}"
    drift = drift_rate(subject.result, column, span) if less_drift else 0.0

    def plane(columns: Block) -> tuple[np.ndarray, np.ndarray]:
        if not less_drift:
            return columns[column], columns[velocity]
        return columns[column] - drift * (columns["time"] - span[0]), columns[velocity] - drift

    names = ("time", column, velocity)
    curve = trace(subject.result, names, plane, span)
    impacts = impact_points(subject, names, plane, span) if subject.scene.has_stop else None
    return Portrait(subject, span, curve, impacts, drift, look)


def _panel(axes: Axes, portraits: Sequence[Portrait], column: str, scales: tuple[Scale, Scale]) -> None:
    for portrait in portraits:
        draw_trace(axes, portrait.curve, scales, label=portrait.subject.name, gid=column, **portrait.look)
        if portrait.impacts is not None:
            draw_impacts(axes, portrait.impacts, scales, portrait.look["color"])
    axes.margins(0.05)
    spans = [portrait.span for portrait in portraits]
    drifts = [portrait.drift for portrait in portraits if portrait.drift]
    scale = scale_for("m/s", drifts)
    remarks = [
        *dict.fromkeys(map(seconds, spans)),
        f"drift {', '.join(f'{scale(drift):.3g}' for drift in drifts)} {scale.unit}" if drifts else "",
        trust_remark([portrait.subject for portrait in portraits], spans),
    ]
    note(axes, "; ".join(filter(None, remarks)))

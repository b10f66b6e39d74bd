"""Time histories of both blocks: the whole window, and a detail in which single impacts are seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.dense import dense, samples_are_sparse
from vibsim.plots.impacts import contact_spans, events_of
from vibsim.plots.quantities import Scale, scale_for
from vibsim.plots.samples import Series, common_window, series, window_of
from vibsim.plots.sheet import above_wider, legend_above, note, pixel_columns, sheet, time_axis
from vibsim.plots.spans import DETAIL_PERIODS, detail_span, period_of
from vibsim.plots.style import BLOCK1, BLOCK2, SHADE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.time_marks import annotate_run, trust_mark
from vibsim.plots.view import Span, View

SINGLE_MARKS = 120  # impacts in a detail up to which each gets its own mark on the curves


@dataclass(frozen=True)
class Quantity:
    """What is drawn against time: words, SI unit, and the columns of block 1 and block 2."""

    words: str
    unit: str
    columns: tuple[str, str]


@dataclass(frozen=True)
class Curve:
    """One column of one subject, and how it looks."""

    subject: Subject
    column: str
    label: str
    look: dict[str, Any]


def draw_history(subjects: Sequence[Subject], view: View, quantity: Quantity) -> Figure:
    """Panels of the whole window above, of the detail below.

    One subject: both blocks in one panel. Several: a panel per block, and a detail only where the view asks
    for it (runs that drift apart leave nothing to be seen in a common one).
    """
    groups = curve_groups(subjects, quantity)
    spans = _spans(subjects, view)
    count = len(spans) * len(groups)
    figure = sheet(view, 1.0 + count * (4.2 if len(groups) == 1 else 3.4))
    panels = figure.subplots(count, 1, squeeze=False)[:, 0]
    for row, (span, group) in enumerate((span, group) for span in spans for group in groups):
        history_panel(panels[row], group, span, quantity)
        if row % len(groups) < len(groups) - 1:
            panels[row].tick_params(labelbottom=False)
            panels[row].set_xlabel("")
        if row < len(groups) and len(spans) == 2:
            panels[row].axvspan(*spans[1], color=SHADE, linewidth=0, zorder=0)
    legend_above(panels[0])
    figure.align_ylabels()
    return figure


def _spans(subjects: Sequence[Subject], view: View) -> list[Span]:
    window = common_window(subjects, view.window)
    if view.detail is None and (len(subjects) > 1 or is_short(subjects[0], window)):
        return [window]
    return [window, detail_span(subjects, view)]


def is_short(subject: Subject, span: Span) -> bool:
    """Whether a span holds so few periods of the source that single ones can be seen."""
    return span[1] - span[0] <= 4 * DETAIL_PERIODS * period_of(subject, span)


def curve_groups(subjects: Sequence[Subject], quantity: Quantity) -> list[list[Curve]]:
    """The curves of each panel: both blocks of one subject together, or one block of all subjects."""
    present = [[name for name in quantity.columns if name in subject.scene.columns()] for subject in subjects]
    if len(subjects) == 1:
        looks = dict(zip(quantity.columns, (BLOCK1, BLOCK2), strict=True))
        return [[Curve(subjects[0], name, symbol(name), looks[name]) for name in present[0]]]
    return [
        [Curve(s, name, s.name, overlay(i)) for i, s in enumerate(subjects) if name in present[i]]
        for name in quantity.columns
        if any(name in names for names in present)
    ]


def symbol(column: str) -> str:
    """Mathtext of a column's name: x1 becomes $x_1$."""
    return f"${column[0]}_{column[1]}$"


def history_panel(axes: Axes, curves: list[Curve], span: Span, quantity: Quantity) -> None:
    """Curves against time: smooth, with impacts and contact marked, where the span is short."""
    draw = short_panel if is_short(curves[0].subject, span) else whole_panel
    scale = draw(axes, curves, span, quantity.unit)
    columns = {curve.column for curve in curves}
    single_block = len(columns) == 1 and len({curve.label for curve in curves}) > 1
    axes.set_ylabel(scale.label(symbol(columns.pop()) if single_block else quantity.words))
    time_axis(axes, span)


def whole_panel(axes: Axes, curves: list[Curve], span: Span, unit: str) -> Scale:
    """A long span: envelopes; for a single run a tick for every impact, and the trust horizon."""
    drawn = [_long_series(curve, span, pixel_columns(axes)) for curve in curves]
    scale = scale_for(unit, *(values for _, values in drawn))
    for curve, (t, values) in zip(curves, drawn, strict=True):
        look = {**curve.look, "linestyle": "-", "zorder": above_wider(values)}
        axes.plot(t, scale(values), label=curve.label, gid=curve.column, **look)
    if len({id(curve.subject) for curve in curves}) == 1:
        annotate_run(axes, curves[0].subject, span)
    return scale


def _long_series(curve: Curve, span: Span, columns: int) -> Series:
    """Column against time over a long span; from the engine where samples are sparse."""
    subject, own = curve.subject, window_of(curve.subject, span)
    if samples_are_sparse(subject.scene):
        filled = dense(subject.result, (curve.column,), own, step=period_of(subject, own) / 16)
        return filled["time"], filled[curve.column]
    return series(subject.result, (curve.column,), own, columns)[curve.column]


def short_panel(axes: Axes, curves: list[Curve], span: Span, unit: str) -> Scale:
    """A short span: smooth curves, impacts marked on them; for a single run, contact shaded."""
    drawn = [dense(c.subject.result, (c.column,), window_of(c.subject, span)) for c in curves]
    scale = scale_for(unit, *(columns[c.column] for c, columns in zip(curves, drawn, strict=True)))
    for curve, columns in zip(curves, drawn, strict=True):
        axes.plot(
            columns["time"], scale(columns[curve.column]), label=curve.label, gid=curve.column, **curve.look
        )
        _mark_impacts(axes, curve, span, scale)
    subject = curves[0].subject
    if subject.scene.has_stop and all(curve.subject is subject for curve in curves):
        for begin, end in contact_spans(subject.result, span):
            axes.axvspan(begin, end, color=SHADE, linewidth=0, zorder=0)
    if all(curve.subject is subject for curve in curves) and (remark := trust_mark(axes, subject, span)):
        note(axes, remark)
    return scale


def _mark_impacts(axes: Axes, curve: Curve, span: Span, scale: Scale) -> None:
    if not curve.subject.scene.has_stop:
        return
    t, values = events_of(curve.subject.result, "contact_begin", span, curve.column)
    if len(t) > SINGLE_MARKS:
        return
    axes.plot(
        t, scale(values), linestyle="none", marker="o", markersize=2.4, markerfacecolor="white",
        markeredgewidth=0.6, color=curve.look["color"], gid="impacts", zorder=3,
    )  # fmt: skip

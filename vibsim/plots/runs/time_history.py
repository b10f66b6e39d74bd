"""Time histories of the bodies: the whole window, and a detail in which single impacts are seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motion.dense import dense, samples_are_sparse
from vibsim.plots.motion.impacts import contact_spans, impacts_of
from vibsim.plots.motion.samples import Series, common_window, series, window_of
from vibsim.plots.motion.spans import DETAIL_PERIODS, detail_span, period_of
from vibsim.plots.motion.time_marks import annotate_runs, mark_detail, trust_marks
from vibsim.plots.page.quantities import Scale, scale_for, symbol
from vibsim.plots.page.sheet import (
    above_wider,
    legend_above,
    letter_panels,
    note,
    pixel_columns,
    sheet,
    time_axis,
)
from vibsim.plots.style import GREY, SHADE, THIN, dashed, nested
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View

SINGLE_MARKS = 120  # impacts in a detail up to which each gets its own mark on the curves


@dataclass(frozen=True)
class Quantity:
    """What is drawn against time: words, and the SI unit of the states of bodies that it is."""

    words: str
    unit: str


@dataclass(frozen=True)
class Curve:
    """One column of one subject, and how it looks.

    alone : whether the picture shows this subject alone
    """

    subject: Subject
    column: str
    label: str
    look: dict[str, Any]
    alone: bool


@dataclass(frozen=True)
class Panel:
    """Axes, and what is drawn on them: curves over a span [s]."""

    axes: Axes
    curves: list[Curve]
    span: Span

    @cached_property
    def is_short(self) -> bool:
        """Whether single periods can be seen."""
        return is_short(self.curves[0].subject, self.span)

    @cached_property
    def drawn(self) -> list[Series]:
        """Instants [s] and values (SI) of each curve: smooth over a short span, else an envelope."""
        series_of = _short_series if self.is_short else _long_series
        return [series_of(curve, self.span, pixel_columns(self.axes)) for curve in self.curves]

    @property
    def runs(self) -> tuple[list[Subject], list[Any]]:
        """The runs shown and their colours; one of which several bodies are shown counts once, in grey."""
        if self.curves[0].alone:
            return [self.curves[0].subject], [GREY]
        return [curve.subject for curve in self.curves], [curve.look["color"] for curve in self.curves]


def draw_history(subjects: Sequence[Subject], view: View, quantity: Quantity) -> Figure:
    """Panels of the whole window above, of the detail below.

    One subject: all bodies in one panel. Several: a panel per body, and a detail only where the view asks
    for it (runs that drift apart leave nothing to be seen in a common one).
    """
    groups = curve_groups(subjects, quantity)
    spans = _spans(subjects, view)
    count = len(spans) * len(groups)
    figure = sheet(view, 1.0 + count * (4.2 if len(groups) == 1 else 3.4))
    panels = list(figure.subplots(count, 1, squeeze=False)[:, 0])
    shown = [(span, group) for span in spans for group in groups]
    histories([Panel(axes, group, span) for axes, (span, group) in zip(panels, shown, strict=True)], quantity)
    for row, axes in enumerate(panels):
        if row % len(groups) < len(groups) - 1:
            axes.tick_params(labelbottom=False)
            axes.set_xlabel("")
        if row < len(groups) and len(spans) == 2:
            mark_detail(axes, spans[1])
    legend_above(panels[0])
    letter_panels(panels)
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
    """The curves of each panel: all bodies of one subject together, or one body of all subjects."""
    present = [subject.columns_in(quantity.unit) for subject in subjects]
    if len(subjects) == 1:
        return [
            [Curve(subjects[0], name, symbol(name), dashed(i), True) for i, name in enumerate(present[0])]
        ]
    count = len(subjects)
    return [
        [
            Curve(s, name, s.name, nested(i, count), False)
            for i, s in enumerate(subjects)
            if name in present[i]
        ]
        for name in dict.fromkeys(name for names in present for name in names)
    ]


def histories(panels: Sequence[Panel], quantity: Quantity) -> None:
    """Draw panels of one quantity, all in the same unit.

    A short span is smooth, with impacts and contact marked; a long one an envelope with a tick per impact.
    """
    scale = scale_for(quantity.unit, *(values for panel in panels for _, values in panel.drawn))
    for panel in panels:
        draw = _draw_short if panel.is_short else _draw_long
        draw(panel, scale)
        first = panel.curves[0]
        panel.axes.set_ylabel(scale.label(quantity.words if first.alone else symbol(first.column)))
        time_axis(panel.axes, panel.span)


def _draw_long(panel: Panel, scale: Scale) -> None:
    """Envelopes, pale where the bands of several runs may lie upon each other; impacts, trust horizons.

    Dashes make no sense of a band: the legend has those of the detail.
    """
    for curve, (t, values) in zip(panel.curves, panel.drawn, strict=True):
        alpha = 1.0 if curve.alone else 0.6
        look = {**curve.look, "linewidth": THIN, "alpha": alpha, "zorder": above_wider(values)}
        panel.axes.plot(t, scale(values), gid=curve.column, **{**look, "linestyle": "-"})
        panel.axes.plot([], [], label=curve.label, gid="legend", **curve.look)
    subjects, colours = panel.runs
    annotate_runs(panel.axes, subjects, panel.span, colours)


def _draw_short(panel: Panel, scale: Scale) -> None:
    """Smooth curves, impacts marked on them; for a single run, contact shaded."""
    axes, span = panel.axes, panel.span
    for curve, (t, values) in zip(panel.curves, panel.drawn, strict=True):
        axes.plot(t, scale(values), label=curve.label, gid=curve.column, **curve.look)
        _mark_impacts(axes, curve, span, scale)
    subject = panel.curves[0].subject
    if panel.curves[0].alone and subject.scene.has_stop:
        for begin, end in contact_spans(subject, span):
            axes.axvspan(begin, end, color=SHADE, linewidth=0, zorder=0, gid="contact")
    subjects, colours = panel.runs
    note(axes, trust_marks(axes, subjects, span, colours))


def _short_series(curve: Curve, span: Span, columns: int) -> Series:
    """Column against time as smooth as the motion."""
    smooth = dense(curve.subject.result, (curve.column,), window_of(curve.subject, span))
    return smooth["time"], smooth[curve.column]


def _long_series(curve: Curve, span: Span, columns: int) -> Series:
    """Column against time over a long span; from the engine where samples are sparse."""
    subject, own = curve.subject, window_of(curve.subject, span)
    if samples_are_sparse(subject.scene):
        filled = dense(subject.result, (curve.column,), own, step=period_of(subject, own) / 16)
        return filled["time"], filled[curve.column]
    return series(subject.result, (curve.column,), own, columns)[curve.column]


def _mark_impacts(axes: Axes, curve: Curve, span: Span, scale: Scale) -> None:
    if not curve.subject.scene.has_stop:
        return
    t, values = impacts_of(curve.subject, span, curve.column)
    if len(t) > SINGLE_MARKS:
        return
    axes.plot(
        t, scale(values), linestyle="none", marker="o", markersize=2.4, markerfacecolor="white",
        markeredgewidth=0.6, color=curve.look["color"], gid="impacts", zorder=3,
    )  # fmt: skip

"""The Lyapunov diagram: exponents against what was swept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.page.sheet import legend_below, note, sheet
from vibsim.plots.style import BLACK, GREEN, GREY, ORANGE, PINK, SKY, YELLOW
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import axis_label
from vibsim.plots.sweeps.curves import Curve, alone, curves, draw_bands, ensemble_note, limit
from vibsim.plots.sweeps.panels import curve_panels, label_outer
from vibsim.plots.view import View

HEIGHT_CM = 6.0
PANEL_CM, PANEL_WIDTH_CM = 4.2, 5.4
TOGETHER = 2  # curves in one panel: up and down
FURTHER = ((ORANGE, "s"), (GREEN, "^"), (PINK, "v"), (BLACK, "D"), (SKY, "x"), (YELLOW, "+"))
LARGEST, SPECTRUM = "lyapunov", "lyapunov_spectrum"


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Lyapunov exponents [1/s], the largest with its interval of 95 %, all of them where they are stored.

    Up and down share a panel; more curves, or several exponents of each, have a panel each.
    """
    every = curves(subjects)
    spectrum = any(SPECTRUM in curve.subject.result.plan.columns for curve in every)
    if len(every) > TOGETHER or (spectrum and len(every) > 1):
        sheets = curve_panels(every, view, (PANEL_CM,), PANEL_WIDTH_CM)
        figure, panels = sheets.figure, sheets.panels
        groups, remark = [[alone(curve)] for curve in sheets.drawn], sheets.omitted
        top_right = sheets.top_right
    else:
        figure = sheet(view, HEIGHT_CM)
        top_right = figure.subplots()
        panels, groups, remark = np.array([[top_right]]), [every], ""
    for axes, group in zip(panels[:, 0], groups, strict=True):
        exponent_panel(axes, group)
    limit(panels[0, 0], every, view)
    label_outer(panels, axis_label(subjects), [exponent_label(every)])
    note(top_right, "; ".join(filter(None, [remark, exponent_note(every)])))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    named = [(handle, label) for handle, label in zip(handles, labels, strict=True) if label]
    if len(named) > 1:
        legend_below(figure, *zip(*named, strict=True))
    return figure


def has_exponents(subjects: Sequence[Subject]) -> bool:
    """Whether every sweep has Lyapunov exponents."""
    return all({LARGEST, SPECTRUM} & set(subject.result.plan.columns) for subject in subjects)


def exponent_panel(axes: Axes, drawn: Sequence[Curve]) -> None:
    """The exponents of the curves in given axes; where all of a curve are known, each in its colour."""
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1, gid="zero")
    for curve in drawn:
        spectrum = SPECTRUM in curve.subject.result.plan.columns
        name, values, half = _largest(curve)
        if half is not None:
            axes.vlines(
                curve.x, values - half, values + half, color=curve.colour, alpha=0.5, linewidth=1.0,
                gid="interval",
            )  # fmt: skip
        draw_bands(axes, curve, name, np.asarray)
        look = {**curve.look, "markersize": 1.6}
        label = r"$\lambda_1$" if spectrum and len(drawn) == 1 else curve.label
        axes.plot(curve.x, values, label=label, gid="exponent", zorder=3, **look)
        if spectrum:
            _further(axes, curve, named=curve is drawn[0])
    axes.margins(y=0.06)


def _further(axes: Axes, curve: Curve, named: bool) -> None:
    """The exponents after the largest, each with a colour and a mark of its own."""
    for i, others in enumerate(curve.values(SPECTRUM).T[1:]):
        colour, marker = FURTHER[i % len(FURTHER)]
        axes.plot(
            curve.x, others, color=colour, linewidth=0.5, marker=marker, markersize=1.8, markeredgewidth=0.3,
            label=rf"$\lambda_{{{i + 2}}}$" if named else "", gid="further exponent",
        )  # fmt: skip


def exponent_label(drawn: Sequence[Curve]) -> str:
    """Label of the axis of the exponents."""
    spectrum = any(SPECTRUM in curve.subject.result.plan.columns for curve in drawn)
    return r"Exponents $\lambda_i$ (1/s)" if spectrum else r"Exponent $\lambda_1$ (1/s)"


def exponent_note(drawn: Sequence[Curve]) -> str:
    """What bars or bands about the largest exponent mean."""
    return ensemble_note(drawn) or "bars: 95 %"


def _largest(curve: Curve) -> tuple[str, np.ndarray, np.ndarray | None]:
    """Column of the largest exponent, its values and the half width of its interval (n).

    Of an ensemble the median, and no interval: the bands tell more.
    """
    if LARGEST in curve.subject.result.plan.columns:
        half = None if curve.members else curve.values(f"{LARGEST}_half_width")
        return LARGEST, curve.values(LARGEST), half
    half = None if curve.members else curve.values(f"{SPECTRUM}_half_width")[:, 0]
    return SPECTRUM, curve.values(SPECTRUM)[:, 0], half

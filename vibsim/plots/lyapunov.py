"""The Lyapunov diagram: exponents against what was swept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.sheet import note, sheet
from vibsim.plots.style import GREY
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import axis_label
from vibsim.plots.sweep_curves import Curve, curves, limit, name_curves
from vibsim.plots.view import View

HEIGHT_CM = 6.0
LARGEST, SPECTRUM = "lyapunov", "lyapunov_spectrum"


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Lyapunov exponents [1/s], the largest with its interval of 95 %, all of them where they are stored."""
    drawn = curves(subjects)
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    exponent_panel(axes, drawn)
    limit(axes, drawn, view)
    axes.set_xlabel(axis_label(subjects))
    name_curves(figure, axes)
    return figure


def has_exponents(subjects: Sequence[Subject]) -> bool:
    """Whether every sweep has Lyapunov exponents."""
    return all({LARGEST, SPECTRUM} & set(subject.result.plan.columns) for subject in subjects)


def exponent_panel(axes: Axes, drawn: Sequence[Curve]) -> None:
    """The exponents of the curves in given axes."""
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1, gid="zero")
    for curve in drawn:
        values, half = _largest(curve)
        axes.vlines(
            curve.x,
            values - half,
            values + half,
            color=curve.colour,
            alpha=0.5,
            linewidth=1.0,
            gid="interval",
        )
        look = {**curve.look, "markersize": 1.6}
        axes.plot(curve.x, values, label=curve.label, gid="exponent", zorder=3, **look)
        if SPECTRUM in curve.subject.result.plan.columns:
            for others in curve.values(SPECTRUM).T[1:]:
                axes.plot(
                    curve.x, others, color=curve.colour, linewidth=0.4, alpha=0.7, gid="further exponent"
                )
    spectrum = any(SPECTRUM in curve.subject.result.plan.columns for curve in drawn)
    axes.set_ylabel(r"Exponents $\lambda_i$ (1/s)" if spectrum else r"Exponent $\lambda_1$ (1/s)")
    axes.margins(y=0.06)
    note(axes, "bars: 95 %")


def _largest(curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """The largest exponent and the half width of its interval (n)."""
    if LARGEST in curve.subject.result.plan.columns:
        return curve.values(LARGEST), curve.values(f"{LARGEST}_half_width")
    return curve.values(SPECTRUM)[:, 0], curve.values(f"{SPECTRUM}_half_width")[:, 0]

"""The Sommerfeld diagram: steady speed of the motor against its no-load speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.margin_labels import Level, draw_levels
from vibsim.plots.sheet import note, sheet
from vibsim.plots.style import GREY
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_curves import Curve, axis_label, curves, frequencies, legend_below, limit
from vibsim.plots.view import View

HEIGHT_CM = 7.0
BANDS_UP_TO = 2  # curves; more bands hide each other
DASHED = (0, (4, 2))


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Mean speed [Hz] against Omega0 [Hz], least to greatest as a band; natural frequencies as levels.

    Points on the thin line turn at the no-load speed; a plateau below it is a capture: the power of the motor
    goes into vibration.
    """
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    drawn = curves(subjects)
    for curve in drawn:
        _draw_curve(axes, curve, band=len(drawn) <= BANDS_UP_TO)
    limit(axes, drawn, view)
    span = np.array(axes.get_xlim())
    axes.set_ylim(*_limits(drawn, span))
    axes.plot(span, span, color=GREY, linewidth=0.5, scalex=False, scaley=False, zorder=1, gid="no-load")
    levels = [Level(f.hz, f"{f.label}  {f.hz:.2f}", {"linestyle": DASHED}) for f in frequencies(subjects)]
    draw_levels(axes, levels, (HEIGHT_CM - 1.6) * 28)
    axes.set_xlabel(axis_label(subjects))
    axes.set_ylabel(r"Steady motor speed $\langle\dot\varphi\rangle/2\pi$ (Hz)")
    note(axes, "band: least to greatest" if len(drawn) <= BANDS_UP_TO else "")
    legend_below(figure, axes)
    return figure


def _draw_curve(axes: Axes, curve: Curve, band: bool) -> None:
    if band:
        axes.fill_between(
            curve.x, curve.values("min_speed"), curve.values("max_speed"),
            color=curve.colour, alpha=0.2, linewidth=0, gid="band",
        )  # fmt: skip
    axes.plot(curve.x, curve.values("mean_speed"), label=curve.label, gid="mean", zorder=3, **curve.look)


def _limits(drawn: Sequence[Curve], span: np.ndarray) -> tuple[float, float]:
    """Room for speeds, bands where they are drawn, and the line of the no-load speed."""
    names = ("min_speed", "max_speed") if len(drawn) <= BANDS_UP_TO else ("mean_speed",)
    shown = [
        curve.values(name)[(curve.x >= span[0]) & (curve.x <= span[1])] for curve in drawn for name in names
    ]
    values = np.concatenate([*shown, span])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.03 * (high - low)
    return low - margin, high + margin

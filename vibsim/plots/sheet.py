"""The sheet of paper: figures at final size, legends and notes that never cover data."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibsim.plots.style import GREY
from vibsim.plots.view import Span, View

CM = 1 / 2.54  # inch
COLUMNS_PER_INCH = 600  # envelope columns: the finest print a journal asks for line art


def sheet(view: View, height_cm: float) -> Figure:
    """An empty figure of the view's width and this height [cm]."""
    figure = Figure(figsize=(view.width_cm * CM, height_cm * CM), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.03, h_pad=0.03, wspace=0.02, hspace=0.03)  # type: ignore[union-attr]
    return figure


def pixel_columns(axes: Axes) -> int:
    """How many columns an envelope on these axes needs: those of the whole sheet, at 600 per inch."""
    width = axes.get_figure(root=True).get_figwidth()  # type: ignore[union-attr]
    return int(width * COLUMNS_PER_INCH)


def legend_above(axes: Axes, **options: Any) -> None:
    """The legend in one line above the axes, where there is more than nothing to tell apart."""
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    legend = axes.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.02), ncols=options.pop("ncols", 4), **options
    )
    for line in legend.get_lines():
        line.set_linewidth(1.2)


def note(axes: Axes, text: str) -> None:
    """A short remark above the axes, at the right: the window shown, the number of impacts."""
    axes.set_title(text, loc="right", fontsize=7, color=GREY, pad=3)


def above_wider(values: np.ndarray) -> float:
    """A z-order that puts a narrow band of oscillation above a wider one, so that none hides another."""
    strokes = np.abs(np.diff(values))
    width = float(strokes.mean()) if len(strokes) else 0.0
    return 2.0 + 0.9 / (1.0 + width)


def time_axis(axes: Axes, span: Span) -> None:
    """A time axis that shows just the span, with few enough ticks for long numbers."""
    axes.set_xlim(*span)
    axes.set_xlabel("Time (s)")
    wide = axes.get_figure(root=True).get_figwidth() > 5  # type: ignore[union-attr]
    axes.xaxis.set_major_locator(MaxNLocator(10 if wide else 5, steps=[1, 2, 5, 10]))

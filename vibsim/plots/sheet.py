"""The sheet of paper: figures at final size, legends and notes that never cover data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from vibsim.plots.style import GREY
from vibsim.plots.view import Span, View

CM = 1 / 2.54  # inch
COLUMNS_PER_INCH = 600  # envelope columns: the finest print a journal asks for line art

CHARACTERS_PER_INCH = 18  # of legends and notes, at 7 pt
HANDLE_CHARACTERS = 7  # what a line sample and its spacing take of that


def sheet(view: View, height_cm: float) -> Figure:
    """An empty figure of the view's width and this height [cm]."""
    layout = ConstrainedLayoutEngine(w_pad=0.03, h_pad=0.03, wspace=0.02, hspace=0.03)
    return Figure(figsize=(view.width_cm * CM, height_cm * CM), layout=layout)


def pixel_columns(axes: Axes) -> int:
    """How many columns an envelope on these axes needs: those of the whole sheet, at 600 per inch."""
    return int(_sheet_of(axes).get_figwidth() * COLUMNS_PER_INCH)


def legend_above(axes: Axes, **options: Any) -> None:
    """The legend above the axes, in as few lines as its names allow, and above a note they would meet.

    Call it last: it makes room for the note that is there.
    """
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    room = int(_width(axes) * CHARACTERS_PER_INCH)
    in_a_row = max(1, room // (max(map(len, labels)) + HANDLE_CHARACTERS))
    needed = sum(len(label) + HANDLE_CHARACTERS for label in labels)
    beside_note = needed + len(axes.get_title(loc="right")) > room and axes.get_title(loc="right")
    raised = axes.transAxes + ScaledTranslation(
        0, (12 if beside_note else 3) / 72, _sheet_of(axes).dpi_scale_trans
    )
    options = {"ncols": len(labels) if needed <= room else in_a_row, **options}
    legend = axes.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), bbox_transform=raised, **options
    )
    for line in legend.get_lines():
        line.set_linewidth(1.2)
        line.set_alpha(1.0)


def legend_below(figure: Figure, handles: Sequence[Any], labels: Sequence[str], **options: Any) -> None:
    """The legend under the picture, in one row if it fits, else in as many columns as do."""
    room = figure.get_figwidth() * CHARACTERS_PER_INCH
    needed = [len(label) + HANDLE_CHARACTERS for label in labels]
    columns = len(labels) if sum(needed) <= room else max(1, int(room / max(needed)))
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, **options)


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
    ticks = min(max(int(1.7 * _width(axes)), 3), 10)
    axes.xaxis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))


def _width(axes: Axes) -> float:
    """About how wide the axes are [inch], before anything is laid out."""
    return axes.bbox.width / _sheet_of(axes).dpi


def _sheet_of(axes: Axes) -> Figure:
    figure = axes.get_figure(root=True)
    assert isinstance(figure, Figure)
    return figure

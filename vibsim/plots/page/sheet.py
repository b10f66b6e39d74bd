"""The sheet of paper: figures at final size, legends and notes that never cover data."""

from __future__ import annotations

import re
from collections.abc import Sequence
from string import ascii_lowercase
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from vibsim.plots.style import GREY, points
from vibsim.plots.view import Span, View

CM = 1 / 2.54  # inch
COLUMNS_PER_INCH = 600  # envelope columns: the finest print a journal asks for line art

CHARACTERS_PER_INCH = 18  # of legends and notes, at 7 pt
NOTE_LINE_PT = 9
NOTE_SHARE = 0.9  # of the width of the axes that a line of a remark may take
LABEL_SHARE = 7 / 8  # of the characters of a legend: labels of axes are of 8 pt
HANDLE_CHARACTERS = 7  # what a line sample and its spacing take of that


def sheet(view: View, height_cm: float) -> Figure:
    """An empty figure of the view's width and this height [cm], unless the view has a size or a canvas.

    The height is that of text of 8 pt; larger text makes the figure higher.
    """
    width, height = view.size_cm or (view.width_cm, height_cm * points(1))
    layout = ConstrainedLayoutEngine(w_pad=0.03, h_pad=0.03, wspace=0.02, hspace=0.03)
    canvas = view.canvas or Figure
    return canvas(figsize=(width * CM, height * CM), layout=layout)


def characters(inches: float) -> float:
    """How many characters of a legend or a note go into a width [inch]."""
    return inches * CHARACTERS_PER_INCH / points(1)


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
    room = int(characters(_width(axes)))
    in_a_row = max(1, room // (max(map(_shown, labels)) + HANDLE_CHARACTERS))
    needed = sum(_shown(label) + HANDLE_CHARACTERS for label in labels)
    remark = axes.get_title(loc="right").split("\n")
    beside_note = needed + max(map(len, remark)) > room and remark != [""]
    raise_pt = 3 + points(NOTE_LINE_PT) * len(remark) if beside_note else 3
    raised = axes.transAxes + ScaledTranslation(0, raise_pt / 72, _sheet_of(axes).dpi_scale_trans)
    options = {"ncols": len(labels) if needed <= room else in_a_row, **options}
    legend = axes.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), bbox_transform=raised, **options
    )
    for line in legend.get_lines():
        line.set_linewidth(1.2)
        line.set_alpha(1.0)


def _shown(label: str) -> int:
    """Characters that are seen of a label, the marks of mathtext left out."""
    return len(re.sub(r"\\mathrm|[$_{}\\]", "", label))


def legend_below(figure: Figure, handles: Sequence[Any], labels: Sequence[str], **options: Any) -> None:
    """The legend under the picture, in one row if it fits, else in as many columns as do."""
    room = characters(figure.get_figwidth())
    needed = [_shown(label) + HANDLE_CHARACTERS for label in labels]
    columns = len(labels) if sum(needed) <= room else max(1, int(room / max(needed)))
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, **options)


def add_below(figure: Figure, handles: Sequence[Any]) -> None:
    """More entries, by the labels of their handles, in the legend under the picture, or the first there."""
    drawn: list[Any] = []
    for legend in list(figure.legends):
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
            assert handle is not None
            handle.set_label(text.get_text())
            drawn.append(handle)
        legend.remove()
    every = [*drawn, *handles]
    legend_below(figure, every, [str(handle.get_label()) for handle in every])


def label_axes(axes: Axes, across: tuple[str, str], up: tuple[str, str]) -> None:
    """Label both axes, each with words and a symbol with its unit, in two lines where they are too short."""
    box, dpi = axes.bbox, _sheet_of(axes).dpi
    axes.set_xlabel(_in_lines(across, box.width / dpi))
    axes.set_ylabel(_in_lines(up, box.height / dpi))


def _in_lines(parts: tuple[str, str], inches: float) -> str:
    """The parts of a label in one line if that is no longer than a length, else in two."""
    one = " ".join(parts)
    return one if _shown(one) <= LABEL_SHARE * characters(inches) else "\n".join(parts)


def letter_panels(panels: Sequence[Axes]) -> None:
    """(a), (b), ... above the upper left corners of the panels, in this order; none for a lone panel."""
    if len(panels) < 2:
        return
    for axes, letter in zip(panels, ascii_lowercase, strict=False):
        axes.annotate(
            f"({letter})", (0.0, 1.0), (-3, 3.5), xycoords="axes fraction", textcoords="offset points",
            ha="right", va="bottom", fontweight="bold", gid="letter",
        )  # fmt: skip


def note(axes: Axes, text: str, above: int = 0) -> None:
    """A short remark above the axes, at the right: the window shown, the number of impacts.

    In two lines, broken at a semicolon, where one would be wider than the axes.

    above : lines to leave free between the axes and the remark
    """
    if len(text) > NOTE_SHARE * characters(_width(axes)) and "; " in text:
        parts = text.split("; ")
        cut = min(range(1, len(parts)), key=lambda i: max(len("; ".join(p)) for p in (parts[:i], parts[i:])))
        text = "\n".join("; ".join(part) for part in (parts[:cut], parts[cut:]))
    beside = axes.get_title(loc="left")
    if beside and len(beside) + max(map(len, text.split("\n"))) > characters(_width(axes)):
        text += "\n "  # a line higher than the title
    axes.set_title(text, loc="right", fontsize=points(7), color=GREY, pad=3 + above * points(NOTE_LINE_PT))


def say_inside(axes: Axes, text: str) -> None:
    """Say in the middle of axes why they are empty."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=GREY)


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

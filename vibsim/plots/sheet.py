"""The sheet of paper: figures at final size, legends and notes that never cover data."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from string import ascii_lowercase
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_pdf import PdfFile, PdfPages
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from matplotlib.transforms import Bbox, ScaledTranslation
from numpy.typing import ArrayLike

from vibsim.cases.quantities import number
from vibsim.plots.style import GREY, points
from vibsim.plots.subject import Span, View

CM = 1 / 2.54  # inch
COLUMNS_PER_INCH = 600  # envelope columns: the finest print a journal asks for line art

CHARACTERS_PER_INCH = 18  # of legends and notes, at 7 pt
AXES_SHARE = 0.775  # of the width of a sheet that axes have before anything is laid out
LEGEND_LINE_CM = 0.4
NOTE_LINE_PT = 9
LEVEL_NAMES_CM = 1.9  # names of levels beside the axes
TICKS_APART = 2.0  # characters between the numbers of ticks
NOTE_SHARE = 0.85  # of the width of the axes that a line of a remark may take
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


def beside_levels(view: View) -> dict[str, Any]:
    """For `gridspec_kw` of panels beside which levels are named: about where they end, so that legends and
    remarks find their room before anything is laid out.
    """
    width = view.size_cm[0] if view.size_cm else view.width_cm
    return {"right": max(0.9 - LEVEL_NAMES_CM * points(1) / width, 0.4)}


def lay_out(figure: Figure) -> None:
    """Give the axes their places, for what is measured in pixels: the layout without the drawing."""
    engine = figure.get_layout_engine()
    if engine is None:  # axes of a user's: matplotlib places those of a fixed aspect while it draws
        figure.draw_without_rendering()
    else:
        engine.execute(figure)


def characters(inches: float) -> float:
    """Number of characters of a legend or a note that fit into a width [inch]."""
    return inches * CHARACTERS_PER_INCH / points(1)


def pixel_columns(axes: Axes) -> int:
    """Number of columns of an envelope on these axes: those of the whole sheet, at 600 per inch."""
    return int(sheet_of(axes).get_figwidth() * COLUMNS_PER_INCH)


def legend_above(axes: Axes, **options: Any) -> None:
    """The legend above the axes, in as few lines as its names allow, and above a note they would meet.

    Call it last: it makes room for the note that is there.
    """
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    room = int(characters(_width(axes)))
    needed = sum(_shown(label) + HANDLE_CHARACTERS for label in labels)
    remark = axes.get_title(loc="right").split("\n")
    beside_note = needed + max(map(len, remark)) > room and remark != [""]
    lines = max(len(remark) if beside_note else 0, 1 if axes.get_title(loc="left") else 0)
    raise_pt = 3 + points(NOTE_LINE_PT) * lines
    raised = axes.transAxes + ScaledTranslation(0, raise_pt / 72, sheet_of(axes).dpi_scale_trans)
    options = {"ncols": columns_of(labels, room), **options}
    legend = axes.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), bbox_transform=raised, **options
    )
    for line in legend.get_lines():
        line.set_linewidth(1.2)
        line.set_alpha(1.0)


def columns_of(labels: Sequence[str], room: float) -> int:
    """Columns of a legend, filled one after another, as many as go into a line of so many characters."""
    shown = np.array([_shown(label) for label in labels])
    for columns in range(len(labels), 1, -1):
        longest = [int(part.max()) for part in np.array_split(shown, columns)]  # as matplotlib fills them
        if sum(longest) + HANDLE_CHARACTERS * columns <= room:
            return columns
    return 1


def legend_lines(labels: Sequence[str], width_cm: float) -> int:
    """Lines of a legend above axes on a sheet of a width [cm]."""
    return -(-len(labels) // columns_of(labels, characters(AXES_SHARE * width_cm * CM)))


def _shown(label: str) -> int:
    """Characters that are seen of a label, the marks of mathtext left out."""
    return len(plain_symbols(label).replace("_", ""))


def plain_symbols(label: str) -> str:
    """A label without the marks of mathtext, as messages have it: x_disc - x_pin."""
    return re.sub(r"\\mathrm|[${}\\]", "", label)


def legend_below(figure: Figure, handles: Sequence[Any], labels: Sequence[str], **options: Any) -> None:
    """The legend under the picture, in one row if it fits, else in as many columns as do."""
    columns = columns_of(labels, characters(figure.get_figwidth()))
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
    few_ticks(axes)
    box, dpi = axes.bbox, sheet_of(axes).dpi
    axes.set_xlabel(_in_lines(across, box.width / dpi))
    axes.set_ylabel(_in_lines(up, box.height / dpi))


def _in_lines(parts: tuple[str, str], inches: float) -> str:
    """The parts of a label in one line if that is no longer than a length, else in two."""
    one = " ".join(parts)
    return one if _shown(one) <= LABEL_SHARE * characters(inches) else "\n".join(parts)


class FewTicks(MaxNLocator):
    """Ticks across, as many as their numbers leave room for: few of long ones, as 999.98, 999.99 ...

    room : characters that go into the width of the axes
    """

    def __init__(self, room: float) -> None:
        super().__init__(steps=[1, 2, 2.5, 5, 10])
        self._room = room

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Places of the ticks in a range (n)."""
        ticks = np.empty(0)
        for count in range(9, 1, -1):
            self.set_params(nbins=count)
            ticks = np.asarray(super().tick_values(vmin, vmax))
            shown = ticks[(ticks >= vmin) & (ticks <= vmax)]
            if len(shown) * (_longest(shown) + TICKS_APART) <= self._room:
                break
        return ticks


def _longest(ticks: np.ndarray) -> int:
    """Characters of the longest of the numbers of ticks, all of the same decimals."""
    if len(ticks) < 2:
        return 1
    step = float(np.diff(ticks).min())
    places = next((n for n in range(17) if abs(round(step, n) - step) <= 1e-6 * step), 17)
    return max(len(f"{tick:.{places}f}") for tick in ticks.tolist())


def few_ticks(axes: Axes) -> None:
    """Ticks across that do not run into each other."""
    axes.xaxis.set_major_locator(FewTicks(characters(_width(axes))))


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
    width = float(np.nanmean(strokes)) if np.isfinite(strokes).any() else 0.0
    return 2.0 + 0.9 / (1.0 + width)


def time_axis(axes: Axes, span: Span) -> None:
    """A time axis that shows just the span, with few enough ticks for long numbers."""
    axes.set_xlim(*span)
    axes.set_xlabel("Time (s)")
    ticks = min(max(int(1.7 * _width(axes)), 3), 10)
    axes.xaxis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))


def _width(axes: Axes) -> float:
    """About how wide the axes are [inch], before anything is laid out."""
    return axes.bbox.width / sheet_of(axes).dpi


def sheet_of(axes: Axes) -> Figure:
    """The figure that axes stand on."""
    figure = axes.get_figure(root=True)
    assert isinstance(figure, Figure)
    return figure


# Numbers, symbols and units as they are written beside axes and curves.


# Prefix per power of 1000; what is smaller or larger keeps the last one.
_PREFIXES = {4: "T", 3: "G", 2: "M", 1: "k", 0: "", -1: "m", -2: "µ", -3: "n", -4: "p", -5: "f", -6: "a"}
LARGEST_POWER = {"m": 1, "rad": 0, "rad/s": 0, "N m/rad": 0}  # nobody measures displacements in megametres
SIGNIFICANT = range(3, 17)  # digits of a rounded number: as few as tell the numbers apart
POSITIONAL = (1e-4, 1e7)  # magnitudes written without a power of ten


@dataclass(frozen=True)
class Scale:
    """A unit that suits the values: value in SI x factor = value in `unit`."""

    factor: float
    unit: str

    def __call__(self, values: ArrayLike) -> np.ndarray:
        return np.asarray(values) * self.factor

    def label(self, words: str) -> str:
        """An axis label, such as `Displacement (mm)`."""
        return f"{words} ({self.unit})"


def scale_for(unit: str, *values: Iterable[float]) -> Scale:
    """The prefix under which the largest magnitude among `values` (arrays in SI `unit`) lies in [1, 1000).

    All zero, or empty: no prefix. Of several units with commas between them each has it.
    """
    arrays = [np.asarray(array, dtype=float) for array in values]
    largest = max(
        (float(np.nanmax(np.abs(a))) for a in arrays if a.size and not np.isnan(a).all()), default=0.0
    )
    if largest == 0.0 or not math.isfinite(largest):
        return Scale(1.0, unit)
    most = LARGEST_POWER.get(unit, max(_PREFIXES))
    power = min(max(math.floor(math.log10(largest) / 3 + 1e-12), min(_PREFIXES)), most)
    named = ", ".join(_PREFIXES[power] + one for one in unit.split(", "))
    return Scale(1000.0 ** (-power), named)


def amount(value: float, unit: str) -> str:
    """A quantity in words, four digits and a prefix: 12600 N/m is `12.6 kN/m`."""
    scale = scale_for(unit, [value])
    return f"{_positional(float(f'{float(scale(value)):.4g}'))} {scale.unit}"


def rounded(values: Sequence[float]) -> list[str]:
    """Numbers as decimals, rounded to as few digits (three at least) as tell different ones apart."""
    texts: list[str] = []
    distinct = len(set(values))
    for digits in SIGNIFICANT:
        texts = [_positional(float(f"{value:.{digits}g}")) for value in values]
        if len(set(texts)) == distinct:
            break
    return texts


def _positional(value: float) -> str:
    if value == 0 or POSITIONAL[0] <= abs(value) < POSITIONAL[1]:
        return np.format_float_positional(value, trim="-")
    return number(value, 6)


def signed(value: float, digits: int = 3) -> str:
    """A number of so many digits, its minus as long as those of the axes."""
    return f"{value:.{digits}g}".replace("-", "\N{MINUS SIGN}")


def hertz_text(hz: float) -> str:
    """A frequency beside its name: two decimals, of one below 1 Hz three digits."""
    return f"{hz:.2f}" if abs(hz) >= 1 else f"{hz:.3g}"


def symbol(column: str) -> str:
    """Mathtext of a column's name: x1 becomes $x_1$, a block's name an upright index."""
    index = column[1:].lstrip("_")
    if index.isdigit():
        return f"${column[0]}_{{{index}}}$"
    return rf"${column[0]}_\mathrm{{{index.replace('_', chr(92) + '_')}}}$"


def seconds(span: tuple[float, float]) -> str:
    """A span of time in words, such as `290–300 s`: to three digits of its length."""
    length = span[1] - span[0]
    places = max(0, 2 - math.floor(math.log10(length))) if length > 0 else 6
    return "–".join(np.format_float_positional(round(end, places), trim="-") for end in span) + " s"


# Names written beside curves, each where it covers no curve and no other name.


FONT_SIZE = 6.5
APART = 4.0  # pt between a point and its curve's name
CLEARANCE = 2.5  # pt around a curve that no name may touch
ALIGNMENTS = (  # horizontal, vertical: where the name stands from the point, the better first
    ("left", "center"), ("left", "top"), ("left", "bottom"),
    ("center", "top"), ("center", "bottom"), ("right", "center"), ("right", "top"), ("right", "bottom"),
)  # fmt: skip
SIDE = {"left": 1.0, "center": 0.0, "right": -1.0, "bottom": 1.0, "top": -1.0}


@dataclass(frozen=True)
class NamedQuantity:
    """A curve in data coordinates (n), the end that its name belongs to first; what its name looks like."""

    name: str
    x: np.ndarray
    y: np.ndarray
    look: dict[str, Any] = field(default_factory=dict)


def write_names(axes: Axes, curves: Sequence[NamedQuantity]) -> None:
    """Write the names, beside what is written on the axes already. Limits and scales must be final."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    lay_out(figure)
    clear = CLEARANCE * figure.dpi / 72
    covered = [Bbox(np.array([at - clear, at + clear])) for curve in curves for at in _along(axes, curve)]
    covered += [text.get_window_extent() for text in axes.texts]  # of an annotation, arrow included
    for curve in curves:
        box = _write(axes, curve, covered)
        covered.append(box)


def _write(axes: Axes, curve: NamedQuantity, covered: Sequence[Bbox]) -> Bbox:
    """Try every place; the first that is free, else the first."""
    tried: list[tuple[Any, Bbox]] = []
    for x, y in zip(curve.x, curve.y, strict=True):
        for across, along in ALIGNMENTS:
            text = axes.annotate(
                curve.name, (x, y), (APART * SIDE[across], APART * SIDE.get(along, 0.0)),
                textcoords="offset points", ha=across, va=along,
                **{"fontsize": points(FONT_SIZE), "gid": "name", **curve.look},
            )  # fmt: skip
            box = text.get_window_extent()
            if inside(box, axes.bbox) and not overlaps(box, covered):
                for other, _ in tried:
                    other.remove()
                return box
            tried.append((text, box))
    for other, _ in tried[1:]:
        other.remove()
    return tried[0][1]


def _along(axes: Axes, curve: NamedQuantity) -> np.ndarray:
    """Points along the polygon of a curve, in pixels (m, 2)."""
    corners = axes.transData.transform(np.column_stack([curve.x, curve.y]))
    parts = [np.linspace(a, b, 30) for a, b in pairwise(corners)]
    return np.concatenate([corners[:1], *parts])


def inside(box: Bbox, frame: Bbox) -> bool:
    """Whether a box lies within a frame."""
    return bool(box.x0 > frame.x0 and box.x1 < frame.x1 and box.y0 > frame.y0 and box.y1 < frame.y1)


def overlaps(box: Bbox, others: Iterable[Bbox]) -> bool:
    """Whether a box lies upon any of others."""
    return any(box.overlaps(other) for other in others)


# Labelled levels: horizontal lines across the axes, their names in the right margin, none upon another.


LINE_HEIGHT = 1.25  # of a label, in font sizes


@dataclass(frozen=True)
class Level:
    """A level of the y axis and its name."""

    value: float
    label: str
    look: dict[str, Any]


def draw_levels(axes: Axes, levels: Sequence[Level], height_pt: float, named: bool = True) -> None:
    """Draw the levels within the y limits, their names in the margin, moved apart where they would collide.

    height_pt : height of the axes [pt], as far as it is known before layout
    named : whether to write their names
    """
    low, high = axes.get_ylim()
    inside = sorted((level for level in levels if low <= level.value <= high), key=lambda level: level.value)
    heights = np.array([(level.value - low) / (high - low) for level in inside])
    places = spread(heights, points(FONT_SIZE) * LINE_HEIGHT / height_pt)
    for level, height, place in zip(inside, heights, places, strict=True):
        axes.axhline(
            level.value, **{"color": GREY, "linewidth": 0.5, "zorder": 2.95, "gid": "level", **level.look}
        )
        if not named:
            continue
        axes.annotate(
            level.label, (1.0, height), (8, place),
            xycoords="axes fraction", textcoords=("offset points", "axes fraction"),
            ha="left", va="center", fontsize=points(FONT_SIZE), color="0.25",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": GREY, "shrinkA": 1, "shrinkB": 0},
        )  # fmt: skip


def spread(heights: np.ndarray, gap: float) -> np.ndarray:
    """Places (n) for labels at ascending heights (n), `gap` apart or more, as near as that allows.

    Neighbours too close together form a group centred on its members (pool adjacent violators).
    """
    groups: list[tuple[float, int]] = []  # (mean of height minus own offset, members): where the group starts
    for height in heights:
        groups.append((float(height), 1))
        while len(groups) > 1 and groups[-2][0] + groups[-2][1] * gap > groups[-1][0]:
            (lower, n), (upper, m) = groups[-2:]
            groups[-2:] = [((n * lower + m * (upper - n * gap)) / (n + m), n + m)]
    return np.array([start + i * gap for start, members in groups for i in range(members)])


# Logarithmic axes whose ticks are plain numbers, few enough to stand beside each other.


WIDE = 2.0  # decades from which powers of ten are enough
SHORT = 0.5  # decades below which ticks are as on a linear axis
MOST = 6  # ticks of what is shorter


def draw_by_ratio(axes: Axes, which: str) -> None:
    """Make the axis x or y logarithmic."""
    axes.set(**{f"{which}scale": "log"})
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(Powers())
    axis.set_major_formatter(FuncFormatter(lambda value, _: _positional(float(f"{value:.6g}"))))
    axis.set_minor_formatter(NullFormatter())


class Powers(LogLocator):
    """Ticks at 1, 10, 100 ..., at 1, 2, 5, 10 ... of few decades, at equal steps of a short range."""

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        """Places of the ticks in a range."""
        if not 0 < vmin < vmax:
            return list(super().tick_values(vmin, vmax))
        decades = math.log10(vmax / vmin)
        if decades < SHORT:
            return [x for x in MaxNLocator(MOST, steps=[1, 2, 5, 10]).tick_values(vmin, vmax) if x > 0]
        self.set_params(subs=(1.0,) if decades >= WIDE else (1.0, 2.0, 5.0))
        return list(super().tick_values(vmin, vmax))


# PDF files that hold of their bitmaps what is drawn, and no more.
#
# matplotlib draws the long lines of a picture as bitmaps, each on a sheet of the whole figure (57 MB at 600
# dpi), cuts out what is drawn, and holds the cuts, views of their sheets, until the file is finished: half a
# gigabyte for nine panels. A copy of a cut lets go of its sheet.


class _File(PdfFile):
    """A file that copies bitmaps cut out of others."""

    def imageObject(self, image: Any) -> Any:
        return PdfFile.imageObject(self, image if image.base is None else image.copy())


class LeanPages(PdfPages):
    """Pages of a PDF, used as matplotlib's own."""

    def _ensure_file(self) -> PdfFile:
        if self._file is None:
            make: Callable[..., PdfFile] = _File
            self._file = make(self._filename, metadata=self._metadata)
        file: PdfFile = self._file
        return file

"""Maps of sweeps in colours: capture of the motor, and regime."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator

from vibsim.cases.problems import counted
from vibsim.plots.branches_over_sweeps import lay_loci
from vibsim.plots.samples import mark_frequencies
from vibsim.plots.sheet import draw_by_ratio, legend_below, letter_panels, note, rounded, say_inside, sheet
from vibsim.plots.style import BLUE, GREEN, ORANGE, PALE, PINK, SKY, VERMILLION, YELLOW
from vibsim.plots.subject import Subject, View
from vibsim.plots.sweep_axes import (
    AxesPlane,
    ascending,
    draws_by_ratio,
    is_speed,
    label_of,
    missing_note,
    numbers,
    plane_of,
    show_span,
    shown,
)
from vibsim.plots.sweep_curves import DIRECTION_NAMES, PAGE_CM, finish, frequencies, in_columns
from vibsim.sweeps.computations import CAPTURE_VERDICTS, REGIME_VERDICTS

# Capture over an ensemble of starts: how probable it is, and which starts lead to it.


HEIGHT_CM = 6.8
CAPTURED = CAPTURE_VERDICTS["captured"]


def draw_probability(subject: Subject, view: View) -> Figure:
    """Share of the members that are captured against what was swept, with Wilson's interval of 95 %."""
    result = subject.result
    axis = next(axis for axis in result.axes if len(axis) > 1 and axis is not result.members)
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    share = result.probability(result["capture"] == CAPTURED)
    directions = result.directions if result.plan.carry else result.directions[:1]
    for d, direction in enumerate(directions):
        order = ascending(axis)
        x, colour = numbers(axis)[order], (BLUE, VERMILLION)[d]
        estimate, low, high = (
            values[..., d].ravel()[order] for values in (share.estimate, share.low, share.high)
        )
        axes.fill_between(x, low, high, color=colour, alpha=0.2, linewidth=0, gid="interval")
        name = DIRECTION_NAMES[direction] if len(directions) > 1 else ""
        axes.plot(x, estimate, color=colour, marker="o", markersize=2, label=name, gid="probability")
    axes.set_ylim(-0.03, 1.03)
    show_span(axes, (x[0], x[-1]), 0.0, draws_by_ratio(axis), view)
    axes.set_xlabel(label_of(axis))
    axes.set_ylabel("Probability of capture")
    say(axes, f"{counted(len(result.members), 'start')} each; band: 95 %", subject)
    if is_speed(axis.key):
        mark_frequencies([axes], frequencies([subject]), (view.width_cm - 1.6) * 28)
    if len(directions) > 1:
        figure.legend(loc="outside lower center", ncols=2)
    return figure


def draw_starts(subject: Subject, view: View) -> Figure:
    """Start values of the members, coloured by the verdict: two of them, or one and the last speed."""
    result = subject.result
    verdicts = result["capture"][..., 0].ravel()
    figure, axes = starts_sheet(
        subject, view, HEIGHT_CM, verdicts, CAPTURE_MAP_SHADES,
        lambda: (result["final_speed"], r"Last speed $\dot\varphi/2\pi$ (Hz)"),
    )  # fmt: skip
    say(axes, f"captured: {percent_of(result, result['capture'] == CAPTURED)}", subject)
    legend_of(figure, CAPTURE_MAP_SHADES, verdicts)
    return figure


def say(axes: Axes, words: str, subject: Subject) -> None:
    """A note above the axes, and what of the sweep is missing."""
    note(axes, "; ".join(filter(None, [words, missing_note(subject)])))


def percent_of(result: Any, where: np.ndarray) -> str:
    """The share of the starts of an ensemble alone, with Wilson's interval of 95 %, in words."""
    share = result.probability(where)
    estimate, low, high = (float(100 * np.ravel(v)[0]) for v in (share.estimate, share.low, share.high))
    return f"{estimate:.3g} % ({low:.3g} to {high:.3g})"


# Verdicts on starts: which picture suits how many ranges, and shares of a verdict over two of them.


Picture = Callable[[Subject, View], Figure]


@dataclass(frozen=True)
class Pictures:
    """Pictures of a sweep's verdicts on capture.

    points : two ranges, one start each
    starts : an ensemble alone, its starts
    shares, share_map : an ensemble at every point of one range, of two
    """

    points: Picture
    starts: Picture
    shares: Picture
    share_map: Picture

    def draw(self, subject: Subject, view: View) -> Figure:
        """The one that suits the ranges of a sweep."""
        result = subject.result
        if result.members is None:
            return self.points(subject, view)
        ranges = sum(len(axis) > 1 for axis in result.axes if axis is not result.members)
        return (self.starts, self.shares, self.share_map)[ranges](subject, view)


def share_map(column: str, code: int, verdict: str) -> Picture:
    """Draws the share of the members whose value in a column is `code`, at every point of two ranges."""

    def draw(subject: Subject, view: View) -> Figure:
        plane, result = plane_of(subject), subject.result
        shares = result.probability(result[column] == code).estimate
        figure, panels = map_sheet(plane, 1, view)
        for d, axes in enumerate(panels):
            drawn = plane.lay(axes, plane.grid(shares, d), cmap="viridis", vmin=0, vmax=1, gid="share")
            label = f"Share {verdict} of {counted(len(result.members), 'start')}"
            figure.colorbar(drawn, ax=axes, label=label, pad=0.02, aspect=30)
        return figure

    return draw


# Verdicts as colours: a class for each, a colour for each class, and their legend.


FEW = 400  # points that a panel holds at full size
LIGHT = 0.75  # grey from which a point on white paper needs an edge
HATCHES = "0.25"  # their colour


def grey_of(colour: str) -> float:
    """The grey in which a colour prints, from 0 (black) to 1 (ITU-R BT.601)."""
    return float(np.dot(to_rgb(colour), (0.299, 0.587, 0.114)))


MARKERS = {  # of points, by the hatches of a cell of their class
    "": "o", "////": "^", "....": "s", "\\\\\\\\": "v", "----": "D", "xxxx": "P", "||||": "X", "++++": "*",
}  # fmt: skip


@dataclass(frozen=True)
class Shade:
    """One class of a verdict: its name, its colour, and hatches where its grey is that of another class."""

    name: str
    colour: str
    hatch: str = ""

    @property
    def edge(self) -> str:
        """The colour of the edge of a point: light ones have one."""
        return "0.3" if grey_of(self.colour) > LIGHT else "none"

    @property
    def marker(self) -> str:
        """The shape of a point, another one where a cell has hatches."""
        return MARKERS[self.hatch]


def lay_classes(axes: Axes, plane: AxesPlane, classes: np.ndarray, shades: Sequence[Shade], gid: str) -> None:
    """Colour and hatch cells by their class (n_up, n_across), an index into `shades`; NaN stays blank."""
    colours = ListedColormap([shade.colour for shade in shades])
    plane.lay(axes, classes, cmap=colours, vmin=-0.5, vmax=len(shades) - 0.5, gid=gid)
    for code, shade in enumerate(shades):
        if shade.hatch and np.any(classes == code):
            _hatch(axes, plane, classes == code, shade)


def _hatch(axes: Axes, plane: AxesPlane, cells: np.ndarray, shade: Shade) -> None:
    x, y = plane.spans()
    boxes = [
        Path([(x[i, a], y[k, b]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))])
        for k, i in np.argwhere(cells)
    ]
    look: dict[str, Any] = {
        "facecolor": "none",
        "edgecolor": HATCHES,
        "hatch": shade.hatch,
        "linewidth": 0,
        "zorder": 0.6,
    }
    axes.add_patch(PathPatch(Path.make_compound_path(*boxes), gid=f"hatch {shade.name}", **look))


def scatter_classes(
    axes: Axes, x: np.ndarray, y: np.ndarray, classes: np.ndarray, shades: Sequence[Shade], view: View
) -> None:
    """Points (n) coloured by their class (n), an index into `shades`; many are drawn small."""
    size = float(np.clip(3.0 * (FEW / max(len(x), 1)) ** 0.5, 0.8, 3.0))
    for code, shade in enumerate(shades):
        of = classes == code
        axes.plot(
            x[of], y[of], linestyle="none", marker=shade.marker, markersize=size, color=shade.colour,
            markeredgecolor=shade.edge, markeredgewidth=min(0.3, size / 10), gid=shade.name,
        )  # fmt: skip
    axes.margins(x=0.03, y=0.06)
    axes.set_xlim(*shown(*axes.get_xlim(), view))


def starts_sheet(
    subject: Subject,
    view: View,
    height_cm: float,
    classes: np.ndarray,
    shades: Sequence[Shade],
    beside: Callable[[], tuple[np.ndarray, str]],
) -> tuple[Figure, Axes]:
    """A sheet with two start values of the members of an ensemble alone, coloured by their class (n), an
    index into `shades`; of one start value against what `beside` gives, values and label.
    """
    spreads, drawn = subject.result.members.spreads, subject.result.members.drawn
    values, labels = [drawn[spread.key] for spread in spreads], [label_of(spread) for spread in spreads]
    if len(spreads) == 1:
        others, label = beside()
        values.append(others[..., 0].ravel())
        labels.append(label)
    figure = sheet(view, height_cm)
    axes = figure.subplots()
    scatter_classes(axes, values[0], values[1], classes, shades, view)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    return figure, axes


def legend_of(figure: Figure, shades: Sequence[Shade], classes: np.ndarray) -> None:
    """The legend of the classes that occur, with how many points each has."""
    known = classes[~np.isnan(classes)].astype(int)
    counts = np.bincount(known, minlength=len(shades))
    shown = [(shade, count) for shade, count in zip(shades, counts, strict=True) if count]
    if shown:
        edge: dict[str, Any] = {"edgecolor": HATCHES, "linewidth": 0.4}
        patches = [Patch(facecolor=shade.colour, hatch=shade.hatch, **edge) for shade, _ in shown]
        legend_below(figure, patches, [f"{shade.name} ({count})" for shade, count in shown], handlelength=1.2)


# Capture over two ranges: the verdict on every point, and the speed at which it was held.


COLOURS = {
    "undecided": VERMILLION, "not met": "0.93", "passed": PALE, "escaped": ORANGE, "captured": BLUE,
}  # fmt: skip
CAPTURE_MAP_SHADES = [Shade(name, COLOURS[name]) for name in CAPTURE_VERDICTS]
CAPTURE_MAP_CLASSES = 8  # of speeds, at most
MOST, WIDE = 0.9, 1.5  # share of the speeds that has classes; all have where they go little further
FINEST = 1e-3  # [Hz]
Extend = Literal["neither", "min", "max", "both"]
BEYOND: dict[tuple[bool, bool], Extend] = {
    (False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both",
}  # fmt: skip
HELD = [CAPTURE_VERDICTS["captured"], CAPTURE_VERDICTS["escaped"]]


def draw_map(subject: Subject, view: View) -> Figure:
    """Verdict of every point; beside it the speed of those that were captured, for good or for a while."""
    plane = plane_of(subject)
    result, directions = subject.result, plane.directions
    figure, grid = map_sheet(plane, 2, view)
    verdicts = result["capture"]
    speeds = np.where(np.isin(verdicts, HELD), result["capture_speed"], np.nan)
    for d in range(len(directions)):
        lay_classes(grid[2 * d], plane, plane.grid(verdicts, d), CAPTURE_MAP_SHADES, "capture")
        cells, known = plane.grid(speeds, d), speeds[~np.isnan(speeds)]
        edges, extend = speed_classes(known)
        norm = BoundaryNorm(edges, 256, extend=extend)
        held = plane.lay(grid[2 * d + 1], cells, cmap="viridis", norm=norm, gid="capture_speed")
        if np.isnan(cells).all():
            say_inside(grid[2 * d + 1], "no motor was captured")
            continue
        bar = figure.colorbar(
            held, ax=grid[2 * d + 1], label=_speed_label(known, extend), pad=0.02, aspect=30, ticks=edges
        )
        bar.ax.set_yticklabels(rounded(edges.tolist()))
        bar.ax.minorticks_off()
    legend_of(figure, CAPTURE_MAP_SHADES, verdicts[..., : len(directions)])
    return figure


def speed_classes(speeds: np.ndarray) -> tuple[np.ndarray, Extend]:
    """Edges of classes of speeds [Hz], a round step apart, and at which ends speeds lie beyond: "neither",
    "min", "max" or "both", as matplotlib has it.

    Most motors are held within a tenth of a hertz of one resonance, and some at others far off. Equal steps
    of colour are equal steps of speed over MOST of the speeds; what lies beyond has the colours of the ends.
    """
    if not speeds.size:
        return np.array([0.0, 1.0]), "neither"
    low, high = np.quantile(speeds, [(1 - MOST) / 2, (1 + MOST) / 2])
    wide = max(high - low, FINEST)
    if np.ptp(speeds) <= WIDE * wide:
        low, high = speeds.min(), speeds.max()
    ticks = MaxNLocator(CAPTURE_MAP_CLASSES, steps=[1, 2, 2.5, 5, 10]).tick_values(
        low, max(high, low + FINEST)
    )
    edges = np.asarray(ticks)
    return edges, BEYOND[bool(speeds.min() < edges[0]), bool(speeds.max() > edges[-1])]


def _speed_label(speeds: np.ndarray, extend: str) -> str:
    """Label of the colour bar, and how far speeds go beyond it."""
    if extend == "neither":
        return "Mean speed while held (Hz)"
    least, greatest = rounded([float(speeds.min()), float(speeds.max())])
    return f"Mean speed while held (Hz), {least} to {greatest}"


# Capture of the motor: a map over two ranges, or how probable it is over an ensemble of starts.


PICTURES = Pictures(draw_map, draw_starts, draw_probability, share_map("capture", CAPTURED, "captured"))


def capture_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """A map, shares or starts, as suits the sweep.

    Two ranges: verdict and speed of capture of every point, as colours; with an ensemble at every point, the
    share of its members that are captured. One range and an ensemble: that share against the range. An
    ensemble alone: its starts, coloured by the verdict. Loci are laid over maps.
    """
    (subject,) = (each for each in subjects if each.reads == "sweep")
    figure = PICTURES.draw(subject, view)
    lay_loci(figure, subject, [each.result for each in subjects if each.reads == "locus"])
    return figure


# The map of regimes: what kind of motion there is at every point of two ranges.


PERIODS = 4  # told apart; longer ones share a colour
REGIME_SHADES = [
    Shade("period 1", BLUE), Shade("period 2", SKY), Shade("period 3", GREEN, "\\\\\\\\"),
    Shade("period 4", YELLOW), Shade("longer period", PINK, "...."), Shade("quasi-periodic", ORANGE, "////"),
    Shade("chaotic", VERMILLION, "xxxx"), Shade("transient", "0.78", "||||"), Shade("undecided", "0.95"),
]  # fmt: skip
REGIME_CLASSES = {shade.name: code for code, shade in enumerate(REGIME_SHADES)}


def regime_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Regime of every point as a colour, periodic motion by its period in turns of the source."""
    (subject,) = subjects
    plane, result = plane_of(subject), subject.result
    classes = classes_of(result["regime"], result["regime_period"])
    figure, panels = map_sheet(plane, 1, view)
    for d, axes in enumerate(panels):
        lay_classes(axes, plane, plane.grid(classes, d), REGIME_SHADES, "regime")
    legend_of(figure, REGIME_SHADES, classes[..., : len(panels)])
    return figure


def classes_of(regimes: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Index into SHADES of each point, from its verdict and the periods after which it repeats; or NaN."""
    classes = np.full(regimes.shape, np.nan)
    for name, code in REGIME_VERDICTS.items():
        classes[regimes == code] = REGIME_CLASSES.get(name, np.nan)
    periodic = regimes == REGIME_VERDICTS["periodic"]
    classes[periodic] = np.minimum(periods[periodic], PERIODS + 1) - 1
    return classes


# The sheet of a map: its panels, labelled, with the natural frequencies where a speed is across.


PANEL_CM = 5.8
NAMES_CM = 2.6  # frequencies above, legend below


def map_sheet(plane: AxesPlane, each: int, view: View) -> tuple[Figure, np.ndarray]:
    """A figure and its panels (n), `each` for every direction, those of a direction together."""
    ways = plane.directions
    count = each * len(ways)
    columns = in_columns(count, view)
    rows = -(-count // columns)
    figure = sheet(view, min(PANEL_CM, (PAGE_CM - NAMES_CM) / rows) * rows + NAMES_CM)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    x, y = plane.spans()
    for which in plane.by_ratio:
        draw_by_ratio(grid[0, 0], which)
    grid[0, 0].set(xlim=shown(x[0, 0], x[-1, 1], view), ylim=(y[0, 0], y[-1, 1]))
    finish(grid, count, *plane.labels())
    panels = grid.ravel()[:count]
    for i, axes in enumerate(panels):
        axes.set_title(DIRECTION_NAMES[ways[i // each]] if len(ways) > 1 else "", loc="left", pad=3)
    note(panels[columns - 1], missing_note(plane.subject))
    if is_speed(plane.subject.result.axes[plane.across].key):
        for column in range(columns):
            width_pt = (view.width_cm / columns - 2.5) * 28
            mark_frequencies(list(panels[column::columns]), frequencies([plane.subject]), width_pt)
    letter_panels(list(panels))
    return figure, panels

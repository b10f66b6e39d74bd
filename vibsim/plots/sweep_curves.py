"""The curves of a sweep: one per direction and value of the other axes, along the axis that is drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, product
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure

from vibsim.cases.problems import counted
from vibsim.cases.schema_keys import LONG
from vibsim.plots.samples import Frequency, fractions, natural_frequencies
from vibsim.plots.sheet import legend_below, letter_panels, sheet
from vibsim.plots.style import BLUE, MARKERS, VERMILLION, overlay, points
from vibsim.plots.subject import Subject, View
from vibsim.plots.sweep_axes import (
    along,
    ascending,
    draws_by_ratio,
    is_motor_speed,
    label_of,
    numbers,
    positions,
    show_span,
    value_texts,
)
from vibsim.sweeps.points import quantile, summary

TUNING = {  # what natural frequencies depend on, in either form of a case
    "blocks.m1", "blocks.m2", "coupling.k1", "stop.k2", "excitation.m3",
    "bodies.*", "links.*.k", "stops.*.k", "motor.m3",
}  # fmt: skip
COLOURS = 7  # curves told apart by the colours of the style; more take those of a colour map
BRIGHTEST = 0.9  # part of the colour map in use: its end is too pale for lines
BANDS = ((0.05, 0.95), (0.25, 0.75))  # quantiles of the members of an ensemble
LONE, ALONE_PT, SHAPED_PT = MARKERS[0], 2.0, 2.6  # points that need not be told apart; sizes of points
LEAP, STEEPER = 0.05, 2.5  # from which a step is a leap: share of the range, times the steps beside it
ROOM = 0.02  # share of the span that is left on either side of it
UP, DOWN = 1, -1
DIRECTION_NAMES = {UP: "up", DOWN: "down"}


@dataclass(frozen=True)
class Curve:
    """One curve.

    Attributes
    ----------
    subject : the sweep that it belongs to
    family : number of its family, the curves that differ in direction alone
    title : what sets its family apart
    label : what sets the curve apart, for the legend
    x : values of the axis drawn along (n), Hz for a speed
    colour : its colour
    down : whether it was swept downwards
    members : size of the ensemble that the curve sums up, or None
    joined : whether neighbours belong together: not the members of an ensemble
    marker : shape of its points, by which families are told apart in grey print
    """

    subject: Subject
    family: int
    title: str
    label: str
    x: np.ndarray
    colour: Any
    down: bool
    members: int | None
    joined: bool
    _at: tuple[Any, ...]
    marker: str = LONE

    def values(self, name: str) -> np.ndarray:
        """Values of a column of the sweep along the curve, (n) or (n, section); of an ensemble the median."""
        return self.every(name) if self.members is None else quantile(self.every(name), 1, 0.5)

    def every(self, name: str) -> np.ndarray:
        """The same with all members of an ensemble: (n, members), or (n, members, section)."""
        return np.asarray(self.subject.result[name][self._at])

    def mean(self, name: str) -> np.ndarray:
        """The same, of an ensemble the mean: what adds up goes on to do so."""
        return self.every(name) if self.members is None else summary(self.every(name), 1).mean

    def bands(self, name: str) -> list[tuple[np.ndarray, np.ndarray]]:
        """Quantiles (n) of the members between which they lie, the wider first; none without an ensemble."""
        if self.members is None:
            return []
        return [tuple(quantile(self.every(name), 1, q) for q in ends) for ends in BANDS]  # type: ignore[misc]

    @property
    def apart(self) -> list[tuple[Any, int]]:
        """(axis, position on it) of what sets it apart from the other curves of its sweep."""
        axes = self.subject.result.axes
        return [(axis, at) for axis, at in zip(axes, self._at, strict=False) if isinstance(at, int)]

    @property
    def look(self) -> dict[str, Any]:
        """Line and markers: closed upwards, open and dashed downwards."""
        face = "white" if self.down else self.colour
        return {
            "color": self.colour, "linestyle": self._dashes, "marker": self.marker,
            "markersize": ALONE_PT if self.marker == LONE else SHAPED_PT, "markeredgewidth": 0.5,
            "markerfacecolor": face,
        }  # fmt: skip

    @property
    def _dashes(self) -> Any:
        if not self.joined:
            return "none"
        return (0, (4, 1.5)) if self.down else "-"


def curves(subjects: Sequence[Subject]) -> list[Curve]:
    """All curves of the subjects."""
    every = [(subject, others) for subject in subjects for others in _others(subject.result)]
    tones = _tones(subjects, len(every))
    listed = []
    for i, (subject, others) in enumerate(every):
        result, a = subject.result, along(subject.result)
        directions = result.directions if result.plan.carry else result.directions[:1]
        x = positions(result)
        order = np.argsort(x, kind="stable")
        alone = result.axes[a] is result.members  # then nothing but the ensemble is there to draw along
        members = None if alone or result.members is None else len(result.members)
        for d, direction in enumerate(directions):
            title = _title(subject, others, len(subjects) > 1)
            label = ", ".join(filter(None, [title, DIRECTION_NAMES[direction] if result.plan.carry else ""]))
            colour = _colour(i, len(every), direction, tones[i])
            marker = MARKERS[i] if len(every) <= COLOURS else LONE
            at = list(others)
            at.insert(a, order)
            listed.append(
                Curve(
                    subject,
                    i,
                    title,
                    label,
                    x[order],
                    colour,
                    direction == DOWN,
                    members,
                    not alone,
                    (*at, d),
                    marker,
                )
            )
    return listed


def no_load_speeds(curve: Curve) -> np.ndarray:
    """No-load speed of the motor [Hz] (n) at the points of a curve: Omega0 itself where it was swept, else
    what the swept number makes of it, such as a voltage to which Omega0 is proportional.
    """
    result = curve.subject.result
    axis = result.axes[along(result)]
    if is_motor_speed(axis.key) or axis is result.members:
        return curve.x
    case = curve.subject.case
    for other, position in curve.apart:
        case = case.with_values(other.changes(position))
    ends = [case.with_values(axis.changes(int(i))).scene().motor for i in ascending(axis)]
    return np.array([np.nan if motor is None else motor.Omega0 / (2 * np.pi) for motor in ends])


def _others(result: Any) -> Iterator[tuple[Any, ...]]:
    """Positions along the axes not drawn along, all members of an ensemble together."""
    lengths = [
        [slice(None)] if axis is result.members else range(len(axis))
        for i, axis in enumerate(result.axes)
        if i != along(result)
    ]
    return product(*lengths)


def _family_axes(result: Any) -> list[Any]:
    """The axes whose values tell curves apart."""
    return [axis for i, axis in enumerate(result.axes) if i != along(result) and axis is not result.members]


def _tones(subjects: Sequence[Subject], count: int) -> np.ndarray:
    """Places of `count` curves in the colour map, 0 to 1: by the value that tells them apart, or in turn."""
    axis = _toned_axis(subjects)
    values = np.arange(count, dtype=float) if axis is None else numbers(axis)
    if axis is not None and draws_by_ratio(axis):
        values = np.log(values)
    return np.asarray((values - values.min()) / (np.ptp(values) or 1.0))


def _toned_axis(subjects: Sequence[Subject]) -> Any | None:
    """The one axis whose values the colours of the curves tell, if there is just one."""
    axes = _family_axes(subjects[0].result)
    several = [axis for axis in axes if len(axis) > 1]
    return several[0] if len(subjects) == 1 and len(several) == 1 else None


def families(drawn: Sequence[Curve]) -> list[list[Curve]]:
    """The curves, those of a family together."""
    return [list(members) for _, members in groupby(drawn, key=lambda curve: curve.family)]


def _title(subject: Subject, others: tuple[Any, ...], named: bool) -> str:
    result = subject.result
    axes = [axis for i, axis in enumerate(result.axes) if i != along(result)]
    parts = [subject.name] if named else []
    values = [
        value_texts(axis)[i] for axis, i in zip(axes, others, strict=True) if axis is not result.members
    ]
    return ", ".join([*parts, *values])


def alone(curve: Curve) -> Curve:
    """The curve as it looks in a panel of its family."""
    direction = DOWN if curve.down else UP
    return replace(curve, colour=_colour(0, 1, direction, 0.0), label=DIRECTION_NAMES[direction], marker=LONE)


def _colour(index: int, count: int, direction: int, tone: float) -> Any:
    if count == 1:
        return VERMILLION if direction == DOWN else BLUE
    if count <= COLOURS:
        return overlay(index)["color"]
    return matplotlib.colormaps["viridis"](BRIGHTEST * tone)


def frequencies(subjects: Sequence[Subject], parts: bool = False) -> list[Frequency]:
    """Natural frequencies that hold for every point of every subject, equal ones once.

    parts : whether to add fractions of them
    """
    by_label: dict[tuple[str, float], Frequency] = {}
    for subject in subjects:
        if not TUNING & {LONG.pattern(key) for axis in subject.result.axes for key in axis.keys}:
            own = [*natural_frequencies(subject.scene), *(fractions(subject.scene) if parts else [])]
            by_label |= {(f.label, round(f.hz, 6)): f for f in own}
    return list(by_label.values())


def name_curves(figure: Figure, panels: Sequence[Axes], drawn: Sequence[Curve], **options: Any) -> None:
    """Add below the picture a legend of the curves (`options`), or a colour bar for many values."""
    subjects = list({id(curve.subject): curve.subject for curve in drawn}.values())
    axis, count = _toned_axis(subjects), len({curve.family for curve in drawn})
    if axis is not None and count > COLOURS:
        shades = matplotlib.colormaps["viridis"](np.linspace(0, BRIGHTEST, 256))
        scale = LogNorm if draws_by_ratio(axis) else Normalize
        norm = scale(float(numbers(axis).min()), float(numbers(axis).max()))
        bar = ScalarMappable(norm, ListedColormap(shades))
        figure.colorbar(
            bar, ax=list(panels), location="bottom", label=label_of(axis), aspect=40, pad=0.02, shrink=0.8
        )
        return
    handles, labels = panels[0].get_legend_handles_labels()
    named = [(handle, label) for handle, label in zip(handles, labels, strict=True) if label]
    if len(named) < 2:
        return
    if count > COLOURS:
        named = [named[0], named[len(named) // 2], named[-1]]  # of a colour map
    legend_below(figure, *zip(*named, strict=True), **options)


def draw_curve(axes: Axes, curve: Curve, values: np.ndarray, gid: str) -> None:
    """Values (n) along a curve: points, and lines between those that belong together. Where values leap, as a
    rule from one attractor to another, no line is drawn: nothing between was computed.
    """
    look, apart = {**curve.look, "label": curve.label, "zorder": 3}, leaps(values)
    if not len(apart) or not curve.joined:
        axes.plot(curve.x, values, gid=gid, **look)
        return
    axes.plot(curve.x, values, gid=gid, **{**look, "linestyle": "none", "label": ""})
    x, y = broken(curve.x, values, apart)
    axes.plot(x, y, gid="joined", **{**look, "marker": "none", "label": "", "zorder": 2.9})
    axes.plot([], [], **look)  # for the legend


def broken(x: np.ndarray, y: np.ndarray, apart: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A line (n) that is interrupted behind the points `apart`, such as those of `leaps`."""
    parts = (np.insert(np.asarray(each, float), apart + 1, np.nan) for each in (x, y))
    return next(parts), next(parts)


def fill(
    axes: Axes, x: np.ndarray, low: np.ndarray, high: np.ndarray, apart: np.ndarray, **look: Any
) -> None:
    """An area between two lines (n), none behind the points `apart`, such as those of `leaps`."""
    (across, below), (_, above) = (broken(x, each, apart) for each in (low, high))
    axes.fill_between(across, below, above, **look)


def leaps(values: np.ndarray) -> np.ndarray:
    """Places i at which values (n) leap from i to i + 1: by more than LEAP of their range, and than STEEPER
    times the steps on both sides.
    """
    values = np.where(np.isfinite(values), values, np.nan)  # an exponent of -inf is drawn nowhere
    steps = np.abs(np.diff(values))
    if len(steps) < 2:
        return np.empty(0, dtype=int)
    beside = np.fmax(np.append(steps[1:], 0.0), np.insert(steps[:-1], 0, 0.0))
    span = float(np.nanmax(values) - np.nanmin(values)) if not np.isnan(values).all() else 0.0
    return np.flatnonzero((steps > LEAP * span) & (steps > STEEPER * beside))


def draw_bands(axes: Axes, curve: Curve, name: str, scale: Callable[[Any], Any]) -> None:
    """Between which quantiles the members of an ensemble lie, as areas."""
    apart = leaps(np.asarray(curve.values(name)))
    for low, high in curve.bands(name):
        look = {"color": curve.colour, "alpha": 0.2, "linewidth": 0, "gid": "quantiles"}
        fill(axes, curve.x, scale(low), scale(high), apart, **look)


def ensemble_note(drawn: Sequence[Curve]) -> str:
    """Words for the line and bands of an ensemble; empty without one."""
    members = {curve.members for curve in drawn if curve.members is not None}
    if not members:
        return ""
    percent = ", ".join(f"{100 * low:.0f}–{100 * high:.0f} %" for low, high in BANDS)
    return f"median and {percent} of {counted(' or '.join(map(str, sorted(members))), 'member')}"


def limit(axes: Axes, drawn: Sequence[Curve], view: View) -> None:
    """The span of the parameter: the view's window in its unit, or everything."""
    low, high = min(curve.x.min() for curve in drawn), max(curve.x.max() for curve in drawn)
    axes_drawn = [curve.subject.result.axes[along(curve.subject.result)] for curve in drawn]
    show_span(axes, (low, high), ROOM, all(map(draws_by_ratio, axes_drawn)), view)


# Panels beside and below each other, as many in a row as the width of the picture allows.


PANEL_WIDTH_CM = 7.0  # at least
PAGE_CM = 23.0  # what a journal leaves of a page for a picture
FOOT_CM = 2.0  # axis label and legend below the panels


def in_columns(count: int, view: View, panel_cm: float = PANEL_WIDTH_CM) -> int:
    """Number of panels in a row, out of `count` of at least this width."""
    return min(count, max(1, int(view.width_cm // panel_cm)))


def spread_over(items: Sequence[Any], most: int) -> list[Any]:
    """At most so many of the items, evenly spread from the first to the last."""
    places = np.linspace(0, len(items) - 1, max(min(most, len(items)), 1))
    return [items[round(place)] for place in places]


@dataclass(frozen=True)
class CurvePanels:
    """Panels of their own for the curves of a sweep, as many as a page has room for.

    Attributes
    ----------
    figure : the figure
    drawn : the curves shown (n)
    panels : one below the other for each curve, (n, rows)
    omitted : words about curves left out; empty for none
    """

    figure: Figure
    drawn: list[Curve]
    panels: np.ndarray
    omitted: str

    @property
    def top_right(self) -> Axes:
        """The last panel of the upper row, for remarks."""
        columns = len({axes.get_subplotspec().colspan.start for axes in self.panels[:, 0]})
        axes: Axes = self.panels[columns - 1, 0]
        return axes


def curve_panels(
    curves: Sequence[Curve],
    view: View,
    heights_cm: Sequence[float],
    panel_cm: float = PANEL_WIDTH_CM,
    margins_cm: float = FOOT_CM,
) -> CurvePanels:
    """Panels for the curves, each with rows of these heights; axes are shared, curves named above them."""
    columns, rows = in_columns(len(curves), view, panel_cm), len(heights_cm)
    drawn = _as_many(curves, columns * max(1, int((PAGE_CM - margins_cm) / sum(heights_cm))))
    columns = min(columns, len(drawn))
    blocks = -(-len(drawn) // columns)
    figure = sheet(view, blocks * sum(heights_cm) + margins_cm)
    ratios = {"height_ratios": list(heights_cm) * blocks}
    grid = figure.subplots(blocks * rows, columns, squeeze=False, sharex=True, gridspec_kw=ratios)
    stacked = grid.reshape(blocks, rows, columns).transpose(0, 2, 1).reshape(-1, rows)
    for axes in stacked[len(drawn) :].ravel():
        axes.remove()
    panels = stacked[: len(drawn)]
    for row in panels.T:
        for i, axes in enumerate(row):
            axes.sharey(row[0]) if i else None
            axes.tick_params(labelleft=i % columns == 0)
    for i in range(max(0, len(drawn) - columns), len(drawn)):
        panels[i, -1].tick_params(labelbottom=True)
    for axes, curve in zip(panels[:, 0], drawn, strict=True):
        axes.set_title(curve.label, loc="left", pad=3, fontsize=points(7), gid="curve")
    letter_panels(list(panels.ravel()))
    left_out = f"{len(drawn)} of {len(curves)} curves" if len(drawn) < len(curves) else ""
    return CurvePanels(figure, drawn, panels, left_out)


def _as_many(curves: Sequence[Curve], most: int) -> list[Curve]:
    """At most so many of the curves, evenly spread, up and down of a family together."""
    together = families(curves)
    size = max(map(len, together))
    return [curve for family in spread_over(together, max(most // size, 1)) for curve in family]


def label_outer(panels: np.ndarray, x_label: str, y_labels: Sequence[str]) -> None:
    """Label what stands at the left and at the foot of panels (n, rows) of curves."""
    columns = len({axes.get_subplotspec().colspan.start for axes in panels[:, 0]})
    for axes in panels[-columns:, -1]:
        axes.set_xlabel(x_label)
    for stack in panels[::columns]:
        for axes, label in zip(stack, y_labels, strict=True):
            axes.set_ylabel(label)


def finish(grid: np.ndarray, count: int, x_label: str, y_label: str) -> None:
    """Take away the panels beyond `count` and label the axes at the left and at the foot of a grid (n, m)."""
    columns = grid.shape[1]
    for axes in grid.flat[count:]:
        axes.remove()
    for axes in grid.flat[max(0, count - columns) : count]:
        axes.set_xlabel(x_label)
        axes.tick_params(labelbottom=True)
    for axes in grid.flat[:count:columns]:
        axes.set_ylabel(y_label)

"""Branches as curves: solid where their orbits are stable, dashed where not, with marks at bifurcations."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

from vibsim.cases.quantities import UNITS
from vibsim.orbits.branches.node import ENERGY
from vibsim.orbits.branches.tracing import drawn, half_range, stretches
from vibsim.physics.rates import turning_columns
from vibsim.plots.sheet import (
    NamedQuantity,
    Scale,
    inside,
    lay_out,
    legend_above,
    legend_below,
    overlaps,
    scale_for,
    sheet,
    sheet_of,
    symbol,
    write_names,
)
from vibsim.plots.style import BLACK, GREY, overlay, points
from vibsim.plots.subject import PlotError, Subject, View
from vibsim.plots.sweep_axes import is_motor_speed, is_speed, label_of

WIDTH, DASHES = 1.0, (0, (3, 1.5))
LINE = 0.9  # width of the strokes of marks without an area, and at others 0.2 less [pt]
MARKS = {  # kind: marker, size [pt], filled, name: each tells itself by its shape, in black and white too
    "fold": ("x", 3.4, False, "fold"),
    "doubling": ("s", 3.2, False, "period doubling"),
    "neimark-sacker": ("D", 4.0, False, "Neimark–Sacker"),
    "branch point": ("P", 4.2, True, "branch point"),
    "corner": ("v", 3.8, True, "corner"),
    "hopf": ("*", 6.0, True, "Hopf point"),
    "grazing": ("^", 3.6, False, "grazing"),
    "sticking": ("1", 5.5, False, "stick begins or ends"),
}
STROKES = ("x", "1")  # markers without an area


@dataclass(frozen=True)
class CurvePiece:
    """A piece of a branch whose orbits are all stable, or all not: x and y (n)."""

    x: np.ndarray
    y: np.ndarray
    stable: bool


def pieces(branch: Any, x: Value, y: Value) -> list[CurvePiece]:
    """The pieces of a branch between changes of stability, which lie on its special points; smooth."""

    def value(orbit: Any) -> tuple[float, float]:
        return x(orbit), y(orbit)

    sizes = ranges([value(point.orbit) for point in branch.points])
    lines = []
    for stable, members in groupby(stretches(branch), key=lambda stretch: stretch.stable):
        parts = [drawn(each.at, (each.one, each.other), value, sizes) for each in members]
        line = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
        lines.append(CurvePiece(line[:, 0], line[:, 1], stable))
    return lines


def ranges(places: Sequence[tuple[float, ...]]) -> np.ndarray:
    """Extent of what is drawn in each direction, 1 where it has none."""
    spans = np.ptp(np.array(places), axis=0)
    return np.where(spans > 0, spans, 1.0)


def draw_branch(
    axes: Axes,
    branch: Any,
    x: Value,
    y: Value,
    colour: Any = BLACK,
    label: str = "",
    kinds: Sequence[str] = tuple(MARKS),
    size: float = 1.0,
) -> np.ndarray:
    """One branch with its bifurcations; `kinds` are marked, all of it larger or smaller by `size`. The places
    along it (n, 2).
    """
    parts = pieces(branch, x, y)
    for piece in parts:
        style = "-" if piece.stable else DASHES
        gid = "stable" if piece.stable else "unstable"
        axes.plot(piece.x, piece.y, color=colour, linestyle=style, linewidth=size * WIDTH, zorder=4, gid=gid)
    if label:
        axes.plot([], [], color=colour, linewidth=WIDTH, label=label)
    for kind in kinds:
        marker, pt, filled, _ = MARKS[kind]
        orbits = [special.orbit for special in branch.specials if special.kind == kind]
        if orbits:
            axes.plot(
                [x(o) for o in orbits], [y(o) for o in orbits], marker, color=colour, markersize=size * pt,
                markerfacecolor=colour if filled else "white", markeredgewidth=_stroke(marker) * size,
                gid=kind, zorder=6 if filled or marker in STROKES else 5,
            )  # fmt: skip
    return np.concatenate([np.column_stack([piece.x, piece.y]) for piece in parts])


def special_labels(
    branch: Any, x: Value, y: Value, kinds: Sequence[str] = tuple(MARKS), colour: Any = BLACK
) -> list[LabelledPoint]:
    """The labels of the printed list (PD1, NS1, GR1, ...) at the special points that are marked."""
    return [
        LabelledPoint(x(special.orbit), y(special.orbit), special.label, colour)
        for special in branch.specials
        if special.kind in kinds
    ]


def keys_to_marks(branches: Sequence[Any], kinds: Sequence[str] = tuple(MARKS)) -> list[Line2D]:
    """Legend entries of lines and marks that are drawn."""
    there = {special.kind for branch in branches for special in branch.specials}
    stable = any(branch["stable"].any() for branch in branches if branch.key != ENERGY)
    unstable = any(not branch["stable"].all() for branch in branches)
    keys = [Line2D([], [], color=BLACK, linewidth=WIDTH, label="stable")] * stable
    keys += [Line2D([], [], color=BLACK, linewidth=WIDTH, linestyle=DASHES, label="unstable")] * unstable
    return [*keys, *(_mark(kind) for kind in kinds if kind in there)]


def _mark(kind: str) -> Line2D:
    marker, size, filled, name = MARKS[kind]
    key = Line2D([], [], color=BLACK, marker=marker, markersize=size, linestyle="none", label=name)
    key.set_markerfacecolor(BLACK if filled else "white")
    key.set_markeredgewidth(_stroke(marker))
    return key


def _stroke(marker: str) -> float:
    return LINE if marker in STROKES else LINE - 0.2


# What is drawn of the orbits of a branch: parameter, mean speed of a motor, amplitude.


Value = Callable[[Any], float]  # of an orbit record


class ParameterAxis:
    """A parameter as the axis of a picture, with what `sweep_axes.label_of` asks of one."""

    def __init__(self, key: str, unit: str):
        self.key, self.unit, self.name = key, unit, key.rpartition(".")[2]


def parameter_of(branch: Any) -> Value:
    """The parameter of an orbit: in Hz for the speed of a source, else in its unit; of a backbone curve the
    frequency in place of the energy.
    """
    if branch.key == ENERGY:
        return mean_speed_of(branch)
    factor = parameter_factor(branch.key, branch.unit)
    return lambda orbit: float(orbit.parameter) * factor


def parameter_factor(key: str, unit: str) -> float:
    """Factor from a value in its unit to the number that is drawn: Hz for the speed of a source."""
    if not is_speed(key):
        return 1.0
    return float(UNITS[unit].factor) / (1.0 if UNITS[unit].per_turn else 2 * math.pi)


def parameter_label(subjects: Sequence[Subject]) -> str:
    """Label of the axis of the parameter; PlotError where branches are over different ones."""
    axes = [ParameterAxis(subject.result.key, subject.result.unit) for subject in subjects]
    if len({axis.key for axis in axes}) > 1:
        listed = ", ".join(f"{s.path} over {axis.key}" for s, axis in zip(subjects, axes, strict=True))
        raise PlotError(f"branches over different things do not go into one picture: {listed}")
    return "Frequency (Hz)" if axes[0].key == ENERGY else label_of(axes[0])


def scaled(value: Value, scale: Scale) -> Value:
    """The same in the unit of a scale."""
    return lambda orbit: float(scale(value(orbit)))


def mean_speed_of(branch: Any) -> Value:
    """Mean speed of the motor over an orbit [Hz]: its turns over their time."""
    turns = branch.plan.n
    return lambda orbit: turns / float(orbit.period)


def amplitude_of(branch: Any) -> Value:
    """Half the range of the first displacement of an orbit [m], from its extremes over a period."""

    family = branch.plan.family()
    return cache(lambda orbit: half_range(family.map(orbit.parameter), orbit))


def amplitude_words(branch: Any) -> str:
    """Label of the quantity whose half range `amplitude_of` is."""
    first, *rest = branch.names[0].split("-")
    return f"Amplitude of {symbol(first)}" + "".join(f" − {symbol(name)}" for name in rest)


# Labels of points, each near its point and upon no other.


LABEL_PT = 6.0  # size
RINGS_PT = (5.0, 9.0, 14.0, 20.0, 28.0, 38.0, 50.0, 64.0)  # distances of a label from its point, in turn
DIRECTIONS = np.radians([45, 135, -45, -135, 90, -90, 0, 180, 20, 160, -20, -160, 68, 112, -68, -112])
LEADER_PT = 11.0  # distance from which a thin line leads from the point to its label


@dataclass(frozen=True)
class LabelledPoint:
    """A point in data coordinates, its label and colour."""

    x: float
    y: float
    text: str
    colour: Any = "0"


def label_points(axes: Axes, points_labelled: Sequence[LabelledPoint]) -> int:
    """Write labels beside their points, clear of each other, of what is written on the axes and, where there
    is room, of the lines there; how many had no room and are left out. Limits and scales must be final.
    """
    figure = sheet_of(axes)
    lay_out(figure)
    pt = figure.dpi / 72
    covered = [text.get_window_extent() for text in axes.texts if text.get_text()]
    places = _pixels_of_lines(axes)
    shown = [one for one in dict.fromkeys(points_labelled) if _is_within(axes, one)]
    left_out = 0
    for one in shown:
        own = axes.transData.transform((one.x, one.y))
        text = axes.annotate(
            one.text, (one.x, one.y), (0, 0), textcoords="offset points", ha="center", va="center",
            fontsize=points(LABEL_PT), color=one.colour, gid="special label", zorder=7,
        )  # fmt: skip
        box = text.get_window_extent()
        size = np.array([box.width, box.height]) / 2
        offset = _free_offset(own, size, pt, (places, covered, axes.bbox))
        if offset is None:
            text.remove()
            left_out += 1
            continue
        text.xyann = tuple(offset / pt)
        if np.hypot(*offset) - np.hypot(*size) > LEADER_PT * pt:
            _lead(axes, own, own + offset, size, one.colour)
        covered.append(text.get_window_extent())
    return left_out


def _is_within(axes: Axes, one: LabelledPoint) -> bool:
    """Whether a point lies within the limits of its axes."""
    across, up = sorted(axes.get_xlim()), sorted(axes.get_ylim())
    return across[0] <= one.x <= across[1] and up[0] <= one.y <= up[1]


def _pixels_of_lines(axes: Axes) -> np.ndarray:
    """Places along all lines of axes that carry data, in pixels (n, 2)."""
    parts = [np.empty((0, 2))]
    for line in axes.get_lines():
        if line.get_transform() is axes.transData or line.get_transform() == axes.transData:
            corners = axes.transData.transform(np.column_stack(line.get_data()).astype(float))
            corners = corners[np.isfinite(corners).all(axis=1)]
            parts.append(corners)
            if line.get_linestyle() != "None" and len(corners) > 1:
                shares = np.linspace(0, 1, 12)[1:-1, None, None]
                parts.append((corners[:-1] + shares * np.diff(corners, axis=0)).reshape(-1, 2))
    return np.concatenate(parts)


def _free_offset(
    own: np.ndarray, size: np.ndarray, pt: float, taken: tuple[np.ndarray, Sequence[Bbox], Bbox]
) -> np.ndarray | None:
    """Offset of the middle of a label of half a size from its point [px]: the nearest place that is free,
    else the one that covers the least of lines; None where it would lie upon another label everywhere.
    """
    places, covered, frame = taken
    best: np.ndarray | None = None
    least = math.inf
    for ring in RINGS_PT:
        for angle in DIRECTIONS:
            way = np.array([math.cos(angle), math.sin(angle)])
            offset: np.ndarray = way * (ring * pt + float(np.abs(way) @ size))
            box = Bbox(np.array([own + offset - size - pt, own + offset + size + pt]))
            if not inside(box, frame) or overlaps(box, covered):
                continue
            upon = (places > box.min).all(axis=1) & (places < box.max).all(axis=1)
            crossed = int(np.count_nonzero(upon))
            if crossed == 0:
                return offset
            if crossed < least:
                best, least = offset, crossed
    return best


def _lead(axes: Axes, own: np.ndarray, middle: np.ndarray, size: np.ndarray, colour: Any) -> None:
    """A thin line from a point to the edge of its label."""
    way = own - middle
    share = min((s / abs(w) for s, w in zip(size, way, strict=True) if w), default=1.0)
    ends = axes.transData.inverted().transform([own, middle + min(share, 1.0) * way])
    axes.plot(
        *ends.T, color=colour, linewidth=0.35, alpha=0.7, scalex=False, scaley=False, zorder=6.5,
        gid="leader",
    )  # fmt: skip


# Several branches in one picture: each has a number, in the legend and at its curve, so that they are told
# apart in grey print too.


NUMBERED_PLACES, PARTS = 40, 4  # along a branch where its number may stand; of each piece between its corners
APART = 12.0  # pt between a branch and others: enough for its number


@dataclass(frozen=True)
class Drawn:
    """A branch as it is drawn: places along it (n, 2), its colour, the labels of its special points."""

    line: np.ndarray
    colour: Any
    labels: list[LabelledPoint]


def draw_branches(
    axes: Axes,
    subjects: Sequence[Subject],
    values: Sequence[tuple[Value, Value]],
    kinds: Sequence[str] = tuple(MARKS),
) -> list[Drawn]:
    """Draw branches in a colour each; of several the legend has numbers and names. `write_numbers` writes the
    numbers, when all else is drawn.

    values : what is drawn of each branch across and up
    kinds : of special points that are marked
    """
    drawn = []
    for i, (subject, (x, y)) in enumerate(zip(subjects, values, strict=True)):
        label = f"{i + 1}: {subject.name}" if len(subjects) > 1 else ""
        colour = overlay(i)["color"]
        line = draw_branch(axes, subject.result, x, y, colour, label, kinds)
        drawn.append(Drawn(line, colour, special_labels(subject.result, x, y, kinds, colour)))
    return drawn


def write_numbers(axes: Axes, drawn: Sequence[Drawn]) -> None:
    """Write the labels of special points, and the number of each of several branches where it ends, or else
    where it is apart from the others.

    Call it last: limits of the axes must be final.
    """
    if len(drawn) > 1:
        _write_numbers(axes, drawn)
    label_points(axes, [label for each in drawn for label in each.labels])


def _write_numbers(axes: Axes, drawn: Sequence[Drawn]) -> None:
    figure = axes.get_figure(root=True)
    assert figure is not None
    lay_out(figure)
    lines = [axes.transData.transform(each.line) for each in drawn]
    named = []
    for i, line in enumerate(lines):
        inside = line[[axes.bbox.contains(*place) for place in line.tolist()]]
        if len(inside):
            places = inside[np.linspace(len(inside) - 1, 0, NUMBERED_PLACES).round().astype(int)]
            others = np.concatenate([_dense(other) for j, other in enumerate(lines) if j != i])
            away = np.linalg.norm(places[:, None] - others, axis=2).min(axis=1) * 72 / figure.dpi
            order = np.argsort(-np.minimum(away, APART), kind="stable")
            x, y = axes.transData.inverted().transform(places[order]).T
            named.append(
                NamedQuantity(str(i + 1), x, y, {"color": drawn[i].colour, "gid": "number of a branch"})
            )
    write_names(axes, named)


def _dense(line: np.ndarray) -> np.ndarray:
    """Places along a polygon, some between its corners."""
    count = np.arange(len(line))
    shares = np.linspace(0, len(line) - 1, PARTS * (len(line) - 1) + 1)
    return np.column_stack([np.interp(shares, count, column) for column in line.T])


# The picture of branches over their parameter.


HEIGHT_CM = 7.0
ROTOR_SPEED = "Mean rotor speed (Hz)"
SPEED = r"Mean motor speed $\langle\dot\varphi\rangle/2\pi$ (Hz)"


def branch_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Solid where orbits are stable, dashed where not, marks at bifurcations; several are numbered.

    Under a motor, or by turns of a rotor, its mean speed against the parameter, of a motor with the line of
    the no-load speed; else the amplitude of the first displacement.
    """
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    branches = [subject.result for subject in subjects]
    motor = all(turning_columns(subject.scene) is not None for subject in subjects)
    values = [mean_speed_of(branch) if motor else amplitude_of(branch) for branch in branches]
    every = [[value(p.orbit) for p in b.points] for b, value in zip(branches, values, strict=True)]
    unit = Scale(1.0, "Hz") if motor else scale_for(branches[0].map.coordinates.units[0], *every)
    drawn = draw_branches(
        axes,
        subjects,
        [(parameter_of(branch), scaled(value, unit)) for branch, value in zip(branches, values, strict=True)],
    )
    axes.margins(x=0.02)
    if view.window is not None:
        axes.set_xlim(*view.window)
    if motor and is_motor_speed(branches[0].key):
        span = axes.get_xlim()
        axes.plot(span, span, color=GREY, linewidth=0.5, scalex=False, scaley=False, zorder=1, gid="no-load")
    axes.set_xlabel(parameter_label(subjects))
    speed = SPEED if subjects[0].scene.has_motor else ROTOR_SPEED
    axes.set_ylabel(speed if motor else unit.label(amplitude_words(branches[0])))
    if len(subjects) > 1:
        legend_above(axes)
    keys = keys_to_marks(branches)
    legend_below(figure, keys, [str(key.get_label()) for key in keys])
    write_numbers(axes, drawn)
    return figure

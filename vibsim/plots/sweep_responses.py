"""Responses over a sweep: amplitudes, stroboscopic points (bifurcation diagram), basins of attraction.

Over the first two go branches of periodic orbits, see `branches_over_sweeps`. Basins show which attractor
every start ends on, or the shares of attractors over a parameter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from vibsim.cases.problems import counted
from vibsim.physics.parts import GROUND
from vibsim.plots.branch_curves import label_points
from vibsim.plots.branches_over_sweeps import (
    amplitudes,
    check_branches,
    lay_branches,
    name_branches,
    sections,
)
from vibsim.plots.capture_pictures import HATCHES, Shade, lay_classes, map_sheet, starts_sheet
from vibsim.plots.samples import DISPLACEMENT, VELOCITY, difference, mark_frequencies
from vibsim.plots.sheet import Scale, legend_below, letter_panels, note, say_inside, scale_for, sheet
from vibsim.plots.style import BLUE, GREEN, MARKERS, ORANGE, PALE, PINK, SKY, VERMILLION, YELLOW, points
from vibsim.plots.subject import PlotError, Subject, View
from vibsim.plots.sweep_axes import (
    along,
    ascending,
    axis_label,
    draws_by_ratio,
    is_speed,
    label_of,
    missing_note,
    numbers,
    plane_of,
    show_span,
)
from vibsim.plots.sweep_curves import (
    PAGE_CM,
    Curve,
    CurvePanels,
    alone,
    curve_panels,
    curves,
    draw_bands,
    draw_curve,
    ensemble_note,
    fill,
    frequencies,
    label_outer,
    leaps,
    limit,
    name_curves,
)
from vibsim.plots.sweep_pictures import exponent_label, exponent_note, exponent_panel, has_exponents
from vibsim.sweeps.attractors import Attractors, parameter_axes
from vibsim.sweeps.quantities import DONE, NONE, last_points

# Amplitudes of a sweep against the frequency of the source, or whatever else was swept.


PANEL_CM = 3.1
BANDS_UP_TO = 2
HEADROOM = 1.06  # above the greatest amplitude
NO_AMPLITUDES = "no run went on for so long that it has an amplitude"
MOST = int((PAGE_CM - 2.4) / PANEL_CM)  # panels that a page has room for


def amplitude_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Frequency response: half the peak-to-peak per excitation period [m], its mean as a line, up to its
    greatest as a band; over it branches of periodic orbits, solid where stable, dashed where not.
    """
    branches = [subject for subject in subjects if subject.reads == "branch"]
    subjects = [subject for subject in subjects if subject.reads == "sweep"]
    check_branches(subjects, branches)
    drawn = curves(subjects)
    every = motions_of(subjects)
    shown = every[:MOST]
    figure = sheet(view, 2.4 + PANEL_CM * len(shown))
    panels = figure.subplots(len(shown), 1, squeeze=False, sharex=True)[:, 0]
    scales = _scales(drawn, shown)
    for axes, motion in zip(panels, shown, strict=True):
        having = [curve for curve in drawn if motion.column in curve.subject.result]
        _panel(axes, having, motion.column, scales[motion.unit])
        axes.set_ylabel(scales[motion.unit].label(motion.label))
    limit(panels[0], drawn, view)
    banded = len(drawn) <= BANDS_UP_TO and any(map(_is_banded, drawn))
    omitted = f"{len(shown)} of {len(every)} motions" if len(shown) < len(every) else ""
    words = ensemble_note(drawn) or ("band: up to the greatest" if banded else "")
    note(panels[0], "; ".join(filter(None, [omitted, words])))
    if all(is_speed(subject.result.axes[along(subject.result)].key) for subject in subjects):
        mark_frequencies(list(panels), frequencies(subjects), (view.width_cm - 1.6) * 28)
    figure.supylabel("Amplitude", fontsize=points(8))
    panels[-1].set_xlabel(axis_label(subjects))
    name_curves(figure, list(panels), drawn)
    marks = [
        (axes, lay_branches(axes, drawn, branches, amplitudes(motion.column, scales[motion.unit])))
        for axes, motion in zip(panels, shown, strict=True)
    ]
    name_branches(figure, panels[0], subjects, branches, drawn)
    letter_panels(list(panels))
    for axes, labels_of_points in marks:
        label_points(axes, labels_of_points)
    return figure


def motions_of(subjects: Sequence[Subject]) -> list[PictureQuantity]:
    """Amplitudes of the motions of all sweeps: those of two ends against each other, then those of bodies."""
    by_name: dict[str, PictureQuantity] = {}
    for subject in subjects:
        motions = subject.result.plan.point_settings.of.motions
        for motion in sorted(motions, key=lambda motion: motion.Q == GROUND):
            label = difference(subject.scene, motion, "x")
            by_name.setdefault(motion.name, PictureQuantity(f"amplitude_{motion.name}", label, motion.unit))
    return list(by_name.values())


def _scales(drawn: Sequence[Curve], motions: Sequence[PictureQuantity]) -> dict[str, Scale]:
    """By unit, m or rad, the scale of all panels that have it."""
    ends = "_max" if len(drawn) <= BANDS_UP_TO else ""
    values: dict[str, list[np.ndarray]] = {motion.unit: [] for motion in motions}
    for motion in motions:
        having = [curve for curve in drawn if motion.column in curve.subject.result]
        values[motion.unit] += [curve.every(f"{motion.column}{ends}") for curve in having]
    return {unit: scale_for(unit, *amplitudes) for unit, amplitudes in values.items()}


def _panel(axes: Axes, drawn: Sequence[Curve], column: str, scale: Scale) -> None:
    means = [curve.values(column) for curve in drawn]
    for curve, mean in zip(drawn, means, strict=True):
        draw_bands(axes, curve, column, scale)
        if len(drawn) <= BANDS_UP_TO and _is_banded(curve):
            most = curve.values(f"{column}_max")
            look = {"color": curve.colour, "alpha": 0.2, "linewidth": 0, "gid": "band"}
            fill(axes, curve.x, scale(mean), scale(most), leaps(mean), **look)
        draw_curve(axes, curve, scale(mean), column.removeprefix("amplitude_"))
    if all(np.isnan(mean).all() for mean in means):
        axes.set_ylim(0, 1)
        axes.set_yticks([])
        say_inside(axes, NO_AMPLITUDES)
        return
    axes.set_ylim(0, HEADROOM * axes.dataLim.y1 or 1)


def _is_banded(curve: Curve) -> bool:
    """Whether a band up to the greatest amplitude belongs to it: not to members of an ensemble."""
    return curve.members is None and curve.joined


# The orbit diagram: the stroboscopic points of every run of a sweep against what was swept.


VECTOR_UP_TO = 20_000  # points: more are pixels in a PDF or SVG
ORBIT_PANEL_CM, LONE_CM, ORBIT_PANEL_WIDTH_CM = 3.5, 4.2, 5.4
PANEL_PT = 180  # about the width of a panel
DOTS_PT = (0.8, 2.0)  # diameters, by how close the points of the sweep lie
SPEED = r"Speed $\dot\varphi/2\pi$"
ROWS = 3  # motions shown of a scene of named parts


@dataclass(frozen=True)
class PictureQuantity:
    """The quantity of one row of panels: a column of the sweep, its label and unit."""

    column: str
    label: str
    unit: str


def orbit_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Once per period of the source: displacements; motor speed, or velocity of a single displacement.

    Displacements are those of the ends of stops and links against each other, of bodies where there are none.

    Below, on the same axis, the Lyapunov exponents where the sweep has them. Every curve has panels of its
    own, up and down too: points upon points would hide each other. Of an ensemble the points of all members.
    Over them branches of periodic orbits, a line for every period of the source in an orbit.
    """
    branches = [subject for subject in subjects if subject.reads == "branch"]
    subjects = [subject for subject in subjects if subject.reads == "sweep"]
    check_branches(subjects, branches)
    every = curves(subjects)
    rows, below = quantities_of(subjects), has_exponents(subjects)
    height = LONE_CM if len(every) == 1 else ORBIT_PANEL_CM
    sheets = curve_panels(every, view, [height] * (len(rows) + below), ORBIT_PANEL_WIDTH_CM)
    drawn = [alone(curve) for curve in sheets.drawn]
    scales = [_scale(drawn, row) for row in rows]
    for stack, curve in zip(sheets.panels, drawn, strict=True):
        for axes, row, scale in zip(stack, rows, scales, strict=False):
            _orbit_panel(axes, curve, row.column, scale)
        if below:
            exponent_panel(stack[-1], [curve])
    limit(sheets.panels[0, 0], drawn, view)
    marks = [
        (axes, lay_branches(axes, [curve], branches, sections(row.column, scale)))
        for stack, curve in zip(sheets.panels, drawn, strict=True)
        for axes, row, scale in zip(stack, rows, scales, strict=False)
    ]
    labels = [scale.label(row.label) for row, scale in zip(rows, scales, strict=True)]
    label_outer(sheets.panels, axis_label(subjects), [*labels, *([exponent_label(drawn)] if below else [])])
    _orbit_say(sheets, subjects, drawn, below)
    name_branches(sheets.figure, sheets.top_right, subjects, branches, drawn)
    for axes, points_labelled in marks:
        label_points(axes, points_labelled)
    return sheets.figure


def quantities_of(subjects: Sequence[Subject]) -> list[PictureQuantity]:
    """Quantities of which all sweeps have stroboscopic points. Raises PlotError where there are none."""
    rows = _sections(subjects[0])
    rows = [row for row in rows if all(row.column in subject.result for subject in subjects)]
    displacements = [row for row in rows if row.unit in ("m", "rad")]
    if not displacements:
        raise PlotError("the sweeps have no stroboscopic points of the same motion")
    speeds = [row for row in rows if row.unit == "Hz"]
    rates = [row for row in rows if row.unit in ("m/s", "rad/s")]
    return [*displacements[:ROWS], *(speeds or (rates if len(displacements) == 1 else []))]


def _sections(subject: Subject) -> list[PictureQuantity]:
    """The sections of a sweep: of pairs where there are any, else of bodies."""
    of = subject.result.plan.point_settings.of
    pairs = {name: each for name, each in of.sections.items() if each[0].Q != GROUND}
    rows = [
        PictureQuantity(
            name,
            difference(subject.scene, motion, "v" if is_rate else "x"),
            f"{motion.unit}/s" if is_rate else motion.unit,
        )
        for name, (motion, is_rate) in (pairs or of.sections).items()
    ]
    if not of.of_parts:
        rows = [replace(row, label=DISPLACEMENT if row.unit == "m" else VELOCITY) for row in rows]
    return [*rows, *([PictureQuantity("section_speed", SPEED, "Hz")] if of.has_motor else [])]


def _orbit_say(sheets: CurvePanels, subjects: Sequence[Subject], drawn: Sequence[Curve], below: bool) -> None:
    """Note above the panels which points are drawn and which are left out; name the exponents under them."""
    count = max(subject.result.plan.section for subject in subjects)
    of_one = f"{last_points(count)} of each run"
    words = of_one if len(drawn) == 1 else f"{counted(count, 'point')} each"
    note(sheets.top_right, "; ".join(filter(None, [sheets.omitted, words])))
    if below:
        lowest = sheets.panels[0, -1]
        note(lowest, exponent_note(drawn))
        handles, labels = lowest.get_legend_handles_labels()
        if len(handles) > 1:
            legend_below(sheets.figure, handles, labels)


def _scale(drawn: Sequence[Curve], row: PictureQuantity) -> Scale:
    if row.unit == "Hz":
        return Scale(1.0, row.unit)
    return scale_for(row.unit, *(curve.every(row.column) for curve in drawn))


def _orbit_panel(axes: Axes, curve: Curve, name: str, scale: Scale) -> None:
    section = curve.every(name).reshape(len(curve.x), -1)
    x = np.broadcast_to(curve.x[:, np.newaxis], section.shape)
    apart_pt = PANEL_PT / len(curve.x)
    axes.plot(
        x.ravel(), scale(section.ravel()), linestyle="none", marker="o", markeredgewidth=0, gid=name,
        markersize=min(max(0.6 * apart_pt, DOTS_PT[0]), DOTS_PT[1]), color=curve.colour,
        rasterized=section.size > VECTOR_UP_TO,
    )  # fmt: skip
    axes.margins(y=0.06)


# Basins of attraction: which attractor every start ends on; shares of attractors over a parameter.


HEIGHT_CM = 6.8
STARTS_CM = 7.4  # as high as "Velocity at the start v(0) of mass (m/s)" is long
LINE_CM = 0.4  # of a legend
EDGE = 0.02  # of the range, beside the first and last mark
COLOURS = (  # of attractors or branches, those of the largest shares first; what prints alike is hatched
    (BLUE, ""), (ORANGE, ""), (PALE, ""), (VERMILLION, "////"), (GREEN, "...."), (PINK, "\\\\\\\\"),
    (YELLOW, "----"), (SKY, "xxxx"),
)  # fmt: skip
OTHERS = Shade("other attractors", "0.75", "||||")
UNDECIDED = Shade("undecided", "0.95", "++++")


def basins_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """A map, shares or starts, as suits the sweep.

    A parameter and starts at each of its values: the share of every attractor against it, a line for every
    branch. Two ranges: the attractor of every point, as colours, over two parameters its kind and period. An
    ensemble alone over two start values: its starts, coloured by the attractor.
    """
    (subject,) = subjects
    if shows_shares(subject):
        return _draw_shares(subject, view)
    return _draw_map(subject, view) if subject.result.members is None else _draw_starts(subject, view)


def shows_shares(subject: Subject) -> bool:
    """Whether the shares over the one parameter that is swept are drawn: it has several starts at a value."""
    result = subject.result
    parameters = [i for i in parameter_axes(result.plan) if len(result.axes[i]) > 1]
    starts = [axis for i, axis in enumerate(result.axes) if i not in parameters and len(axis) > 1]
    return len(parameters) == 1 and (len(starts) > 1 or result.members in starts)


Side = tuple[int, int]  # a branch, and whether the mirror image of its orbits


class _Classes:
    """The branches of the attractors of a sweep and their mirror images, those of the largest shares first,
    each with its colour.

    An attractor of a single combination of parameters is a branch of its own; over several parameters those
    of one kind and period have one colour.
    """

    def __init__(self, result: Any):
        attractors: Attractors = result.attractors
        self._attractors, self._branches = attractors, attractors["branch"]
        if sum(len(result.axes[i]) > 1 for i in parameter_axes(result.plan)) > 1:
            alike = np.column_stack([attractors["kind"], attractors["period"]])
            self._branches = np.unique(alike, axis=0, return_inverse=True)[1].ravel()
        counts: dict[Side, int] = {}
        for i, branch in enumerate(self._branches.tolist()):
            mirrored = round(attractors["share_mirror"][i] / attractors["share"][i] * attractors["count"][i])
            for side, count in ((0, int(attractors["count"][i]) - mirrored), (1, mirrored)):
                if count:
                    counts[branch, side] = counts.get((branch, side), 0) + count
        self.sides = sorted(counts, key=lambda side: (-counts[side], side))
        few = self.sides[: len(COLOURS)]
        self.shades = [Shade(self._words(*side), *look) for side, look in zip(few, COLOURS, strict=False)]
        self.shades += [OTHERS, UNDECIDED]

    @property
    def legend_cm(self) -> float:
        """Height of the lines of the legend beyond the first two [cm]."""
        return LINE_CM * max(len(self.shades) - 4, 0)

    def shares(self, branch: int, mirrored: int) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the attractors of a branch, and the shares of their orbits or of the mirror images."""
        attractors = self._attractors
        rows = np.flatnonzero(self._branches == branch)
        images = attractors["share_mirror"][rows]
        shares = images if mirrored else attractors["share"][rows] - images
        return rows[shares > 0], shares[shares > 0]

    def _words(self, branch: int, mirrored: int) -> str:
        """Kind, period and multiplier of the attractors of a branch, and their share."""
        rows, shares = self.shares(branch, mirrored)
        words = self._attractors.words(int(rows[0]))
        words = words if len(rows) == 1 else words.partition(",")[0]
        image = " (mirror image)" if mirrored else ""
        return f"{words}{image}: {100 * shares[0]:.3g} %" if len(rows) == 1 else f"{words}{image}"

    def of(self, labels: np.ndarray, mirrored: np.ndarray, status: np.ndarray) -> np.ndarray:
        """Index into the shades of each point; NaN where it was not computed."""
        branches = self._branches.tolist() or [NONE]
        codes = np.array([[self._code((branch, side)) for side in (0, 1)] for branch in branches], float)
        classes = np.where(labels == NONE, len(self.shades) - 1.0, codes[np.maximum(labels, 0), mirrored])
        return np.where(status == DONE, classes, np.nan)

    def _code(self, side: Side) -> int:
        place = self.sides.index(side) if side in self.sides else len(self.sides)
        return min(place, len(self.shades) - 2)

    def legend(self, figure: Figure, classes: np.ndarray, points: bool = False) -> None:
        """The legend of the classes that occur, as cells or as points, with how many are undecided."""
        known = classes[~np.isnan(classes)].astype(int)
        edge: dict[str, Any] = {"edgecolor": HATCHES, "linewidth": 0.4}
        shown = [shade for code, shade in enumerate(self.shades) if (known == code).any()]
        patches: list[Artist] = [Patch(facecolor=shade.colour, hatch=shade.hatch, **edge) for shade in shown]
        if points:
            patches = [
                Line2D([], [], linestyle="none", marker=shade.marker, markersize=4.5, color=shade.colour,
                       markeredgecolor=shade.edge, markeredgewidth=0.4) for shade in shown
            ]  # fmt: skip
        undecided = int((known == len(self.shades) - 1).sum())
        names = [f"undecided ({undecided})" if shade is UNDECIDED else shade.name for shade in shown]
        if shown:
            legend_below(figure, patches, names, handlelength=1.2)


def _draw_map(subject: Subject, view: View) -> Figure:
    plane, result = plane_of(subject), subject.result
    classes = _Classes(result)
    codes = classes.of(result["attractor"], result["attractor_mirrored"], result["status"])
    figure, panels = map_sheet(plane, 1, view)
    for d, axes in enumerate(panels):
        lay_classes(axes, plane, plane.grid(codes, d), classes.shades, "attractor")
    classes.legend(figure, codes[..., : len(panels)])
    return figure


def _draw_starts(subject: Subject, view: View) -> Figure:
    """Two start values of the members; of one alone, against the number of the attractor."""
    result, classes = subject.result, _Classes(subject.result)
    codes = classes.of(result["attractor"], result["attractor_mirrored"], result["status"])[..., 0].ravel()
    figure, axes = starts_sheet(
        subject, view, STARTS_CM + classes.legend_cm, codes, classes.shades,
        lambda: (result["attractor"], "Number of the attractor"),
    )  # fmt: skip
    note(axes, missing_note(subject))
    classes.legend(figure, codes, points=True)
    return figure


def _draw_shares(subject: Subject, view: View) -> Figure:
    """Shares with their standard errors, a line for every branch."""
    result = subject.result
    attractors, classes = result.attractors, _Classes(result)
    (position,) = (i for i in parameter_axes(result.plan) if len(result.axes[i]) > 1)
    axis = result.axes[position]
    figure = sheet(view, HEIGHT_CM + classes.legend_cm)
    axes = figure.subplots()
    for k, side in enumerate(classes.sides[: len(COLOURS)]):
        rows, shares = classes.shares(*side)
        values = numbers(axis)[attractors["point"][rows]]
        order = np.argsort(values, kind="stable")
        bars = np.sqrt(shares * (1 - shares) / _starts(attractors, rows))
        drawn = axes.errorbar(
            values[order], shares[order], bars[order], label=classes.shades[k].name,
            color=classes.shades[k].colour, marker=MARKERS[k % len(MARKERS)], markersize=2.5, capsize=1.5,
            elinewidth=0.7,
        )  # fmt: skip
        drawn.lines[0].set_gid(f"branch {side[0]}" + " mirrored" * side[1])
    x = numbers(axis)[ascending(axis)]
    axes.set_ylim(-0.03, 1.03)
    show_span(axes, (x[0], x[-1]), EDGE, draws_by_ratio(axis), view)
    axes.set_xlabel(label_of(axis))
    axes.set_ylabel("Share of the starts")
    handles, labels = axes.get_legend_handles_labels()
    legend_below(figure, handles, labels)
    undecided = int(((result["attractor"] == NONE) & (result["status"] == DONE)).sum())
    more = len(classes.sides) - len(COLOURS)
    remarks = [
        "bars: standard errors",
        f"{undecided} undecided" if undecided else "",
        f"{counted(more, 'more attractor')}, not drawn" if more > 0 else "",
        missing_note(subject),
    ]
    note(axes, "; ".join(filter(None, remarks)))
    return figure


def _starts(attractors: Attractors, rows: np.ndarray) -> np.ndarray:
    """Number of starts that the shares of attractors refer to."""
    return np.asarray(attractors["count"][rows] / attractors["share"][rows])

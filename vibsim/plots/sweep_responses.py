"""Responses over a sweep: amplitudes (frequency response) and stroboscopic points (bifurcation diagram).

Over both go branches of periodic orbits, see `branches_over_sweeps`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.physics.parts import GROUND
from vibsim.plots.branch_values import label_points
from vibsim.plots.branches_over_sweeps import (
    amplitudes,
    check_branches,
    lay_branches,
    name_branches,
    sections,
)
from vibsim.plots.samples import DISPLACEMENT, VELOCITY, difference, mark_frequencies
from vibsim.plots.sheet import Scale, legend_below, letter_panels, note, scale_for, sheet
from vibsim.plots.style import points
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import along, axis_label, is_speed
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
    frequencies,
    label_outer,
    limit,
    name_curves,
)
from vibsim.plots.sweep_pictures import exponent_label, exponent_note, exponent_panel, has_exponents
from vibsim.plots.view import PlotError, View

# Amplitudes of a sweep against the frequency of the source, or whatever else was swept.


PANEL_CM = 3.1
BANDS_UP_TO = 2
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
    labels = dict(list(every.items())[:MOST])
    names = list(labels)
    figure = sheet(view, 2.4 + PANEL_CM * len(names))
    panels = figure.subplots(len(names), 1, squeeze=False, sharex=True)[:, 0]
    scale = _common_scale(drawn, names)
    for axes, name in zip(panels, names, strict=True):
        _panel(axes, [curve for curve in drawn if f"amplitude_{name}" in curve.subject.result], name, scale)
        axes.set_ylabel(scale.label(labels[name]))
    limit(panels[0], drawn, view)
    banded = len(drawn) <= BANDS_UP_TO and any(map(_is_banded, drawn))
    omitted = f"{len(labels)} of {len(every)} motions" if len(labels) < len(every) else ""
    words = ensemble_note(drawn) or ("band: up to the greatest" if banded else "")
    note(panels[0], "; ".join(filter(None, [omitted, words])))
    if all(is_speed(subject.result.axes[along(subject.result)].key) for subject in subjects):
        mark_frequencies(list(panels), frequencies(subjects), (view.width_cm - 1.6) * 28)
    figure.supylabel("Amplitude", fontsize=points(8))
    panels[-1].set_xlabel(axis_label(subjects))
    name_curves(figure, list(panels), drawn)
    marks = [
        (axes, lay_branches(axes, drawn, branches, amplitudes(name, scale)))
        for axes, name in zip(panels, names, strict=True)
    ]
    name_branches(figure, panels[0], subjects, branches)
    letter_panels(list(panels))
    for axes, labels_of_points in marks:
        label_points(axes, labels_of_points)
    return figure


def motions_of(subjects: Sequence[Subject]) -> dict[str, str]:
    """Labels of the motions of all sweeps by name, as coordinates: those of two ends against each other, then
    those of bodies.
    """
    by_word: dict[str, str] = {}
    for subject in subjects:
        motions = subject.result.plan.recipe.of.motions
        for motion in sorted(motions, key=lambda motion: motion.Q == GROUND):
            by_word.setdefault(motion.name, difference(subject.scene, motion, "x"))
    return by_word


def _common_scale(drawn: Sequence[Curve], names: Sequence[str]) -> Scale:
    """One unit for all panels."""
    ends = "_max" if len(drawn) <= BANDS_UP_TO else ""
    return scale_for(drawn[0].subject.unit("m"), *(
        curve.every(f"amplitude_{name}{ends}")
        for curve in drawn for name in names if f"amplitude_{name}" in curve.subject.result
    ))  # fmt: skip


def _panel(axes: Axes, drawn: Sequence[Curve], name: str, scale: Scale) -> None:
    means = [curve.values(f"amplitude_{name}") for curve in drawn]
    for curve, mean in zip(drawn, means, strict=True):
        draw_bands(axes, curve, f"amplitude_{name}", scale)
        if len(drawn) <= BANDS_UP_TO and _is_banded(curve):
            most = curve.values(f"amplitude_{name}_max")
            axes.fill_between(
                curve.x, scale(mean), scale(most), color=curve.colour, alpha=0.2, linewidth=0, gid="band"
            )
        draw_curve(axes, curve, scale(mean), name)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.06)
    if all(np.isnan(mean).all() for mean in means):
        axes.set_ylim(0, 1)


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
    """What is drawn in one row of panels: a column of the sweep, its label and unit."""

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
    name_branches(sheets.figure, sheets.top_right, subjects, branches)
    for axes, points_labelled in marks:
        label_points(axes, points_labelled)
    return sheets.figure


def quantities_of(subjects: Sequence[Subject]) -> list[PictureQuantity]:
    """What all sweeps have stroboscopic points of, and is drawn; PlotError where that is nothing."""
    rows = _sections(subjects[0])
    rows = [row for row in rows if all(row.column in subject.result for subject in subjects)]
    displacements = [row for row in rows if row.unit == "m"]
    if not displacements:
        raise PlotError("the sweeps have no stroboscopic points of the same motion")
    speeds = [row for row in rows if row.unit == "Hz"]
    rates = [row for row in rows if row.unit == "m/s"]
    return [*displacements[:ROWS], *(speeds or (rates if len(displacements) == 1 else []))]


def _sections(subject: Subject) -> list[PictureQuantity]:
    """The sections of a sweep: of pairs where there are any, else of bodies."""
    of = subject.result.plan.recipe.of
    pairs = {name: each for name, each in of.sections.items() if each[0].Q != GROUND}
    rows = [
        PictureQuantity(
            name, difference(subject.scene, motion, "v" if is_rate else "x"), "m/s" if is_rate else "m"
        )
        for name, (motion, is_rate) in (pairs or of.sections).items()
    ]
    if not of.of_parts:
        rows = [replace(row, label=DISPLACEMENT if row.unit == "m" else VELOCITY) for row in rows]
    return [*rows, *([PictureQuantity("section_speed", SPEED, "Hz")] if of.has_motor else [])]


def _orbit_say(sheets: CurvePanels, subjects: Sequence[Subject], drawn: Sequence[Curve], below: bool) -> None:
    """What the points are and what is left out, above the panels; the names of the exponents under them."""
    count = max(subject.result.plan.section for subject in subjects)
    words = f"the last {count} stroboscopic points of each run" if len(drawn) == 1 else f"{count} points each"
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
    return scale_for(drawn[0].subject.unit(row.unit), *(curve.every(row.column) for curve in drawn))


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

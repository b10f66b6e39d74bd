"""The orbit diagram: the stroboscopic points of every run of a sweep against what was swept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.physics.parts import GROUND
from vibsim.plots.errors import PlotError
from vibsim.plots.motion.relative_motion import DISPLACEMENT, VELOCITY, difference
from vibsim.plots.page.quantities import Scale, scale_for
from vibsim.plots.page.sheet import legend_below, note
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import axis_label
from vibsim.plots.sweeps.curves import Curve, alone, curves, limit
from vibsim.plots.sweeps.lyapunov import exponent_label, exponent_note, exponent_panel, has_exponents
from vibsim.plots.sweeps.panels import CurvePanels, curve_panels, label_outer
from vibsim.plots.view import View

VECTOR_UP_TO = 20_000  # points: more are pixels in a PDF or SVG
PANEL_CM, LONE_CM, PANEL_WIDTH_CM = 3.5, 4.2, 5.4
PANEL_PT = 180  # about the width of a panel
DOTS_PT = (0.8, 2.0)  # diameters, by how close the points of the sweep lie
SPEED = r"Speed $\dot\varphi/2\pi$"
ROWS = 3  # motions shown of a scene of named parts


@dataclass(frozen=True)
class Quantity:
    """What is drawn in one row of panels: a column of the sweep, its label and unit."""

    column: str
    label: str
    unit: str


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Once per period of the source: displacements; motor speed, or velocity of a single displacement.

    Displacements are those of the ends of stops and links against each other, of bodies where there are none.

    Below, on the same axis, the Lyapunov exponents where the sweep has them. Every curve has panels of its
    own, up and down too: points upon points would hide each other. Of an ensemble the points of all members.
    """
    every = curves(subjects)
    rows, below = quantities_of(subjects), has_exponents(subjects)
    height = LONE_CM if len(every) == 1 else PANEL_CM
    sheets = curve_panels(every, view, [height] * (len(rows) + below), PANEL_WIDTH_CM)
    drawn = [alone(curve) for curve in sheets.drawn]
    scales = [_scale(drawn, row) for row in rows]
    for stack, curve in zip(sheets.panels, drawn, strict=True):
        for axes, row, scale in zip(stack, rows, scales, strict=False):
            _panel(axes, curve, row.column, scale)
        if below:
            exponent_panel(stack[-1], [curve])
    limit(sheets.panels[0, 0], drawn, view)
    labels = [scale.label(row.label) for row, scale in zip(rows, scales, strict=True)]
    label_outer(sheets.panels, axis_label(subjects), [*labels, *([exponent_label(drawn)] if below else [])])
    _say(sheets, subjects, drawn, below)
    return sheets.figure


def quantities_of(subjects: Sequence[Subject]) -> list[Quantity]:
    """What all sweeps have stroboscopic points of, and is drawn; PlotError where that is nothing."""
    rows = _sections(subjects[0])
    rows = [row for row in rows if all(row.column in subject.result for subject in subjects)]
    displacements = [row for row in rows if row.unit == "m"]
    if not displacements:
        raise PlotError("the sweeps have no stroboscopic points of the same motion")
    speeds = [row for row in rows if row.unit == "Hz"]
    rates = [row for row in rows if row.unit == "m/s"]
    return [*displacements[:ROWS], *(speeds or (rates if len(displacements) == 1 else []))]


def _sections(subject: Subject) -> list[Quantity]:
    """The sections of a sweep: of pairs where there are any, else of bodies."""
    of = subject.result.plan.recipe.of
    pairs = {name: each for name, each in of.sections.items() if each[0].Q != GROUND}
    rows = [
        Quantity(name, difference(subject.scene, motion, "v" if is_rate else "x"), "m/s" if is_rate else "m")
        for name, (motion, is_rate) in (pairs or of.sections).items()
    ]
    if not of.of_parts:
        rows = [replace(row, label=DISPLACEMENT if row.unit == "m" else VELOCITY) for row in rows]
    return [*rows, *([Quantity("section_speed", SPEED, "Hz")] if of.has_motor else [])]


def _say(sheets: CurvePanels, subjects: Sequence[Subject], drawn: Sequence[Curve], below: bool) -> None:
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


def _scale(drawn: Sequence[Curve], row: Quantity) -> Scale:
    if row.unit == "Hz":
        return Scale(1.0, row.unit)
    return scale_for(row.unit, *(curve.every(row.column) for curve in drawn))


def _panel(axes: Axes, curve: Curve, name: str, scale: Scale) -> None:
    section = curve.every(name).reshape(len(curve.x), -1)
    x = np.broadcast_to(curve.x[:, np.newaxis], section.shape)
    apart_pt = PANEL_PT / len(curve.x)
    axes.plot(
        x.ravel(), scale(section.ravel()), linestyle="none", marker="o", markeredgewidth=0, gid=name,
        markersize=min(max(0.6 * apart_pt, DOTS_PT[0]), DOTS_PT[1]), color=curve.colour,
        rasterized=section.size > VECTOR_UP_TO,
    )  # fmt: skip
    axes.margins(y=0.06)

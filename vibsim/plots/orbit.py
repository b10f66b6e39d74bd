"""The orbit diagram: the stroboscopic points of every run of a sweep against what was swept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.lyapunov import exponent_label, exponent_note, exponent_panel, has_exponents
from vibsim.plots.quantities import Scale, scale_for
from vibsim.plots.relative_motion import DISPLACEMENT, VELOCITY
from vibsim.plots.sheet import legend_below, note
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import axis_label
from vibsim.plots.sweep_curves import Curve, alone, curves, limit
from vibsim.plots.sweep_panels import CurvePanels, curve_panels, label_outer
from vibsim.plots.view import View

VECTOR_UP_TO = 20_000  # points: more are pixels in a PDF or SVG
PANEL_CM, LONE_CM, PANEL_WIDTH_CM = 3.5, 4.2, 5.4
PANEL_PT = 180  # about the width of a panel
DOTS_PT = (0.8, 2.0)  # diameters, by how close the points of the sweep lie
LABELS = {
    "section_displacement": DISPLACEMENT,
    "section_speed": r"Speed $\dot\varphi/2\pi$",
    "section_velocity": VELOCITY,
}
UNITS = {"section_displacement": "m", "section_speed": "Hz", "section_velocity": "m/s"}


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Once per period of the source: relative displacement; motor speed or relative velocity.

    Below, on the same axis, the Lyapunov exponents where the sweep has them. Every curve has panels of its
    own, up and down too: points upon points would hide each other. Of an ensemble the points of all members.
    """
    every = curves(subjects)
    second = "section_speed" if all("section_speed" in s.result for s in subjects) else "section_velocity"
    names, below = ("section_displacement", second), has_exponents(subjects)
    height = LONE_CM if len(every) == 1 else PANEL_CM
    sheets = curve_panels(every, view, [height] * (3 if below else 2), PANEL_WIDTH_CM)
    drawn = [alone(curve) for curve in sheets.drawn]
    scales = [_scale(drawn, name) for name in names]
    for stack, curve in zip(sheets.panels, drawn, strict=True):
        for axes, name, scale in zip(stack, names, scales, strict=False):
            _panel(axes, curve, name, scale)
        if below:
            exponent_panel(stack[2], [curve])
    limit(sheets.panels[0, 0], drawn, view)
    labels = [scale.label(LABELS[name]) for name, scale in zip(names, scales, strict=True)]
    label_outer(sheets.panels, axis_label(subjects), [*labels, *([exponent_label(drawn)] if below else [])])
    _say(sheets, subjects, drawn, below)
    return sheets.figure


def _say(sheets: CurvePanels, subjects: Sequence[Subject], drawn: Sequence[Curve], below: bool) -> None:
    """What the points are and what is left out, above the panels; the names of the exponents under them."""
    count = max(subject.result.plan.section for subject in subjects)
    words = f"the last {count} stroboscopic points of each run" if len(drawn) == 1 else f"{count} points each"
    note(sheets.top_right, "; ".join(filter(None, [sheets.omitted, words])))
    if below:
        lowest = sheets.panels[0, 2]
        note(lowest, exponent_note(drawn))
        handles, labels = lowest.get_legend_handles_labels()
        if len(handles) > 1:
            legend_below(sheets.figure, handles, labels)


def _scale(drawn: Sequence[Curve], name: str) -> Scale:
    unit = UNITS[name]
    return Scale(1.0, unit) if unit == "Hz" else scale_for(unit, *(curve.every(name) for curve in drawn))


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

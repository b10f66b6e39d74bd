"""The orbit diagram: the stroboscopic points of every run of a sweep against what was swept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.lyapunov import exponent_panel, has_exponents
from vibsim.plots.quantities import Scale, scale_for
from vibsim.plots.relative_motion import DISPLACEMENT, VELOCITY
from vibsim.plots.sheet import note, sheet
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import axis_label
from vibsim.plots.sweep_curves import Curve, curves, limit, name_curves
from vibsim.plots.view import View

VECTOR_UP_TO = 20_000  # points: more are pixels in a PDF or SVG
LABELS = {
    "section_displacement": DISPLACEMENT,
    "section_speed": r"Speed $\dot\varphi/2\pi$",
    "section_velocity": VELOCITY,
}
UNITS = {"section_displacement": "m", "section_speed": "Hz", "section_velocity": "m/s"}


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Once per period of the source: relative displacement; motor speed or relative velocity.

    Below, on the same axis, the Lyapunov exponents where the sweep has them.
    """
    drawn = curves(subjects)
    second = "section_speed" if all("section_speed" in s.result for s in subjects) else "section_velocity"
    below = has_exponents(subjects)
    figure = sheet(view, 13.2 if below else 9.6)
    panels = figure.subplots(3 if below else 2, 1, sharex=True)
    for axes, name in zip(panels, ("section_displacement", second), strict=False):
        _panel(axes, drawn, name)
    if below:
        exponent_panel(panels[2], drawn)
    limit(panels[0], drawn, view)
    panels[-1].set_xlabel(axis_label(subjects))
    count = max(subject.result.plan.section for subject in subjects)
    note(panels[0], f"the last {count} stroboscopic points of each run")
    name_curves(figure, panels[0], markerscale=6)
    return figure


def _panel(axes: Axes, drawn: Sequence[Curve], name: str) -> None:
    values = [curve.values(name) for curve in drawn]
    unit = UNITS[name]
    scale = Scale(1.0, unit) if unit == "Hz" else scale_for(unit, *values)
    for curve, section in zip(drawn, values, strict=True):
        x = np.broadcast_to(curve.x[:, np.newaxis], section.shape)
        axes.plot(
            x.ravel(), scale(section.ravel()), linestyle="none", marker=".", markersize=1.4,
            markeredgewidth=0, color=curve.colour, label=curve.label, gid=name,
            rasterized=section.size > VECTOR_UP_TO,
        )  # fmt: skip
    axes.margins(y=0.06)
    axes.set_ylabel(scale.label(LABELS[name]))

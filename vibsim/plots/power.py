"""Power flow: what the source gives on the average, and where it goes, against what was swept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.frequency_marks import mark_frequencies
from vibsim.plots.quantities import Scale, scale_for
from vibsim.plots.sheet import legend_below, note
from vibsim.plots.style import BLACK, GREY, ORANGE, PINK, SKY
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import SPEEDS, along, axis_label
from vibsim.plots.sweep_curves import Curve, curves, draw_bands, frequencies, limit
from vibsim.plots.sweep_panels import curve_panels, label_outer
from vibsim.plots.view import View

PANEL_CM = 4.4
PANEL_WIDTH_CM = 5.4
MARGINS_CM = 4.4  # names of frequencies above, label and legend below
TAKERS = {"damper": SKY, "friction": ORANGE, "stored": PINK}
WORDS = {"stored": "stored (beyond the line: released)"}


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Mean power of the source [W] as a line; what damper and friction take and what is stored as areas.

    The areas add up to the line (first law); of an ensemble all are means, and bands hold the members. One
    panel for each curve of the sweep, or for some of them, evenly spread, where a page has no room for all.
    """
    every = curves(subjects)
    sheet = curve_panels(every, view, (PANEL_CM,), PANEL_WIDTH_CM, MARGINS_CM)
    panels = sheet.panels[:, 0]
    limit(panels[0], sheet.drawn, view)
    names = [f"power_{name}" for name in ("source", *TAKERS)]
    scale = scale_for("W", *(curve.mean(name) for curve in sheet.drawn for name in names))
    for axes, curve in zip(panels, sheet.drawn, strict=True):
        _panel(axes, curve, scale)
    label_outer(sheet.panels, axis_label(subjects), [scale.label("Mean power")])
    members = [f"mean of {c.members} members, source with bands" for c in sheet.drawn if c.members][:1]
    note(sheet.top_right, "; ".join(filter(None, [sheet.omitted, *members])))
    if all(subject.result.axes[along(subject.result)].key in SPEEDS for subject in subjects):
        columns = len({axes.get_subplotspec().colspan.start for axes in panels})
        for i in range(columns):
            width_pt = (view.width_cm / columns - 1.6) * 28
            mark_frequencies(list(panels[i::columns]), frequencies(subjects), width_pt)
    handles, labels = panels[0].get_legend_handles_labels()
    legend_below(sheet.figure, handles, labels)
    return sheet.figure


def _panel(axes: Axes, curve: Curve, scale: Scale) -> None:
    below = np.zeros(len(curve.x))
    for name, colour in TAKERS.items():
        above = below + scale(curve.mean(f"power_{name}"))
        axes.fill_between(
            curve.x, below, above, color=colour, linewidth=0, label=WORDS.get(name, name), gid=f"power_{name}"
        )
        below = above
    source = replace(curve, colour=BLACK)
    draw_bands(axes, source, "power_source", scale)
    axes.plot(curve.x, scale(curve.mean("power_source")), label="source", gid="power_source", **source.look)
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1)

"""Power flow: what the source gives on the average, and where it goes, against what was swept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motion.frequency_marks import mark_frequencies
from vibsim.plots.page.quantities import Scale, scale_for
from vibsim.plots.page.sheet import legend_below, note
from vibsim.plots.style import BLACK, GREEN, GREY, ORANGE, PALE, PINK
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import along, axis_label, is_speed
from vibsim.plots.sweeps.curves import Curve, curves, draw_bands, frequencies, limit
from vibsim.plots.sweeps.panels import curve_panels, label_outer
from vibsim.plots.view import View

PANEL_CM = 4.4
PANEL_WIDTH_CM = 5.4
MARGINS_CM = 4.4  # names of frequencies above, label and legend below
GIVERS = ("power_source", "power_base", "power_belts")
TAKERS = {
    "power_damper": ("damper", PALE, ""),
    "power_stops": ("stops", GREEN, ""),
    "power_friction": ("friction", ORANGE, ""),
    "power_stored": ("stored (beyond the line: released)", PINK, "////"),
}  # words, colour and hatches


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Mean power of all sources [W] as a line; what dampers, stops and friction take and what is stored as
    areas.

    The areas add up to the line (first law); of an ensemble all are means, and bands hold the members. One
    panel for each curve of the sweep, or for some of them, evenly spread, where a page has no room for all.
    """
    every = curves(subjects)
    sheet = curve_panels(every, view, (PANEL_CM,), PANEL_WIDTH_CM, MARGINS_CM)
    panels = sheet.panels[:, 0]
    limit(panels[0], sheet.drawn, view)
    scale = scale_for(
        "W",
        *(
            values
            for curve in sheet.drawn
            for values in (source_power(curve), *absorbed_powers(curve).values())
        ),
    )
    for axes, curve in zip(panels, sheet.drawn, strict=True):
        _panel(axes, curve, scale)
    label_outer(sheet.panels, axis_label(subjects), [scale.label("Mean power")])
    members = [f"mean of {c.members} members, source with bands" for c in sheet.drawn if c.members][:1]
    note(sheet.top_right, "; ".join(filter(None, [sheet.omitted, *members])))
    if all(is_speed(subject.result.axes[along(subject.result)].key) for subject in subjects):
        columns = len({axes.get_subplotspec().colspan.start for axes in panels})
        for i in range(columns):
            width_pt = (view.width_cm / columns - 1.6) * 28
            mark_frequencies(list(panels[i::columns]), frequencies(subjects), width_pt)
    handles, labels = panels[0].get_legend_handles_labels()
    legend_below(sheet.figure, handles, labels)
    return sheet.figure


def source_power(curve: Curve) -> np.ndarray:
    """Mean power that sources, base and belts give together along a curve [W] (n)."""
    names = [name for name in GIVERS if name in curve.subject.result.plan.columns]
    total: np.ndarray = sum((curve.mean(name) for name in names[1:]), curve.mean(names[0]))
    return total


def absorbed_powers(curve: Curve) -> dict[str, np.ndarray]:
    """Mean powers that are taken and stored along a curve [W] (n), by column; those that are 0 left out."""
    names = [name for name in TAKERS if name in curve.subject.result.plan.columns]
    powers = {name: curve.mean(name) for name in names}
    return {name: values for name, values in powers.items() if name != "power_stops" or np.any(values)}


def _panel(axes: Axes, curve: Curve, scale: Scale) -> None:
    below = np.zeros(len(curve.x))
    for name, values in absorbed_powers(curve).items():
        words, colour, hatch = TAKERS[name]
        above = below + scale(values)
        look: dict[str, Any] = {"facecolor": colour, "edgecolor": "0.25", "hatch": hatch, "linewidth": 0}
        axes.fill_between(curve.x, below, above, label=words, gid=name, **look)
        below = above
    source = replace(curve, colour=BLACK)
    single = [
        name for name in GIVERS if name in curve.subject.result.plan.columns and np.any(curve.mean(name))
    ]
    if len(single) == 1:
        draw_bands(axes, source, single[0], scale)
    axes.plot(curve.x, scale(source_power(curve)), label="source", gid="power_source", **source.look)
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1)

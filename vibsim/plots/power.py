"""Power flow: what the source gives on the average, and where it goes, against what was swept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.frequency_marks import mark_frequencies
from vibsim.plots.quantities import Scale, scale_for
from vibsim.plots.sheet import note, sheet
from vibsim.plots.style import BLACK, GREY, ORANGE, PINK, SKY
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import SPEEDS, along, axis_label
from vibsim.plots.sweep_curves import Curve, curves, frequencies, limit, name_curves
from vibsim.plots.sweep_panels import finish, in_columns
from vibsim.plots.view import View

PANEL_CM = 4.4
PANELS_UP_TO = 12
HEADROOM = 0.16  # of the panel, for the name of the curve
TAKERS = {"damper": SKY, "friction": ORANGE, "stored": PINK}
WORDS = {"stored": "stored (beyond the line: released)"}


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Mean power of the source [W] as a line; what damper and friction take and what is stored as areas.

    The areas add up to the line (first law). One panel for each curve of the sweep, or
    for some of them, evenly spread, where they are too many.
    """
    every = curves(subjects)
    drawn = [every[i] for i in np.unique(np.linspace(0, len(every) - 1, PANELS_UP_TO).astype(int))]
    columns = in_columns(len(drawn), view)
    rows = -(-len(drawn) // columns)
    figure = sheet(view, PANEL_CM * rows + 2.0)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    limit(grid[0, 0], drawn, view)
    grid[0, 0].margins(y=HEADROOM)
    scale = scale_for(
        "W", *(curve.values(f"power_{name}") for curve in drawn for name in ("source", *TAKERS))
    )
    for axes, curve in zip(grid.flat, drawn, strict=False):
        _panel(axes, curve, scale)
    finish(grid, len(drawn), axis_label(subjects), scale.label("Mean power"))
    note(grid[0, -1], f"{len(drawn)} of {len(every)} curves" if len(drawn) < len(every) else "")
    if all(subject.result.axes[along(subject.result)].key in SPEEDS for subject in subjects):
        for panels in grid.T:
            mark_frequencies(list(panels), frequencies(subjects), (view.width_cm / columns - 1.6) * 28)
    name_curves(figure, grid[0, 0])
    return figure


def _panel(axes: Axes, curve: Curve, scale: Scale) -> None:
    below = np.zeros(len(curve.x))
    for name, colour in TAKERS.items():
        above = below + scale(curve.values(f"power_{name}"))
        axes.fill_between(
            curve.x, below, above, color=colour, linewidth=0, label=WORDS.get(name, name), gid=f"power_{name}"
        )
        below = above
    look = replace(curve, colour=BLACK).look
    axes.plot(curve.x, scale(curve.values("power_source")), label="source", gid="power_source", **look)
    axes.axhline(0, color=GREY, linewidth=0.5, zorder=1)
    behind = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}  # lines of frequencies end there
    axes.annotate(curve.label, (0.02, 0.96), xycoords="axes fraction", va="top", bbox=behind, gid="curve")

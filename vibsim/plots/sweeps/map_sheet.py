"""The sheet of a map: its panels, labelled, with the natural frequencies where a speed is across."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from vibsim.plots.motion.frequency_marks import mark_frequencies
from vibsim.plots.page.log_axis import draw_by_ratio
from vibsim.plots.page.sheet import letter_panels, note, sheet
from vibsim.plots.sweeps.axes import is_speed, shown
from vibsim.plots.sweeps.curves import DIRECTION_NAMES, frequencies
from vibsim.plots.sweeps.panels import PAGE_CM, finish, in_columns
from vibsim.plots.sweeps.plane import Plane, missing_note
from vibsim.plots.view import View

PANEL_CM = 5.8
NAMES_CM = 2.6  # frequencies above, legend below


def map_sheet(plane: Plane, each: int, view: View) -> tuple[Figure, np.ndarray]:
    """A figure and its panels (n), `each` for every direction, those of a direction together."""
    ways = plane.directions
    count = each * len(ways)
    columns = in_columns(count, view)
    rows = -(-count // columns)
    figure = sheet(view, min(PANEL_CM, (PAGE_CM - NAMES_CM) / rows) * rows + NAMES_CM)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    x, y = plane.spans()
    for which in plane.by_ratio:
        draw_by_ratio(grid[0, 0], which)
    grid[0, 0].set(xlim=shown(x[0, 0], x[-1, 1], view), ylim=(y[0, 0], y[-1, 1]))
    finish(grid, count, *plane.labels())
    panels = grid.ravel()[:count]
    for i, axes in enumerate(panels):
        axes.set_title(DIRECTION_NAMES[ways[i // each]] if len(ways) > 1 else "", loc="left", pad=3)
    note(panels[columns - 1], missing_note(plane.subject))
    if is_speed(plane.subject.result.axes[plane.across].key):
        for column in range(columns):
            width_pt = (view.width_cm / columns - 2.5) * 28
            mark_frequencies(list(panels[column::columns]), frequencies([plane.subject]), width_pt)
    letter_panels(list(panels))
    return figure, panels

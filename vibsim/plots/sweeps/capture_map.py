"""Capture over two ranges: the verdict on every point, and the speed at which it was held."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from vibsim.plots.page.quantities import rounded
from vibsim.plots.page.sheet import say_inside
from vibsim.plots.style import BLUE, ORANGE, PALE, VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.map_sheet import map_sheet
from vibsim.plots.sweeps.plane import plane_of
from vibsim.plots.sweeps.verdict_colours import Shade, lay_classes, legend_of
from vibsim.plots.view import View
from vibsim.sweeps.computations.capture_verdict import VERDICTS

COLOURS = {
    "undecided": VERMILLION, "not met": "0.93", "passed": PALE, "escaped": ORANGE, "captured": BLUE,
}  # fmt: skip
SHADES = [Shade(name, COLOURS[name]) for name in VERDICTS]
CLASSES = 8  # of speeds
WIDE_GAP = 0.15  # of the range of the speeds
SPEED_DECIMALS, FINEST = 3, 1e-3  # [Hz]
HELD = [VERDICTS["captured"], VERDICTS["escaped"]]


def draw_map(subject: Subject, view: View) -> Figure:
    """Verdict of every point; beside it the speed of those that were captured, for good or for a while."""
    plane = plane_of(subject)
    result, directions = subject.result, plane.directions
    figure, grid = map_sheet(plane, 2, view)
    verdicts = result["capture"]
    speeds = np.where(np.isin(verdicts, HELD), result["capture_speed"], np.nan)
    for d in range(len(directions)):
        lay_classes(grid[2 * d], plane, plane.grid(verdicts, d), SHADES, "capture")
        cells, edges = plane.grid(speeds, d), speed_classes(speeds[~np.isnan(speeds)])
        norm = BoundaryNorm(edges, 256)
        held = plane.lay(grid[2 * d + 1], cells, cmap="viridis", norm=norm, gid="capture_speed")
        if np.isnan(cells).all():
            say_inside(grid[2 * d + 1], "no motor was captured")
            continue
        bar = figure.colorbar(
            held, ax=grid[2 * d + 1], label="Mean speed while held (Hz)", pad=0.02, aspect=30, ticks=edges
        )
        bar.ax.set_yticklabels(rounded(edges.tolist()))
        bar.ax.minorticks_off()
    legend_of(figure, SHADES, verdicts[..., : len(directions)])
    return figure


def speed_classes(speeds: np.ndarray) -> np.ndarray:
    """Edges of classes of speeds [Hz] that hold equal numbers of the points; a wide gap parts classes too.

    Most motors are held within a tenth of a hertz of one resonance, and some at others far off: on a linear
    scale nearly all would have one colour.
    """
    if not speeds.size:
        return np.array([0.0, 1.0])
    ordered = np.sort(speeds)
    gaps = np.flatnonzero(np.diff(ordered) > WIDE_GAP * max(np.ptp(ordered), FINEST))
    edges = [
        *np.quantile(ordered, np.linspace(0, 1, CLASSES + 1)),
        *((ordered[gaps] + ordered[gaps + 1]) / 2),
    ]
    distinct = np.unique(np.round(edges, SPEED_DECIMALS))
    return distinct if len(distinct) > 1 else distinct[0] + np.array([-FINEST, FINEST])

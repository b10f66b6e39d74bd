"""Capture over two ranges: the verdict on every point, and the speed at which it was held."""

from __future__ import annotations

from typing import Literal

import numpy as np
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

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
CLASSES = 8  # of speeds, at most
MOST, WIDE = 0.9, 1.5  # share of the speeds that has classes; all have where they go little further
FINEST = 1e-3  # [Hz]
Extend = Literal["neither", "min", "max", "both"]
BEYOND: dict[tuple[bool, bool], Extend] = {
    (False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both",
}  # fmt: skip
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
        cells, known = plane.grid(speeds, d), speeds[~np.isnan(speeds)]
        edges, extend = speed_classes(known)
        norm = BoundaryNorm(edges, 256, extend=extend)
        held = plane.lay(grid[2 * d + 1], cells, cmap="viridis", norm=norm, gid="capture_speed")
        if np.isnan(cells).all():
            say_inside(grid[2 * d + 1], "no motor was captured")
            continue
        bar = figure.colorbar(
            held, ax=grid[2 * d + 1], label=_speed_label(known, extend), pad=0.02, aspect=30, ticks=edges
        )
        bar.ax.set_yticklabels(rounded(edges.tolist()))
        bar.ax.minorticks_off()
    legend_of(figure, SHADES, verdicts[..., : len(directions)])
    return figure


def speed_classes(speeds: np.ndarray) -> tuple[np.ndarray, Extend]:
    """Edges of classes of speeds [Hz], a round step apart, and at which ends speeds lie beyond: "neither",
    "min", "max" or "both", as matplotlib has it.

    Most motors are held within a tenth of a hertz of one resonance, and some at others far off. Equal steps
    of colour are equal steps of speed over MOST of the speeds; what lies beyond has the colours of the ends.
    """
    if not speeds.size:
        return np.array([0.0, 1.0]), "neither"
    low, high = np.quantile(speeds, [(1 - MOST) / 2, (1 + MOST) / 2])
    wide = max(high - low, FINEST)
    if np.ptp(speeds) <= WIDE * wide:
        low, high = speeds.min(), speeds.max()
    ticks = MaxNLocator(CLASSES, steps=[1, 2, 2.5, 5, 10]).tick_values(low, max(high, low + FINEST))
    edges = np.asarray(ticks)
    return edges, BEYOND[bool(speeds.min() < edges[0]), bool(speeds.max() > edges[-1])]


def _speed_label(speeds: np.ndarray, extend: str) -> str:
    """What the bar shows, and how far speeds go beyond it."""
    if extend == "neither":
        return "Mean speed while held (Hz)"
    least, greatest = rounded([float(speeds.min()), float(speeds.max())])
    return f"Mean speed while held (Hz), {least} to {greatest}"

"""Capture over two ranges: the verdict on every point and the speed at which it was held, or the share."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from vibsim.plots.map_sheet import map_sheet
from vibsim.plots.style import BLUE, ORANGE, SKY, YELLOW
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_plane import plane_of
from vibsim.plots.verdict_colours import Shade, lay_classes, legend_of
from vibsim.plots.view import View
from vibsim.sweeps.computations.capture_verdict import VERDICTS

COLOURS = {
    "undecided": YELLOW, "not met": "0.87", "passed": SKY, "escaped": ORANGE, "captured": BLUE,
}  # fmt: skip
SHADES = [Shade(name, COLOURS[name]) for name in VERDICTS]
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
        held = plane.lay(
            grid[2 * d + 1], plane.grid(speeds, d), cmap="viridis", gid="capture_speed", **_range(speeds)
        )
        if np.isnan(speeds).all():
            continue
        figure.colorbar(held, ax=grid[2 * d + 1], label="Mean speed while held (Hz)", pad=0.02, aspect=30)
    legend_of(figure, SHADES, verdicts[..., : len(directions)])
    return figure


def draw_probability_map(subject: Subject, view: View) -> Figure:
    """Share of the members that are captured, at every point of two ranges."""
    plane = plane_of(subject)
    result = subject.result
    shares = result.probability(result["capture"] == VERDICTS["captured"]).estimate
    figure, grid = map_sheet(plane, 1, view)
    for d, axes in enumerate(grid):
        shown = plane.lay(axes, plane.grid(shares, d), cmap="viridis", vmin=0, vmax=1, gid="probability")
        label = f"Share captured of {len(result.members)} starts"
        figure.colorbar(shown, ax=axes, label=label, pad=0.02, aspect=30)
    return figure


def _range(speeds: np.ndarray) -> dict[str, float]:
    """Limits of the colours, the same for every panel."""
    known = speeds[~np.isnan(speeds)]
    return {"vmin": float(known.min()), "vmax": float(known.max())} if known.size else {"vmin": 0, "vmax": 1}

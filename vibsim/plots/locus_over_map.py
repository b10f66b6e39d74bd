"""Loci of bifurcations over the map of a sweep, where both are over the same two parameters."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from vibsim.plots.errors import PlotError
from vibsim.plots.locus import axes_of, draw_locus
from vibsim.plots.style import VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_plane import plane_of

CELLS = {"capture", "capture_speed", "probability"}  # gids of the cells of a map


def lay_locus(figure: Figure, subject: Subject, locus: Any) -> None:
    """Draw a locus into every panel of a map. Raises PlotError where it is over something else."""
    result = subject.result
    if sum(len(axis) > 1 for axis in result.axes if axis is not result.members) != 2:
        raise PlotError(f"{subject.path} is no map of two ranges, over which a locus could be laid")
    plane = plane_of(subject)
    keys = [result.axes[i].key for i in (plane.across, plane.up)]
    ours = [axis.key for axis in axes_of(locus)]
    if ours != keys:
        raise PlotError(f"a locus over {' and '.join(ours)} does not lie in a map over {' and '.join(keys)}")
    for axes in figure.axes:
        if any(cells.get_gid() in CELLS for cells in axes.collections):
            limits = axes.get_xlim(), axes.get_ylim()
            draw_locus(axes, locus, VERMILLION, 1.2)
            axes.set_xlim(*limits[0])
            axes.set_ylim(*limits[1])

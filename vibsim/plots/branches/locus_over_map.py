"""Loci of bifurcations over the map of a sweep, where both are over the same two parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.branches.locus import axes_of, draw_locus, keys_to
from vibsim.plots.errors import PlotError
from vibsim.plots.page.sheet import add_below
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.plane import plane_of

CELLS = {"capture", "capture_speed", "share"}  # gids of the cells of a map
WIDTH = 1.4  # pt, to be seen on dark cells


def lay_loci(figure: Figure, subject: Subject, loci: Sequence[Any]) -> None:
    """Draw loci into every panel of a map, and name them below. Raises PlotError where they do not belong."""
    for locus in loci:
        _check(subject, locus)
    for axes in figure.axes:
        if any(cells.get_gid() in CELLS for cells in axes.collections):
            _lay(axes, loci)
    if loci:
        add_below(figure, keys_to(loci, WIDTH))


def _check(subject: Subject, locus: Any) -> None:
    """PlotError where the map is none, or over something else than the locus."""
    result = subject.result
    if sum(len(axis) > 1 for axis in result.axes if axis is not result.members) != 2:
        raise PlotError(f"{subject.path} is no map of two ranges, over which a locus could be laid")
    plane = plane_of(subject)
    keys = [result.axes[i].key for i in (plane.across, plane.up)]
    ours = [axis.key for axis in axes_of(locus)]
    if ours != keys:
        raise PlotError(f"a locus over {' and '.join(ours)} does not lie in a map over {' and '.join(keys)}")


def _lay(axes: Axes, loci: Sequence[Any]) -> None:
    limits = axes.get_xlim(), axes.get_ylim()
    for locus in loci:
        draw_locus(axes, locus, WIDTH)
    axes.set_xlim(*limits[0])
    axes.set_ylim(*limits[1])

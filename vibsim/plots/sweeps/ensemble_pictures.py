"""Verdicts on starts: which picture suits how many ranges, and shares of a verdict over two of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure

from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.map_sheet import map_sheet
from vibsim.plots.sweeps.plane import plane_of
from vibsim.plots.view import View

Picture = Callable[[Subject, View], Figure]


@dataclass(frozen=True)
class Pictures:
    """What is drawn of a sweep's verdicts.

    points : two ranges, one start each
    starts : an ensemble alone, its starts
    shares, share_map : an ensemble at every point of one range, of two
    """

    points: Picture
    starts: Picture
    shares: Picture
    share_map: Picture

    def draw(self, subject: Subject, view: View) -> Figure:
        """The one that suits the ranges of a sweep."""
        result = subject.result
        if result.members is None:
            return self.points(subject, view)
        ranges = sum(len(axis) > 1 for axis in result.axes if axis is not result.members)
        return (self.starts, self.shares, self.share_map)[ranges](subject, view)


def share_map(column: str, code: int, verdict: str) -> Picture:
    """Draws the share of the members whose value in a column is `code`, at every point of two ranges."""

    def draw(subject: Subject, view: View) -> Figure:
        plane, result = plane_of(subject), subject.result
        shares = result.probability(result[column] == code).estimate
        figure, panels = map_sheet(plane, 1, view)
        for d, axes in enumerate(panels):
            drawn = plane.lay(axes, plane.grid(shares, d), cmap="viridis", vmin=0, vmax=1, gid="share")
            label = f"Share {verdict} of {len(result.members)} starts"
            figure.colorbar(drawn, ax=axes, label=label, pad=0.02, aspect=30)
        return figure

    return draw

"""The plane of a sweep over two ranges: what was computed at each of its points, as coloured cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import along, ascending, draws_by_ratio, label_of, numbers
from vibsim.sweeps.statistics.columns import FAILED, MISSING


@dataclass(frozen=True)
class Plane:
    """Two axes of a sweep, that of the source's speed, or the first, across.

    Attributes
    ----------
    subject : the sweep
    across, up : positions of its two axes
    """

    subject: Subject
    across: int
    up: int

    def grid(self, values: np.ndarray, direction: int = 0) -> np.ndarray:
        """Values of the shape of the sweep, without members, as rows of the picture (n_up, n_across)."""
        plane = np.moveaxis(values[..., direction], (self.up, self.across), (0, 1))
        axes = self.subject.result.axes
        return np.asarray(
            plane.reshape(plane.shape[:2])[np.ix_(ascending(axes[self.up]), ascending(axes[self.across]))]
        )

    @property
    def directions(self) -> tuple[int, ...]:
        """Codes of the directions that make a difference."""
        result = self.subject.result
        directions: tuple[int, ...] = result.directions
        return directions if result.plan.carry else directions[:1]

    def lay(self, axes: Axes, cells: np.ndarray, **look: Any) -> Any:
        """Draw cells (n_up, n_across), each about its point; what has no value stays blank."""
        return axes.pcolormesh(
            *self.edges(), np.ma.masked_invalid(cells), zorder=0.5, rasterized=True, **look
        )

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Edges of the cells across (n_across + 1) and up (n_up + 1)."""
        across, up = (cell_edges(self.subject.result.axes[i]) for i in (self.across, self.up))
        return across, up

    @property
    def by_ratio(self) -> str:
        """Which of its axes x and y are logarithmic, their values spaced by ratio: x, y, xy or none."""
        axes = self.subject.result.axes
        return "".join(which for which, i in (("x", self.across), ("y", self.up)) if draws_by_ratio(axes[i]))

    def labels(self) -> tuple[str, str]:
        """Labels of the axes across and up."""
        across, up = (label_of(self.subject.result.axes[i]) for i in (self.across, self.up))
        return across, up


def plane_of(subject: Subject) -> Plane:
    """The plane of a sweep over two ranges; members of an ensemble do not count as one."""
    result = subject.result
    ranges = [i for i, axis in enumerate(result.axes) if axis is not result.members and len(axis) > 1]
    across = along(result) if along(result) in ranges else ranges[0]
    (up,) = (i for i in ranges if i != across)
    return Plane(subject, across, up)


def missing_note(subject: Subject) -> str:
    """How many points are left blank, and why; empty for none."""
    status = subject.result["status"]
    counts = {"not computed yet": (status == MISSING).sum(), "failed": (status == FAILED).sum()}
    return ", ".join(f"{count} {words}" for words, count in counts.items() if count)


def cell_edges(axis: Any) -> np.ndarray:
    """Edges (n + 1) of cells about the values of an axis; by ratio where its values are."""
    centres = np.sort(numbers(axis))
    return np.exp(_edges(np.log(centres), below_zero=True)) if draws_by_ratio(axis) else _edges(centres)


def _edges(centres: np.ndarray, below_zero: bool = False) -> np.ndarray:
    """Edges (n + 1) of cells about ascending points (n): half way between, and as far beyond the ends.

    Cells of what is nowhere negative begin at 0 at the least, no damping below none, unless `below_zero`.
    """
    middle = (centres[:-1] + centres[1:]) / 2
    first, last = 2 * centres[0] - middle[0], 2 * centres[-1] - middle[-1]
    return np.concatenate([[first if below_zero or centres[0] < 0 else max(first, 0.0)], middle, [last]])

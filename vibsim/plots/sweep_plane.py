"""The plane of a sweep over two ranges: what was computed at each of its points, as coloured cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.errors import PlotError
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import along, label_of, numbers
from vibsim.sweeps.columns import DONE, MISSING


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
        return plane.reshape(plane.shape[:2])

    @property
    def directions(self) -> tuple[int, ...]:
        """Codes of the directions that make a difference."""
        result = self.subject.result
        return result.directions if result.plan.carry else result.directions[:1]

    def lay(self, axes: Axes, cells: np.ndarray, **look: Any) -> Any:
        """Draw cells (n_up, n_across), each about its point; what has no value stays blank."""
        return axes.pcolormesh(
            *self.edges(), np.ma.masked_invalid(cells), zorder=0.5, rasterized=True, **look
        )

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Edges of the cells across (n_across + 1) and up (n_up + 1)."""
        across, up = (_edges(numbers(self.subject.result.axes[i])) for i in (self.across, self.up))
        return across, up

    def labels(self) -> tuple[str, str]:
        """Labels of the axes across and up."""
        across, up = (label_of(self.subject.result.axes[i]) for i in (self.across, self.up))
        return across, up


def plane_of(subjects: Sequence[Subject]) -> Plane:
    """The plane of the one sweep; members of an ensemble do not count as an axis.

    Raises PlotError for several sweeps, and for one of another number of ranges than two.
    """
    (subject,) = _alone(subjects)
    result = subject.result
    ranges = [i for i, axis in enumerate(result.axes) if axis is not result.members]
    long = [i for i in ranges if len(result.axes[i]) > 1]
    if len(long) != 2:
        listed = ", ".join(result.axes[i].name for i in long) or "nothing"
        raise PlotError(
            f"a map shows a sweep over two ranges, and {subject.path} is over {listed}; add --param KEY=RANGE"
        )
    across = along(result) if along(result) in long else long[0]
    (up,) = (i for i in long if i != across)
    return Plane(subject, across, up)


def _alone(subjects: Sequence[Subject]) -> Sequence[Subject]:
    if len(subjects) > 1:
        raise PlotError(f"a map shows one sweep at a time, not {len(subjects)}")
    return subjects


def missing_note(subject: Subject) -> str:
    """How many points are left blank, and why; empty for none."""
    status = subject.result["status"]
    missing, failed = int((status == MISSING).sum()), int((status != DONE).sum())
    failed -= missing
    parts = [f"{missing} not computed yet"] * bool(missing) + [f"{failed} failed"] * bool(failed)
    return ", ".join(parts)


def _edges(centres: np.ndarray) -> np.ndarray:
    """Edges (n + 1) of cells about ascending points (n): half way between, and as far beyond the ends."""
    middle = (centres[:-1] + centres[1:]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])

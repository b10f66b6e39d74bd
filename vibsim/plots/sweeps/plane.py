"""The plane of a sweep over two ranges: what was computed at each of its points, as coloured cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import along, ascending, draws_by_ratio, label_of, numbers
from vibsim.sweeps.statistics.columns import FAILED, MISSING

EVEN = 1e-6  # of the greatest distance between values: rounding of evenly spaced ones
NARROW, LEAST = (
    0.1,
    0.01,
)  # widths of a cell of uneven values, relative to all that is drawn: most, half of the least


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
        """Draw cells (n_up, n_across), each about its point; what has no value, and what lies between values
        that are far apart, stays blank.
        """
        (x, i), (y, k) = (_with_blanks(spans) for spans in self.spans())
        laid = np.full((len(y) - 1, len(x) - 1), np.nan)
        laid[np.ix_(k, i)] = cells
        return axes.pcolormesh(x, y, np.ma.masked_invalid(laid), zorder=0.5, rasterized=True, **look)

    def spans(self) -> tuple[np.ndarray, np.ndarray]:
        """From where to where the cells reach, across (n_across, 2) and up (n_up, 2)."""
        across, up = (cell_spans(self.subject.result.axes[i]) for i in (self.across, self.up))
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


def cell_spans(axis: Any) -> np.ndarray:
    """From where to where cells about the ascending values of an axis reach (n, 2).

    Evenly spaced values, three or more, have cells that touch half way between them; by ratio where the axis
    is. Of others nothing is known in between: a cell reaches no further than half way, nor than half of the
    median distance or than NARROW of the whole. Cells of what is nowhere negative begin at 0 at the least.
    """
    centres = np.sort(numbers(axis))
    if draws_by_ratio(axis):
        return np.asarray(np.exp(_about(np.log(centres), np.inf)))
    gaps = np.diff(centres)
    even = len(gaps) > 1 and np.ptp(gaps) <= EVEN * gaps.max()
    whole = float(np.ptp(centres))
    spans = _about(
        centres, np.inf if even else max(min(float(np.median(gaps)), NARROW * whole) / 2, LEAST * whole)
    )
    return spans if centres[0] < 0 else np.asarray(np.maximum(spans, 0.0))


def _about(centres: np.ndarray, most: float) -> np.ndarray:
    """Spans (n, 2) about ascending points (n): half way to their neighbours, and `most` at the most."""
    gaps = np.diff(centres)
    below, above = np.concatenate([gaps[:1], gaps]) / 2, np.concatenate([gaps, gaps[-1:]]) / 2
    middles = (centres[:-1] + centres[1:]) / 2
    low = np.concatenate([[centres[0] - below[0]], middles])
    high = np.concatenate([middles, [centres[-1] + above[-1]]])
    return np.column_stack([np.maximum(low, centres - most), np.minimum(high, centres + most)])


def _with_blanks(spans: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Edges (m + 1) of the cells of `spans` (n, 2) and of blanks between them; positions (n) of the cells."""
    edges, places = [float(spans[0, 0])], []
    for low, high in spans.tolist():
        if low > edges[-1]:
            edges.append(low)
        places.append(len(edges) - 1)
        edges.append(high)
    return np.array(edges), np.array(places)

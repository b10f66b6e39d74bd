"""Measures of basins from labels of starts: shares with errors, uncertainty exponent, basin entropy.

    basin stability        P. J. Menck, J. Heitzig, N. Marwan and J. Kurths, How basin stability complements
                           the linear-stability paradigm, Nature Physics 9 (2013) 89-92: the share of starts
                           that end on an attractor, a binomial estimate
    uncertainty exponent   S. W. McDonald, C. Grebogi, E. Ott and J. A. Yorke, Fractal basin boundaries,
                           Physica D 17 (1985) 125-153: a start is uncertain to eps where one eps away ends
                           elsewhere; their share grows as eps^alpha, and the boundary has the dimension
                           d - alpha in the plane of d = 2 start values
    basin entropy          A. Daza, A. Wagemakers, B. Georgeot, D. Guery-Odelin and M. A. F. Sanjuan, Basin
                           entropy: a new tool to analyze uncertainty in dynamical systems, Scientific
                           Reports 6 (2016) 31416: the mean over boxes of -sum p ln p over the labels in them;
                           boundary basin entropy is that of the boxes with more than one label

Mirror images of an orbit are two ends of starts here. Undecided starts do not count: a pair with one, and a
box of nothing else, tell nothing. Above ln 2 the boundary basin entropy shows a fractal boundary (the same
source); a smooth one stays below.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from math import nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from vibsim.physics.elementary import log, mean
from vibsim.sweeps.attractors import parameter_axes
from vibsim.sweeps.axes import Axis
from vibsim.sweeps.run_ends import NONE

if TYPE_CHECKING:
    from vibsim.sweeps.sweep_result import SweepResult

BOX = 5  # points along a side of the boxes, as in the source
FEWEST_BOXES = 4  # along an axis
LEAST_PAIRS = 100  # of starts at a distance, of which so many have two labels at least
FEWEST_SCALES = 3


@dataclass(frozen=True)
class FittedExponent:
    """An exponent by a line of least squares through logarithms, with its standard error; NaN: not known."""

    value: float
    error: float


@dataclass(frozen=True)
class BasinMeasures:
    """Measures of the basins in one plane of starts.

    uncertainty : alpha, and its standard error from the line alone
    entropy : basin entropy; boundary_entropy : of the boxes with more than one label; NaN where there is none
    boxes, boundary_boxes : how many there are
    """

    uncertainty: FittedExponent
    entropy: float
    boundary_entropy: float
    boxes: int
    boundary_boxes: int

    @property
    def boundary_dimension(self) -> float:
        """2 - alpha of the boundary in a plane."""
        return 2 - self.uncertainty.value


def basin_measures(result: SweepResult) -> BasinMeasures | None:
    """The measures of a sweep over a plane of two start values; None for every other sweep.

    Raises ValueError for a sweep without attractors.
    """
    found = result.attractors
    labels = np.where(found.labels == NONE, NONE, 2 * found.labels + found.mirrored)
    long = [i for i, length in enumerate(labels.shape) if length > 1]
    of_starts = [i for i in range(len(result.axes)) if i not in parameter_axes(result.plan)]
    if len(long) != 2 or not set(long) <= set(of_starts) or result.members is not None:
        return None
    plane = labels.reshape([labels.shape[i] for i in long])
    axes = [result.axes[i] for i in long]
    if any(isinstance(axis, Axis) and axis.by_ratio for axis in axes):
        return None
    entropy, boundary, boxes, boundary_boxes = basin_entropy(plane)
    return BasinMeasures(uncertainty_exponent(plane), entropy, boundary, boxes, boundary_boxes)


def uncertain_share(labels: np.ndarray, steps: int) -> tuple[int, int]:
    """(starts that one `steps` away along an axis ends elsewhere, starts of which it is known), in a plane
    (n, m) of labels. Of each start all neighbours in the plane count, two along each axis.
    """
    uncertain = np.zeros(labels.shape, dtype=bool)
    known = np.zeros(labels.shape, dtype=bool)
    for axis in (0, 1):
        first, last = [slice(None), slice(None)], [slice(None), slice(None)]
        first[axis], last[axis] = slice(None, -steps), slice(steps, None)
        one, other = labels[tuple(first)], labels[tuple(last)]
        pairs = (one != NONE) & (other != NONE)
        for side in (first, last):
            uncertain[tuple(side)] |= pairs & (one != other)
            known[tuple(side)] |= pairs
    return int(np.count_nonzero(uncertain)), int(np.count_nonzero(known))


def uncertainty_exponent(labels: np.ndarray) -> FittedExponent:
    """alpha from the shares of uncertain starts at distances of 1, 2, 4, ... steps of the grid, up to an
    eighth of its shorter side; NaN where there are fewer than three distances, or no boundary.
    """
    scales, shares = [], []
    for steps in _doubling(min(labels.shape) // 8):
        uncertain, known = uncertain_share(labels, steps)
        if uncertain and known >= LEAST_PAIRS:
            scales.append(log(float(steps)))
            shares.append(log(uncertain / known))
    return _line(np.array(scales), np.array(shares))


def _doubling(most: int) -> Iterator[int]:
    steps = 1
    while steps <= most:
        yield steps
        steps *= 2


def _line(x: np.ndarray, y: np.ndarray) -> FittedExponent:
    """Slope of the line of least squares."""
    if len(x) < FEWEST_SCALES:
        return FittedExponent(nan, nan)
    t, apart = x - mean(x), y - mean(y)
    square = len(t) * float(mean(t * t))
    slope = len(t) * float(mean(t * apart)) / square
    left = apart - slope * t
    spread = len(t) * float(mean(left * left)) / (len(t) - 2)
    return FittedExponent(slope, sqrt(spread / square))


def basin_entropy(labels: np.ndarray) -> tuple[float, float, int, int]:
    """Basin entropy and boundary basin entropy of a plane (n, m) of labels, and how many boxes there are of
    all and on the boundary. Boxes have BOX by BOX starts; what is left over at the edges has none.
    """
    if min(labels.shape) < FEWEST_BOXES * BOX:
        return nan, nan, 0, 0
    entropies = []
    for i in range(0, labels.shape[0] - BOX + 1, BOX):
        for k in range(0, labels.shape[1] - BOX + 1, BOX):
            box = labels[i : i + BOX, k : k + BOX]
            known = box[box != NONE]
            if len(known):
                _, counts = np.unique(known, return_counts=True)
                entropies.append(_entropy(counts.tolist()))
    if not entropies:
        return nan, nan, 0, 0
    every = np.array(entropies)
    boundary = every[every > 0]
    of_boundary = float(mean(boundary)) if len(boundary) else nan
    return float(mean(every)), of_boundary, len(every), len(boundary)


def _entropy(counts: list[int]) -> float:
    """-sum p ln p."""
    total = math.fsum(counts)
    entropy = 0.0
    for count in counts:
        if count < total:
            entropy -= count / total * log(count / total)
    return entropy


# In labelled lines for people, and for programs.


def attractor_lines(result: SweepResult, most: int = 12) -> list[tuple[str, str]]:
    """A line for each of the first attractors, one on what is undecided, one on the basins of a plane."""
    attractors = result.attractors
    lines = [(f"attractor {i}", _attractor_text(result, i)) for i in range(min(len(attractors), most))]
    if len(attractors) > most:
        lines.append(("attractors", f"and {len(attractors) - most} more"))
    undecided = _undecided(result)
    if undecided:
        listed = ", ".join(f"{count} {reason}" for reason, count in undecided.items())
        lines.append(("undecided", f"{sum(undecided.values())} points: {listed}"))
    measures = basin_measures(result)
    if measures is not None:
        lines += _measure_lines(measures)
    return lines


def _attractor_text(result: SweepResult, i: int) -> str:
    attractors = result.attractors
    share, error = (100 * attractors[name][i] for name in ("share", "share_error"))
    parts = [attractors.words(i), f"{share:.4g} % of the starts (± {error:.2g} %)"]
    if attractors["share_mirror"][i]:
        parts.append(f"its mirror image {100 * attractors['share_mirror'][i]:.4g} % of these starts")
    if attractors["word"][i]:
        parts.append(f"events {attractors['word'][i]}")
    if len(np.unique(attractors["point"])) > 1:
        place = _place(result, int(attractors["point"][i]))
        parts.append(f"at {place}, branch {attractors['branch'][i]}")
    return ", ".join(parts)


def _place(result: SweepResult, point: int) -> str:
    """The values of the parameters at one of their combinations."""
    axes = [result.axes[i] for i in parameter_axes(result.plan)]
    positions = np.unravel_index(point, [len(axis) for axis in axes])
    named = zip(axes, positions, strict=True)
    return ", ".join(f"{axis.name} = {axis.text(int(position))}" for axis, position in named)


def _undecided(result: SweepResult) -> dict[str, int]:
    """How many points are undecided, by the reason."""
    flags = result.plan.columns["attractor_reason"].flags
    of_kind = result["attractor_kind"] == result.plan.columns["attractor_kind"].flags["undecided"]
    counts = {
        name: int(np.count_nonzero(of_kind & (result["attractor_reason"] == code)))
        for name, code in flags.items()
    }
    return {name: count for name, count in counts.items() if count}


def _measure_lines(measures: BasinMeasures) -> list[tuple[str, str]]:
    lines = []
    if np.isfinite(measures.uncertainty.value):
        alpha = f"{measures.uncertainty.value:.3f} ± {measures.uncertainty.error:.2g}"
        lines.append(
            ("uncertainty", f"exponent {alpha}; boundary of dimension {measures.boundary_dimension:.3f}")
        )
    if measures.boxes:
        text = f"{measures.entropy:.4f} over {measures.boxes} boxes"
        if measures.boundary_boxes:
            text += f"; {measures.boundary_entropy:.4f} over {measures.boundary_boxes} on the boundary"
        lines.append(("basin entropy", text))
    return lines


def attractor_facts(result: SweepResult) -> dict[str, object]:
    """The attractors and the measures of their basins as plain data."""
    attractors, measures = result.attractors, basin_measures(result)
    listed = [
        {name: _plain(column[i]) for name, column in attractors.columns.items()}
        for i in range(len(attractors))
    ]
    facts: dict[str, object] = {"attractors": listed, "undecided": _undecided(result)}
    if measures is not None:
        facts["basins"] = {
            "uncertainty_exponent": _plain(measures.uncertainty.value),
            "uncertainty_error": _plain(measures.uncertainty.error),
            "basin_entropy": _plain(measures.entropy),
            "boundary_basin_entropy": _plain(measures.boundary_entropy),
        }
    return facts


def _plain(value: object) -> object:
    """A number, list or text for JSON; None where a number is not known."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value

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

    global integrity       M. S. Soliman and J. M. T. Thompson, Integrity measures quantifying the erosion of
                           smooth and fractal basins of attraction, Journal of Sound and Vibration 135 (1989)
                           453-475: the area of a basin in the plane, here of the window that was looked at
    local integrity        the same source: the smallest distance from the attractor to the boundary
    integrity factor       G. Rega and S. Lenci, Identifying, evaluating, and controlling dynamical integrity
                           measures in non-linear mechanical oscillators, Nonlinear Analysis 63 (2005)
                           902-914: the radius of the greatest circle that lies in the basin

Distances take both start values as velocities: displacements are multiplied by a natural rate, angles and
rates by lengths, as states are measured everywhere here. They are known to a step of the grid. What lies
beyond the window, is undecided or failed is outside of every basin.

Mirror images of an orbit are two ends of starts here. Undecided starts do not count: a pair with one, and a
box of nothing else, tell nothing. Above ln 2 the boundary basin entropy shows a fractal boundary (the same
source); a smooth one stays below.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from math import nan, sqrt
from typing import TYPE_CHECKING

import numpy as np

from vibsim.cases.problems import counted
from vibsim.engine.tangent.tangent_space import weights
from vibsim.orbits.coordinates import component_names, start_by_column
from vibsim.physics.elementary import log, mean
from vibsim.physics.numbers import Doubles
from vibsim.results.columns import starts_of
from vibsim.sweeps.attractor_labels import coordinates_of, orbit_of_label
from vibsim.sweeps.attractors import parameter_axes
from vibsim.sweeps.axes import Axis
from vibsim.sweeps.quantities import NONE

if TYPE_CHECKING:
    from vibsim.sweeps.sweep_result import SweepResult

BOX = 5  # points along a side of the boxes, as in the source
FEWEST_BOXES = 4  # along an axis
LEAST_PAIRS = 100  # of starts at a distance, of which so many have two labels at least
FEWEST_SCALES = 3
EVEN_STEPS = 1e-9  # of a step of the grid: how much steps may differ by rounding


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


# How far a basin reaches: areas, and radii of circles within it.


@dataclass(frozen=True)
class BasinIntegrity:
    """Integrity of one basin in a plane of two start values.

    attractor, mirrored : number of the attractor, and whether it is its mirror image
    share : of the starts of the plane; area : of the basin [product of both SI units]
    factor : radius of the greatest circle in it [m/s]
    local : smallest distance from the attractor to a start outside [m/s]; NaN where the plane does not hold
        the attractor, or the window does not
    step : of the grid, the longer one [m/s]: how well both are known
    """

    attractor: int
    mirrored: bool
    share: float
    area: float
    factor: float
    local: float
    step: float


@dataclass(frozen=True)
class _Side:
    """One axis of a plane of starts: column of the state, values [SI], weight by which it is a velocity."""

    column: str
    values: np.ndarray
    weight: float

    @property
    def step(self) -> float:
        """[SI]"""
        return abs(float(self.values[1] - self.values[0]))


def basin_integrity(result: SweepResult) -> list[BasinIntegrity]:
    """Integrity of the basin of each attractor, at each value of a parameter that is swept besides; empty for
    a sweep over anything but two start values with evenly spaced values.

    Over a parameter it is the resilience of a motion along its branch (`branch` of the attractors). Raises
    ValueError for a sweep without attractors.
    """
    found, plan = result.attractors, result.plan
    parameters = parameter_axes(plan)
    others = [i for i in range(len(plan.axes)) if i not in parameters and len(plan.axes[i]) > 1]
    sides = [_side(result, i) for i in others]
    if len(sides) != 2 or None in sides or result.members is not None or len(plan.directions) > 1:
        return []
    measured = []
    for i in range(len(found)):
        for mirrored in (False, True):
            inside = (found.labels == i) & (found.mirrored == mirrored)
            where = np.argwhere(inside)
            if not len(where):
                continue
            index = tuple(slice(None) if k in others else where[0][k] for k in range(inside.ndim))
            plane = [side for side in sides if side is not None]
            measured.append(_integrity(result, i, mirrored, inside[index], plane))
    return measured


def _side(result: SweepResult, i: int) -> _Side | None:
    """The axis of a start value; None where its values are not even, or set more than one."""
    axis = result.axes[i]
    if not isinstance(axis, Axis) or len(axis.keys) > 1 or len(axis) < 3:
        return None
    numbers = axis.numbers()
    if np.ptp(np.diff(numbers)) > EVEN_STEPS * np.abs(np.diff(numbers)).max():
        return None
    case = result.case
    scene = case.scene()
    starts = starts_of(scene, case.is_long)
    column = next((name for name, (key, _) in starts.items() if key == axis.key), None)
    if column is None:
        return None
    ends = [start_by_column(case.with_values(axis.changes(k)).scene())[column] for k in (0, len(axis) - 1)]
    place = component_names(scene).index(column)
    share = (numbers - numbers[0]) / (numbers[-1] - numbers[0])
    return _Side(column, ends[0] + share * (ends[1] - ends[0]), sqrt(weights(scene, Doubles)[place]))


def _integrity(
    result: SweepResult, i: int, mirrored: bool, inside: np.ndarray, sides: list[_Side]
) -> BasinIntegrity:
    """inside : of the plane (n, m), which starts end on the attractor."""
    steps = [side.step * side.weight for side in sides]
    outside = np.pad(~inside, 1, constant_values=True)
    squares = squared_distances(outside, (steps[0], steps[1]))
    local = [_distance(point, inside, sides) for point in _points_in_plane(result, i, mirrored, sides)]
    return BasinIntegrity(
        i,
        mirrored,
        float(np.count_nonzero(inside)) / inside.size,
        float(np.count_nonzero(inside)) * sides[0].step * sides[1].step,
        sqrt(float(squares.max())),
        min(local, default=nan),
        max(steps),
    )


def squared_distances(outside: np.ndarray, steps: tuple[float, float]) -> np.ndarray:
    """Squared distance from each point of a plane (n, m) to the nearest that is outside; steps : of its grid.

    Along the first axis by counting, then the least over the second: exact.
    """
    along = np.full(outside.shape, math.inf)
    for rows in (range(len(outside)), range(len(outside) - 1, -1, -1)):
        count = np.full(outside.shape[1], math.inf)
        for k in rows:
            count = np.where(outside[k], 0.0, count + 1)
            along[k] = np.minimum(along[k], count)
    first = (along * steps[0]) ** 2
    squares = first.copy()
    for apart in range(1, outside.shape[1]):
        far = (apart * steps[1]) ** 2
        squares[:, apart:] = np.minimum(squares[:, apart:], first[:, :-apart] + far)
        squares[:, :-apart] = np.minimum(squares[:, :-apart], first[:, apart:] + far)
    return np.asarray(squares)


def _points_in_plane(result: SweepResult, i: int, mirrored: bool, sides: list[_Side]) -> list[np.ndarray]:
    """The points of an attractor by the two start values (2) each [SI]; none where it has more unknowns, or
    is the mirror image.
    """
    attractors = result.attractors
    state, period = attractors["state"][i], float(attractors["period"][i])
    index = np.argwhere(attractors.labels == i)[0]
    scene = result.case_at(tuple(index.tolist())).scene()
    at = coordinates_of(scene)
    if mirrored or at is None or not np.isfinite(state).all() or period < 0:
        return []
    orbit = orbit_of_label(scene, state, period) if period > 0 else None
    points = orbit.points if orbit is not None else state[np.newaxis]
    columns = [side.column for side in sides]
    shown = {name for name in at.components if name is not None}
    if set(columns) != shown:
        return []
    return [np.array([at.state(X)[name] for name in columns]) for X in points]


def _distance(point: np.ndarray, inside: np.ndarray, sides: list[_Side]) -> float:
    """Smallest distance [m/s] from a point of the plane to a start outside, or to the edge of the window."""
    edges = [min(x - side.values.min(), side.values.max() - x) for x, side in zip(point, sides, strict=True)]
    if min(edges) < 0:
        return nan
    rows, columns = np.nonzero(~inside)
    across = (sides[0].values[rows] - point[0]) * sides[0].weight
    along = (sides[1].values[columns] - point[1]) * sides[1].weight
    nearest = sqrt(float((across**2 + along**2).min(initial=math.inf)))
    return float(min(nearest, *(edge * side.weight for edge, side in zip(edges, sides, strict=True))))


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
        lines.append(("undecided", f"{counted(sum(undecided.values()), 'point')}: {listed}"))
    measures = basin_measures(result)
    if measures is not None:
        lines += _measure_lines(measures)
        lines += _integrity_lines(basin_integrity(result)[:most])
    return lines


def _integrity_lines(measured: list[BasinIntegrity]) -> list[tuple[str, str]]:
    lines = []
    for one in measured:
        name = f"{one.attractor}{'m' if one.mirrored else ''}"
        near = f", local {one.local:.4g} m/s" if math.isfinite(one.local) else ""
        lines.append(
            (
                f"integrity {name}",
                f"global {one.share:.4f}{near}, factor {one.factor:.4g} m/s (± {one.step:.2g})",
            )
        )
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
    """Number of undecided points, by the reason."""
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
        text = f"{measures.entropy:.4f} over {counted(measures.boxes, 'box')}"
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
    integrity = basin_integrity(result)
    if integrity:
        facts["integrity"] = [
            {name: _plain(value) for name, value in asdict(one).items()} for one in integrity
        ]
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

"""Branches of periodic orbits over the pictures of a sweep: frequency response, bifurcation diagram, speeds.

A sweep tells of each run the mean of half the peak-to-peak over the periods of the source, and the states at
their ends. The same is read off an orbit of n periods by running it through once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibsim.cases.quantities import UNITS
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.branches.node import ENERGY
from vibsim.orbits.coordinates import placed
from vibsim.physics.connections import drifting_sets
from vibsim.plots.branch_values import (
    LabelledPoint,
    Value,
    draw_branch,
    keys_to_marks,
    mean_speed_of,
    parameter_of,
    special_labels,
)
from vibsim.plots.sheet import Scale, add_below, note
from vibsim.plots.style import BLACK
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import along, is_speed
from vibsim.plots.sweep_curves import Curve
from vibsim.plots.view import PlotError, Span
from vibsim.sweeps.quantities import quantities_of
from vibsim.sweeps.statistics import displacements, velocities

MARKED = ("fold", "doubling", "neimark-sacker", "branch point", "corner", "hopf", "grazing", "sticking")
OVER_SPEEDS = ("fold", "doubling", "neimark-sacker")  # in the small panels of a Sommerfeld diagram
ROOM = 0.04  # of the range, beyond a branch
LABELLED = 4  # branches whose special points are labelled; of more the labels would say too little
SIZE = 0.7  # of lines and marks: what was swept shall show beside them
BEYOND = 0.4  # of a period, by which a run goes on behind an orbit: its last return lies within it
PATH = ("initial.", "run.", "name", "title")  # keys that change no orbit
TURN = 2 * np.pi


class OrbitCourse(NamedTuple):
    """One orbit of n periods: extremes of every motion in each (motions, n) [m], and states at their ends."""

    least: np.ndarray
    greatest: np.ndarray
    ends: dict[str, np.ndarray]


class OrbitValues:
    """What a sweep would tell of the orbits of a branch, by the names of its columns.

    motions : the measured motions of the sweep; sections : column -> (motion, whether its velocity)
    """

    def __init__(self, branch: Any, quantities: Any) -> None:
        self.periods: int = branch.plan.n
        self._of = quantities
        self._family = branch.plan.family()
        self._scene_at_start = branch.map.scene
        self._course = cache(self._run)

    def amplitude(self, name: str) -> Value:
        """Half the peak-to-peak of a motion in one period, the mean of those of an orbit [m]."""
        i = [motion.name for motion in self._of.motions].index(name)

        def value(orbit: Any) -> float:
            course = self._course(orbit)
            return float(np.mean(course.greatest[i] - course.least[i]) / 2)

        return value

    def section(self, column: str, number: int) -> Value:
        """A column of stroboscopic points at the end of period `number` of an orbit [m, m/s or Hz]."""
        if column == "section_speed":
            return lambda orbit: float(self._course(orbit).ends["phidot"][number] / TURN)
        motion, is_rate = self._of.sections[column]
        read: Callable[..., np.ndarray] = velocities if is_rate else displacements
        return lambda orbit: float(read(self._scene(orbit), (motion,), self._course(orbit).ends)[0, number])

    def is_told(self, column: str) -> bool:
        """Whether orbits tell a column: the place of what drifts depends on when a run began."""
        if column == "section_speed":
            return bool(self._of.has_motor)
        motion, is_rate = self._of.sections[column]
        drifting = {body for one in drifting_sets(self._scene_at_start) for body in one.bodies}
        return is_rate or motion.Q >= 0 or motion.P not in drifting

    def _scene(self, orbit: Any) -> Any:
        return self._family.map(orbit.parameter).scene

    def _run(self, orbit: Any) -> OrbitCourse:
        at = self._family.map(orbit.parameter)
        length = orbit.period * (1 + BEYOND / self.periods)
        scene = placed(at.scene, at.coordinates.state(np.array(orbit.state)), length)
        ends = [(motion.P, motion.Q) for motion in self._of.motions]
        trajectory = open_trajectory(scene.without_samples(), section=True, extremes=(ends, 0.0))
        blocks = list(trajectory.blocks())
        points = {name: np.concatenate([b.section[name] for b in blocks]) for name in blocks[0].section}
        rows = np.concatenate([block.extremes for block in blocks], axis=1)
        behind = np.flatnonzero(points["time"] > BEYOND * orbit.period / self.periods)[: self.periods]
        low, high = np.split(rows[:, behind], 2)
        return OrbitCourse(low, high, {name: column[behind] for name, column in points.items()})


# Which branches go over which curves.


def check_branches(sweeps: Sequence[Subject], branches: Sequence[Subject]) -> None:
    """Raise PlotError for a branch over something else than what the sweeps are drawn along."""
    for branch in branches:
        for sweep in sweeps:
            axis = sweep.result.axes[along(sweep.result)]
            if axis is sweep.result.members:
                raise PlotError(f"{sweep.path} is an ensemble, over which no branch can be laid")
            if branch.result.key not in axis.keys:
                raise PlotError(
                    f"{branch.path}: a branch over {branch.result.key} does not lie over a sweep along "
                    f"{axis.key}"
                )


def belongs(branch: Subject, curve: Curve) -> bool:
    """Whether the case of a branch has the values that set a curve apart from others of its sweep."""
    for axis, position in curve.apart:
        swept = branch.case.with_values({axis.key: axis.text(position)})
        if swept.quantity(axis.key).value != branch.case.quantity(axis.key).value:
            return False
    return True


def other_values(branch: Subject, sweep: Subject) -> list[str]:
    """Keys under which the case of a branch has other values than that of a sweep, though neither is over
    them: such a branch is that of another machine.
    """
    own, theirs = branch.case.values, sweep.case.values
    over = {key for axis in sweep.result.axes for key in getattr(axis, "keys", (axis.key,))}
    over |= set(branch.result.plan.keys)
    return [
        key
        for key in dict.fromkeys([*theirs, *own])
        if key not in over and not key.startswith(PATH) and str(own.get(key)) != str(theirs.get(key))
    ]


# Branches as lines over the curves of a panel, with the labels of their special points.


def lay_branches(
    axes: Axes,
    drawn: Sequence[Curve],
    branches: Sequence[Subject],
    values: Callable[[Subject], Sequence[Value]],
    marked: Sequence[str] = MARKED,
) -> list[LabelledPoint]:
    """Draw the branches that belong to the curves of a panel; the labels of their special points, to be
    written by `label_points` when all else is drawn, with the number of the branch where there are several.

    values : what is drawn of a branch upwards: a value for every line, such as one for each period
    """
    limits, labels = (axes.get_xlim(), axes.get_ylim()), list[LabelledPoint]()
    before = len(axes.get_lines())
    for number, branch in enumerate(branches, 1):
        if not any(belongs(branch, curve) for curve in drawn):
            continue
        result, x = branch.result, _across(branch, drawn[0].subject)
        for line, y in enumerate(values(branch)):
            draw_branch(axes, result, x, y, BLACK, "", marked, SIZE)
            if line == 0 and len(branches) <= LABELLED:
                own = special_labels(result, x, y, marked)
                several = len(branches) > 1
                labels += [replace(one, text=f"{number}:{one.text}") if several else one for one in own]
    axes.set_xlim(*limits[0])
    axes.set_ylim(*_with_room(limits, [line.get_data() for line in axes.get_lines()[before:]]))
    return labels


def _with_room(limits: tuple[Span, Span], lines: Sequence[Any]) -> Span:
    """Limits upwards with room for what lines have within the limits across."""
    (left, right), (low, high) = limits
    parts = [np.asarray(y)[(np.asarray(x) >= left) & (np.asarray(x) <= right)] for x, y in lines]
    inside = np.concatenate([*parts, [low, high]])
    least, greatest = float(np.nanmin(inside)), float(np.nanmax(inside))
    margin = ROOM * (greatest - least)
    return low if least == low else least - margin, high if greatest == high else greatest + margin


def _across(branch: Subject, sweep: Subject) -> Value:
    """The parameter in the unit of the axis of a sweep; a speed in Hz."""
    value = parameter_of(branch.result)
    axis = sweep.result.axes[along(sweep.result)]
    if is_speed(axis.key) or branch.result.key == ENERGY or axis.unit == branch.result.unit:
        return value
    factor = float(UNITS[branch.result.unit].factor / UNITS[axis.unit].factor)
    return lambda orbit: factor * value(orbit)


def speeds(branch: Subject) -> list[Value]:
    """The mean speed of the motor [Hz], for `lay_branches`."""
    return [mean_speed_of(branch.result)]


def amplitudes(name: str, scale: Scale) -> Callable[[Subject], list[Value]]:
    """Amplitudes of a motion in the unit of a scale, for `lay_branches`."""

    def values(branch: Subject) -> list[Value]:
        value = values_of(branch).amplitude(name)
        return [lambda orbit: float(scale(value(orbit)))]

    return values


def sections(column: str, scale: Scale) -> Callable[[Subject], list[Value]]:
    """Stroboscopic points, one for each period of an orbit, in the unit of a scale, for `lay_branches`."""

    def values(branch: Subject) -> list[Value]:
        read = values_of(branch)
        if not read.is_told(column):
            return []
        each = [read.section(column, number) for number in range(read.periods)]
        return [lambda orbit, value=value: float(scale(value(orbit))) for value in each]  # type: ignore[misc]

    return values


def values_of(branch: Subject) -> OrbitValues:
    """What the orbits of a branch tell, made once for each branch."""
    kept: dict[str, Any] = branch.__dict__  # of a frozen class: where its cached properties are, too
    if "orbit_values" not in kept:
        kept["orbit_values"] = OrbitValues(branch.result, quantities_of(branch.case))
    values: OrbitValues = kept["orbit_values"]
    return values


def name_branches(
    figure: Figure, panel: Axes, sweeps: Sequence[Subject], branches: Sequence[Subject],
    marked: Sequence[str] = MARKED,
) -> None:  # fmt: skip
    """What lines and marks of the branches mean, in the legend under the picture; above a panel, where
    branches are those of another machine, in what it differs.
    """
    if not branches:
        return
    keys = keys_to_marks([branch.result for branch in branches], marked)
    if 1 < len(branches) <= LABELLED:
        named = [f"{number}: {branch.name}" for number, branch in enumerate(branches, 1)]
        keys += [Line2D([], [], linestyle="none", label=name) for name in named]
    add_below(figure, keys)
    others = [key for branch in branches for sweep in sweeps for key in other_values(branch, sweep)]
    if others:
        words = f"branches with other {', '.join(dict.fromkeys(others))}"
        note(panel, "; ".join(filter(None, [panel.get_title(loc="right"), words])))

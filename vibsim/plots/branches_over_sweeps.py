"""Branches and loci of periodic orbits over the pictures of a sweep, and pictures of loci by themselves.

A sweep tells of each run the mean of half the peak-to-peak over the periods of the source, and the states at
their ends. The same is read off an orbit of n periods by running it through once. Loci are bifurcations of
periodic orbits in the plane of two parameters.
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
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.node import ENERGY
from vibsim.orbits.branches.tracing import OrbitRecord, curve_of, drawn, stretches
from vibsim.orbits.coordinates import placed
from vibsim.physics.connections import drifting_sets
from vibsim.plots.branch_curves import (
    LabelledPoint,
    ParameterAxis,
    Value,
    draw_branch,
    keys_to_marks,
    mean_speed_of,
    parameter_factor,
    parameter_label,
    parameter_of,
    special_labels,
)
from vibsim.plots.sheet import Scale, add_below, legend_above, letter_panels, note, sheet
from vibsim.plots.style import BLACK, BLUE, GREEN, GREY, PINK, VERMILLION
from vibsim.plots.subject import PlotError, Span, Subject, View
from vibsim.plots.sweep_axes import along, is_speed, label_of, plane_of, words_of
from vibsim.plots.sweep_curves import Curve
from vibsim.sweeps.quantities import quantities_of
from vibsim.sweeps.statistics import displacements, velocities

MARKED = ("fold", "doubling", "neimark-sacker", "branch point", "corner", "hopf", "grazing", "sticking")
OVER_SPEEDS = ("fold", "doubling", "neimark-sacker")  # in the small panels of a Sommerfeld diagram
ROOM = 0.04  # of the range, beyond a branch
LABELS = 8  # of one branch over a sweep; of more, points at which sticking begins or ends have marks alone
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
    """Values of the orbits of a branch as a sweep would have them, by the names of its columns.

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

    def speed(self, rotor: str) -> Value:
        """Mean speed of a rotor [Hz]: its whole turns over an orbit, by their time."""
        angle, _ = self._of.rotors[rotor]

        def value(orbit: Any) -> float:
            began = self._family.map(orbit.parameter).coordinates.state(np.array(orbit.state))[angle]
            turns = round(float(self._course(orbit).ends[angle][-1] - began) / TURN)
            return turns / float(orbit.period)

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
        if not len(behind):  # without a source the orbit itself is what a sweep measures
            least, greatest, _ = trajectory.extremes
            rows, behind = np.array([*least, *greatest])[:, None], np.array([0])
            points = {name: np.full(1, np.nan) for name in points}
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
                own = own if len(own) <= LABELS else [one for one in own if not _of_stick(one)]
                several = len(branches) > 1
                labels += [replace(one, text=f"{number}:{one.text}") if several else one for one in own]
    axes.set_xlim(*limits[0])
    axes.set_ylim(*_with_room(limits, [line.get_data() for line in axes.get_lines()[before:]]))
    return labels


def _of_stick(point: LabelledPoint) -> bool:
    """Whether a label is that of a beginning or end of sticking."""
    return point.text.startswith("ST")


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


def speeds(rotor: str) -> Callable[[Subject], list[Value]]:
    """The mean speed [Hz] of a rotor, or of the motor where that is empty, for `lay_branches`."""

    def values(branch: Subject) -> list[Value]:
        return [values_of(branch).speed(rotor) if rotor else mean_speed_of(branch.result)]

    return values


def amplitudes(column: str, scale: Scale) -> Callable[[Subject], list[Value]]:
    """Amplitudes of the motion of a column in the unit of a scale, for `lay_branches`."""

    def values(branch: Subject) -> list[Value]:
        value = values_of(branch).amplitude(column.removeprefix("amplitude_"))
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
    """The `OrbitValues` of a branch, computed once for each branch."""
    kept: dict[str, Any] = branch.__dict__  # of a frozen class: where its cached properties are, too
    if "orbit_values" not in kept:
        kept["orbit_values"] = OrbitValues(branch.result, quantities_of(branch.case))
    values: OrbitValues = kept["orbit_values"]
    return values


def name_branches(
    figure: Figure, panel: Axes, sweeps: Sequence[Subject], branches: Sequence[Subject],
    drawn: Sequence[Curve], marked: Sequence[str] = MARKED,
) -> None:  # fmt: skip
    """Add the lines and marks of branches to the legend under the picture. Where branches belong to another
    machine, a note above the panel names the keys that differ; or says that they lie over no curve.
    """
    if not branches:
        return
    laid = [branch for branch in branches if any(belongs(branch, curve) for curve in drawn)]
    if not laid:
        _add_note(panel, "no branch has the values of a curve")
        return
    keys = keys_to_marks([branch.result for branch in laid], marked)
    if 1 < len(branches) <= LABELLED:
        named = [f"{number}: {branch.name}" for number, branch in enumerate(branches, 1)]
        keys += [Line2D([], [], linestyle="none", label=name) for name in named]
    add_below(figure, keys)
    others = [key for branch in branches for sweep in sweeps for key in other_values(branch, sweep)]
    if others:
        names = [words_of(key) or key for key in dict.fromkeys(others)]
        words = f"branches with another value of: {', '.join(names)}"
        _add_note(panel, words)


def _add_note(panel: Axes, words: str) -> None:
    """More words behind the remark above a panel."""
    note(panel, "; ".join(filter(None, [panel.get_title(loc="right").replace("\n", "; "), words])))


# Loci: bifurcations of periodic orbits in the plane of two parameters.


LOCUS_HEIGHT_CM = 7.0
COALESCENCE = "real axis"  # of the reason why Neimark-Sacker points end
LOOKS: dict[
    str, dict[str, Any]
] = {  # folds solid and below: Neimark-Sacker points may lie a hair beside them
    "fold": {"linestyle": "-", "color": BLACK, "zorder": 4},
    "doubling": {"linestyle": (0, (1, 1.2)), "color": BLUE, "zorder": 4.1},
    "neimark-sacker": {"linestyle": (0, (4, 3)), "color": VERMILLION, "zorder": 4.2},
    "grazing": {"linestyle": (0, (4, 1.2, 1, 1.2)), "color": GREEN, "zorder": 4.3},
    "sticking": {"linestyle": (0, (7, 1.5, 1, 1.5, 1, 1.5)), "color": PINK, "zorder": 4.4},
}
NAMES = {
    "fold": "folds",
    "doubling": "period doublings",
    "neimark-sacker": "Neimark–Sacker points",
    "grazing": "grazings",
    "sticking": "stick phases that come or go",
}
END: dict[str, Any] = {"marker": "o", "color": VERMILLION, "markersize": 3, "linestyle": "none"}


def locus_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """A line per locus, its kind shown by dashes and colour; a mark where Neimark-Sacker points end."""
    figure = sheet(view, LOCUS_HEIGHT_CM)
    axes = figure.subplots()
    for subject in subjects:
        draw_locus(axes, subject.result)
    across, up = axes_of(subjects[0].result)
    for subject in subjects[1:]:
        if tuple(axis.key for axis in axes_of(subject.result)) != (across.key, up.key):
            raise PlotError(f"loci over different things do not go into one picture: {subject.path}")
    axes.margins(x=0.02)
    if view.window is not None:
        axes.set_xlim(*view.window)
    axes.set_xlabel(label_of(across))
    axes.set_ylabel(label_of(up))
    add_below(figure, keys_to([subject.result for subject in subjects]))
    return figure


def axes_of(locus: Any) -> tuple[ParameterAxis, ParameterAxis]:
    """The two parameters of a locus as axes."""
    plan = locus.plan
    return ParameterAxis(plan.branch.keys[0], plan.branch.unit), ParameterAxis(plan.keys[0], plan.unit)


def draw_locus(axes: Axes, locus: Any, width: float = 1.0) -> None:
    """One locus in the plane of its parameters, a speed of the source in Hz."""
    across, up = axes_of(locus)
    factors = parameter_factor(across.key, across.unit), parameter_factor(up.key, up.unit)
    x, y = (curve_of(locus) * factors).T
    axes.plot(x, y, linewidth=width, gid=locus.kind, **LOOKS[locus.kind])
    for i in _coalescences(locus):
        axes.plot(x[i], y[i], zorder=5, gid="coalescence", **END)


def _coalescences(locus: Any) -> list[int]:
    """The ends of a locus, 0 or -1, at which the pair of multipliers meets."""
    return [i for i, end in zip((0, -1), locus.ends, strict=True) if COALESCENCE in end]


def keys_to(loci: Sequence[Any], width: float = 1.0) -> list[Line2D]:
    """Legend entries of the lines: one for each kind that is drawn."""
    kinds = [kind for kind in NAMES if any(locus.kind == kind for locus in loci)]
    keys = [Line2D([], [], linewidth=width, label=NAMES[kind], **LOOKS[kind]) for kind in kinds]
    if any(map(_coalescences, loci)):
        keys.append(Line2D([], [], label="where these end", **END))
    return keys


# Loci of bifurcations over the map of a sweep, where both are over the same two parameters.


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


# Multipliers along a branch: magnitudes over the parameter, places about the unit circle.
#
# Along a backbone curve they come as mu and 1 / mu, and stay on the circle while nothing grows: there
# mu + 1 / mu is drawn, which is real and within [-2, 2] as long.


HEIGHT_CM = 7.0


def multipliers_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """(a) magnitudes against the parameter, at the special points of the branch too; (b) the plane.

    Raises PlotError for a backbone curve whose multipliers are all 1.
    """
    branch = subjects[0].result
    if branch.key == ENERGY and not len(traces_at(branch.plan.family(), branch.points[0].orbit)):
        raise PlotError(
            f"{subjects[0].path} is the backbone curve of one body: its multipliers are those of energy and "
            "momenta, 1 all along"
        )
    figure = sheet(view, HEIGHT_CM)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    (_traces if branch.key == ENERGY else _magnitudes)(left, branch)
    left.margins(x=0.02)
    left.set_xlabel(parameter_label(subjects))
    if view.window is not None:
        left.set_xlim(*view.window)
    _plane(right, branch)
    legend_above(right)
    letter_panels([left, right])
    return figure


def _magnitudes(axes: Axes, branch: Any) -> None:
    line = magnitudes_along(branch)
    for sizes in line[:, 1:].T:
        _line(axes, line[:, 0], sizes, sizes > 1, "magnitude")
    axes.axhline(1, color=GREY, linewidth=0.5, zorder=1)
    axes.set_ylabel(r"Magnitude $|\mu|$ of the multipliers")


def _traces(axes: Axes, branch: Any) -> None:
    """Real parts; marked where the multipliers of a pair, or of two that have met, are off the circle."""
    line = _along(branch, lambda family, orbit: [part for tau in traces_at(family, orbit) for part in tau])
    for real, imaginary in zip(line[:, 1::2].T, line[:, 2::2].T, strict=True):
        _line(axes, line[:, 0], real, (abs(real) > 2) | (imaginary != 0), "trace")
    for bound in (-2, 2):
        axes.axhline(bound, color=GREY, linewidth=0.5, zorder=1)
    axes.set_ylabel(r"$\mathrm{Re}(\mu + 1/\mu)$ of the pairs of multipliers")


def _line(axes: Axes, x: np.ndarray, y: np.ndarray, outside: np.ndarray, gid: str) -> None:
    axes.plot(x, y, color=BLUE, linewidth=0.8, gid=gid, zorder=2)
    axes.plot(x[outside], y[outside], ".", color=VERMILLION, markersize=2, zorder=3)


def magnitudes_along(branch: Any) -> np.ndarray:
    """The parameter and the magnitudes of the multipliers, the largest first (n, 1 + m), smooth along a
    branch: between its orbits those of the map at what the cubic through them tells.
    """
    return _along(branch, lambda family, orbit: np.abs(multipliers_at(family, orbit)).tolist())


def _along(branch: Any, tell: Callable[[Any, Any], Sequence[float]]) -> np.ndarray:
    """The parameter and values of the orbits of a family (n, 1 + m), smooth along a branch."""
    family, parameter = branch.plan.family(), parameter_of(branch)

    def value(orbit: Any) -> tuple[float, ...]:
        return parameter(orbit), *tell(family, orbit)

    places = np.array([value(point.orbit) for point in branch.points])
    width, height = np.ptp(places[:, 0]) or 1.0, np.ptp(places[:, 1:]) or 1.0
    sizes = np.array([width, *[height] * (places.shape[1] - 1)])
    parts = [drawn(each.at, (each.one, each.other), value, sizes) for each in stretches(branch)]
    return np.concatenate([places[:1], *(part[1:] for part in parts)])


def traces_at(family: Any, orbit: Any) -> list[tuple[float, float]]:
    """mu + 1 / mu of each pair of a conservative orbit, real and imaginary part, the least first."""
    point = family(family.unknowns(np.array(orbit.state), orbit.period, orbit.parameter))
    return sorted((tau.real, tau.imag) for tau in point.reciprocal.traces)


def multipliers_at(family: Any, orbit: Any) -> Any:
    """Those of an orbit of a branch, or of what lies between two; the map decides where it is not stored."""
    if isinstance(orbit, OrbitRecord):
        return orbit.multipliers
    try:
        return family(family.unknowns(np.array(orbit.state), orbit.period, orbit.parameter)).multipliers
    except ContinuationError:  # a gap in the line
        return np.full(family.map(orbit.parameter).coordinates.count, np.nan)


def _plane(axes: Axes, branch: Any) -> None:
    multipliers = branch["multipliers"].ravel()
    angle = np.linspace(0, 2 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color=GREY, linewidth=0.5, zorder=1)
    within = "inside or on it" if branch.key == ENERGY else "inside"
    kinds = ((False, BLUE, "o", 1.2, within), (True, VERMILLION, "x", 2.4, "outside"))  # told apart in grey
    for outside, colour, marker, size, label in kinds:
        shown = multipliers[(np.abs(multipliers) > 1) == outside]
        if shown.size:
            look: dict[str, Any] = {"color": colour, "markersize": size, "markeredgewidth": 0.5}
            axes.plot(shown.real, shown.imag, marker, **look, label=label, zorder=2)
    reach = min(max(1.15, float(np.abs(multipliers).max(initial=0)) * 1.05), 3.0)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_xlabel(r"Re $\mu$")
    axes.set_ylabel(r"Im $\mu$")

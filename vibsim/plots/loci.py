"""Loci: bifurcations of periodic orbits in the plane of two parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.node import ENERGY
from vibsim.orbits.branches.tracing import OrbitRecord, curve_of, drawn, stretches
from vibsim.plots.branch_values import ParameterAxis, parameter_factor, parameter_label, parameter_of
from vibsim.plots.sheet import add_below, legend_above, letter_panels, sheet
from vibsim.plots.style import BLACK, BLUE, GREEN, GREY, PINK, VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import label_of, plane_of
from vibsim.plots.view import PlotError, View

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
    "sticking": "sticks that come or go",
}
END: dict[str, Any] = {"marker": "o", "color": VERMILLION, "markersize": 3, "linestyle": "none"}


def locus_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """A line per locus, its kind told by dashes and colour; a mark where Neimark-Sacker points end."""
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
    """What the lines mean, for a legend: each kind that is there."""
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
    """The parameter and what is told of the orbits of a family (n, 1 + m), smooth along a branch."""
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
    """Those of an orbit of a branch, or of what lies between two; the map decides where it is not told."""
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
    for outside, colour, label in ((False, BLUE, within), (True, VERMILLION, "outside")):
        shown = multipliers[(np.abs(multipliers) > 1) == outside]
        if shown.size:
            axes.plot(shown.real, shown.imag, ".", color=colour, markersize=2, label=label, zorder=2)
    reach = min(max(1.15, float(np.abs(multipliers).max(initial=0)) * 1.05), 3.0)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_xlabel(r"Re $\mu$")
    axes.set_ylabel(r"Im $\mu$")

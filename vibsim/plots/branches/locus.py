"""Loci: bifurcations of periodic orbits in the plane of two parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibsim.branches.course import curve_of
from vibsim.plots.branches.values import ParameterAxis, parameter_factor
from vibsim.plots.errors import PlotError
from vibsim.plots.page.sheet import add_below, sheet
from vibsim.plots.style import BLACK, BLUE, GREEN, PINK, VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import label_of
from vibsim.plots.view import View

HEIGHT_CM = 7.0
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


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """A line per locus, its kind told by dashes and colour; a mark where Neimark-Sacker points end."""
    figure = sheet(view, HEIGHT_CM)
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

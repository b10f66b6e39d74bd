"""Loci: bifurcations of periodic orbits in the plane of two parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.branch_values import ParameterAxis, parameter_factor
from vibsim.plots.errors import PlotError
from vibsim.plots.sheet import legend_below, sheet
from vibsim.plots.style import BLACK
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import label_of
from vibsim.plots.view import View

HEIGHT_CM = 7.0
STYLES: dict[str, Any] = {"fold": "-", "doubling": (0, (1, 1.2)), "neimark-sacker": (0, (4, 1.5))}
NAMES = {"fold": "folds", "doubling": "period doublings", "neimark-sacker": "Neimark–Sacker points"}
COALESCENCE = "real axis"  # of the reason why Neimark-Sacker points end


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """A line per locus, its kind told by its dashes; a mark where Neimark-Sacker points end."""
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
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    legend_below(figure, [*named.values()], [*named])
    return figure


def axes_of(locus: Any) -> tuple[ParameterAxis, ParameterAxis]:
    """The two parameters of a locus as axes."""
    plan = locus.plan
    return ParameterAxis(plan.branch.keys[0], plan.branch.unit), ParameterAxis(plan.keys[0], plan.unit)


def draw_locus(axes: Axes, locus: Any, colour: Any = BLACK, width: float = 1.0) -> None:
    """One locus in the plane of its parameters, a speed of the source in Hz."""
    across, up = axes_of(locus)
    x = locus["parameter"] * parameter_factor(across.key, across.unit)
    y = locus["second"] * parameter_factor(up.key, up.unit)
    style = STYLES[locus.kind]
    axes.plot(
        x,
        y,
        color=colour,
        linestyle=style,
        linewidth=width,
        label=NAMES[locus.kind],
        gid=locus.kind,
        zorder=4,
    )
    for i, end in ((0, locus.ends[0]), (-1, locus.ends[1])):
        if COALESCENCE in end:
            axes.plot(
                x[i], y[i], "o", color=colour, markersize=3, label="they meet", zorder=5, gid="coalescence"
            )

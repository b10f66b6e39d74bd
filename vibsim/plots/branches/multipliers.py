"""Multipliers along a branch: magnitudes over the parameter, places about the unit circle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.branches.arclength import ContinuationError
from vibsim.branches.course import drawn, stretches
from vibsim.branches.records import OrbitRecord
from vibsim.plots.branches.values import parameter_label, parameter_of
from vibsim.plots.page.sheet import legend_above, letter_panels, sheet
from vibsim.plots.style import BLUE, GREY, VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

HEIGHT_CM = 7.0


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """(a) magnitudes against the parameter, at the special points of the branch too; (b) the plane."""
    figure = sheet(view, HEIGHT_CM)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    _magnitudes(left, subjects[0])
    left.set_xlabel(parameter_label(subjects))
    if view.window is not None:
        left.set_xlim(*view.window)
    _plane(right, subjects[0])
    legend_above(right)
    letter_panels([left, right])
    return figure


def _magnitudes(axes: Axes, subject: Subject) -> None:
    line = magnitudes_along(subject.result)
    x, sizes = line[:, 0], line[:, 1:]
    for k in range(sizes.shape[1]):
        outside = sizes[:, k] > 1
        axes.plot(x, sizes[:, k], color=BLUE, linewidth=0.8, gid="magnitude", zorder=2)
        axes.plot(x[outside], sizes[outside, k], ".", color=VERMILLION, markersize=2, zorder=3)
    axes.axhline(1, color=GREY, linewidth=0.5, zorder=1)
    axes.set_ylabel(r"Magnitude $|\mu|$ of the multipliers")
    axes.margins(x=0.02)


def magnitudes_along(branch: Any) -> np.ndarray:
    """The parameter and the magnitudes of the multipliers, the largest first (n, 1 + m), smooth along a
    branch: between its orbits those of the map at what the cubic through them tells.
    """
    family, parameter = branch.plan.family(), parameter_of(branch)

    def value(orbit: Any) -> tuple[float, ...]:
        return parameter(orbit), *np.abs(multipliers_at(family, orbit)).tolist()

    places = np.array([value(point.orbit) for point in branch.points])
    width, height = np.ptp(places[:, 0]) or 1.0, np.ptp(places[:, 1:]) or 1.0
    sizes = np.array([width, *[height] * (places.shape[1] - 1)])
    parts = [drawn(each.at, (each.one, each.other), value, sizes) for each in stretches(branch)]
    return np.concatenate([places[:1], *(part[1:] for part in parts)])


def multipliers_at(family: Any, orbit: Any) -> Any:
    """Those of an orbit of a branch, or of what lies between two; the map decides where it is not told."""
    if isinstance(orbit, OrbitRecord):
        return orbit.multipliers
    try:
        return family(family.unknowns(np.array(orbit.state), orbit.period, orbit.parameter)).multipliers
    except ContinuationError:  # a gap in the line
        return np.full(family.map(orbit.parameter).coordinates.count, np.nan)


def _plane(axes: Axes, subject: Subject) -> None:
    multipliers = subject.result["multipliers"].ravel()
    angle = np.linspace(0, 2 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color=GREY, linewidth=0.5, zorder=1)
    for outside, colour, label in ((False, BLUE, "inside"), (True, VERMILLION, "outside")):
        shown = multipliers[(np.abs(multipliers) > 1) == outside]
        if shown.size:
            axes.plot(shown.real, shown.imag, ".", color=colour, markersize=2, label=label, zorder=2)
    reach = min(max(1.15, float(np.abs(multipliers).max(initial=0)) * 1.05), 3.0)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal")
    axes.set_xlabel(r"Re $\mu$")
    axes.set_ylabel(r"Im $\mu$")

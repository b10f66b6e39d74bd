"""Multipliers along a branch: magnitudes over the parameter, places about the unit circle.

Along a backbone curve they come as mu and 1 / mu, and stay on the circle while nothing grows: there
mu + 1 / mu is drawn, which is real and within [-2, 2] as long.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.branches.course import drawn, stretches
from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.energy import ENERGY
from vibsim.branches.tracing.records import OrbitRecord
from vibsim.plots.branches.values import parameter_label, parameter_of
from vibsim.plots.errors import PlotError
from vibsim.plots.page.sheet import legend_above, letter_panels, sheet
from vibsim.plots.style import BLUE, GREY, VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

HEIGHT_CM = 7.0


def draw(subjects: Sequence[Subject], view: View) -> Figure:
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

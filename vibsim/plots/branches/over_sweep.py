"""Branches of periodic orbits over the curves of a sweep."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.branches.curves import draw_branch, keys_to_marks
from vibsim.plots.branches.values import mean_speed_of, parameter_of
from vibsim.plots.page.sheet import add_below
from vibsim.plots.style import BLACK
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.curves import Curve

MARKED = ("fold", "doubling", "neimark-sacker")
SIZE = 0.7  # of lines and marks: what was swept shall show beside them


def lay_branches(axes: Axes, drawn: Sequence[Curve], branches: Sequence[Subject]) -> None:
    """Draw the branches whose cases have the values of what else was swept of the curves of a panel."""
    limits = axes.get_xlim(), axes.get_ylim()
    for branch in branches:
        if any(belongs(branch, curve) for curve in drawn):
            result = branch.result
            draw_branch(axes, result, parameter_of(result), mean_speed_of(result), BLACK, "", MARKED, SIZE)
    axes.set_xlim(*limits[0])
    axes.set_ylim(*limits[1])


def name_branches(figure: Figure, branches: Sequence[Subject]) -> None:
    """What lines and marks of the branches mean, in the legend under the picture."""
    if branches:
        add_below(figure, keys_to_marks([branch.result for branch in branches], MARKED))


def belongs(branch: Subject, curve: Curve) -> bool:
    """Whether the case of a branch has the values that set a curve apart from others of its sweep."""
    for axis, position in curve.apart:
        swept = branch.case.with_values({axis.key: axis.text(position)})
        if swept.quantity(axis.key).value != branch.case.quantity(axis.key).value:
            return False
    return True

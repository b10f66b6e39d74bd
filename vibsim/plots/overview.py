"""One page about a run, or a few: displacements, a detail, the relative portrait, the speed."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from vibsim.plots.displacement import DISPLACEMENT
from vibsim.plots.motor_speed import motor_speed_panel
from vibsim.plots.relative import relative_panel
from vibsim.plots.samples import common_window
from vibsim.plots.sheet import legend_above, sheet
from vibsim.plots.spans import detail_span
from vibsim.plots.style import SHADE
from vibsim.plots.subject import Subject
from vibsim.plots.time_history import Quantity, curve_groups, history_panel
from vibsim.plots.velocity import VELOCITY
from vibsim.plots.view import Span, View

HEIGHT_CM = 15.5
SPEED_CM = 4.6  # of the panel with the motor speed


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """A page of four panels that suit what the scenes have."""
    figure = sheet(view, HEIGHT_CM)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.25, 1))
    window = common_window(subjects, view.window)
    detail = detail_span(subjects, view)
    first = _displacements(figure, grid, subjects, window)
    if len(subjects) == 1:
        first.axvspan(*detail, color=SHADE, linewidth=0, zorder=0)
    relative_panel(figure.add_subplot(grid[1:, 1]), subjects, view)
    alone = len(subjects) == 1
    _history(figure.add_subplot(grid[1, 0]), subjects, detail, DISPLACEMENT if alone else VELOCITY)
    last = figure.add_subplot(grid[2, 0])
    if all(subject.scene.has_motor for subject in subjects):
        motor_speed_panel(last, subjects, view, SPEED_CM)
    else:
        _history(last, subjects, detail if alone else window, VELOCITY)
    if alone:
        last.set_title("", loc="right")
        legend_above(last)
    legend_above(first)
    figure.suptitle(_heading(subjects), x=0.01, ha="left", fontsize=8)
    return figure


def _displacements(figure: Figure, grid: GridSpec, subjects: Sequence[Subject], window: Span) -> Axes:
    """One panel across the page, or one per block where several runs are compared; the first of them."""
    groups = curve_groups(subjects, DISPLACEMENT)
    cells = [grid[0, :]] if len(groups) == 1 else [grid[0, 0], grid[0, 1]]
    panels = [figure.add_subplot(cell) for cell in cells]
    for axes, group in zip(panels, groups, strict=True):
        history_panel(axes, group, window, DISPLACEMENT)
    return panels[0]


def _history(axes: Axes, subjects: Sequence[Subject], span: Span, quantity: Quantity) -> None:
    """Both blocks of one run, or block 1 of several."""
    history_panel(axes, curve_groups(subjects, quantity)[0], span, quantity)


def _heading(subjects: Sequence[Subject]) -> str:
    if len(subjects) > 1:
        return ", ".join(subject.name for subject in subjects)
    title = subjects[0].case.title
    return f"{subjects[0].name}: {title}" if title else subjects[0].name

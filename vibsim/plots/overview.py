"""One page about a run, or a few: displacements, a detail, the relative portrait, the speed."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

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

PANEL_CM = 5.2


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Panels that suit what the scenes have: a page of them, or a column."""
    groups = curve_groups(subjects, DISPLACEMENT)
    wide = view.width == "page"
    figure = sheet(view, PANEL_CM * (3 if wide else 3 + len(groups)))
    *tops, middle, portrait, bottom = _page(figure, len(groups)) if wide else _column(figure, len(groups))
    window, detail = common_window(subjects, view.window), detail_span(subjects, view)
    for axes, group in zip(tops, groups, strict=True):
        history_panel(axes, group, window, DISPLACEMENT)
    alone = len(subjects) == 1
    if alone:
        tops[0].axvspan(*detail, color=SHADE, linewidth=0, zorder=0)
    _history(middle, subjects, detail, DISPLACEMENT if alone else VELOCITY)
    relative_panel(portrait, subjects, view)
    if all(subject.scene.has_motor for subject in subjects):
        motor_speed_panel(bottom, subjects, view, PANEL_CM)
    else:
        _history(bottom, subjects, detail if alone else window, VELOCITY)
    if alone:
        bottom.set_title("", loc="right")
        legend_above(bottom)
    legend_above(tops[0])
    figure.align_ylabels()
    figure.suptitle(_heading(subjects), x=0.01, ha="left", fontsize=8)
    return figure


def _page(figure: Figure, groups: int) -> list[Axes]:
    """Axes of the displacements (one, or one per block), the detail, the relative portrait and the speed."""
    grid = figure.add_gridspec(3, 2, width_ratios=(1.25, 1))
    tops = [grid[0, :]] if groups == 1 else [grid[0, 0], grid[0, 1]]
    return [figure.add_subplot(cell) for cell in (*tops, grid[1, 0], grid[1:, 1], grid[2, 0])]


def _column(figure: Figure, groups: int) -> list[Axes]:
    """The same axes, one below the other."""
    return list(figure.subplots(groups + 3, 1))


def _history(axes: Axes, subjects: Sequence[Subject], span: Span, quantity: Quantity) -> None:
    """Both blocks of one run, or block 1 of several."""
    history_panel(axes, curve_groups(subjects, quantity)[0], span, quantity)


def _heading(subjects: Sequence[Subject]) -> str:
    if len(subjects) > 1:
        return ", ".join(subject.name for subject in subjects)
    title = subjects[0].title
    return f"{subjects[0].name}: {title}" if title else subjects[0].name

"""One page about a run, or a few: displacements, a detail, the relative portrait, the speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.displacement import DISPLACEMENT
from vibsim.plots.motor_speed import motor_speed_panel
from vibsim.plots.relative import relative_panel
from vibsim.plots.samples import common_window
from vibsim.plots.sheet import legend_above, letter_panels, sheet
from vibsim.plots.spans import detail_span
from vibsim.plots.subject import Subject
from vibsim.plots.time_history import Curve, Panel, curve_groups, histories, is_short
from vibsim.plots.time_marks import mark_detail
from vibsim.plots.velocity import VELOCITY
from vibsim.plots.view import View

PANEL_CM = 5.2


@dataclass(frozen=True)
class Page:
    """The axes of the page, in the order in which they are read.

    tops : the displacements, of both blocks or of one each
    middle : the detail; None where single periods are seen above
    """

    tops: list[Axes]
    middle: Axes | None
    portrait: Axes
    bottom: Axes

    @property
    def panels(self) -> list[Axes]:
        """All of them."""
        if self.middle is None:
            return [*self.tops, self.bottom, self.portrait]
        return [*self.tops, self.middle, self.portrait, self.bottom]


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Panels that suit what the scenes have: a page of them, or a column."""
    groups = curve_groups(subjects, DISPLACEMENT)
    alone, wide = len(subjects) == 1, view.width == "page"
    window = common_window(subjects, view.window)
    whole = alone and view.detail is None and is_short(subjects[0], window)
    detail = window if whole else detail_span(subjects, view)
    count = len(groups) + (2 if whole else 3)
    figure = sheet(view, PANEL_CM * (3 if wide else count))
    page = _page(figure, len(groups), whole) if wide else _column(figure, len(groups), whole)
    shown = [Panel(axes, group, window) for axes, group in zip(page.tops, groups, strict=True)]
    speed = all(subject.scene.has_motor for subject in subjects)
    velocities = [] if speed else [Panel(page.bottom, _first(subjects), detail if alone else window)]
    if page.middle is not None and alone:
        shown.append(Panel(page.middle, groups[0], detail))
        mark_detail(page.tops[0], detail)
    elif page.middle is not None:
        velocities.append(Panel(page.middle, _first(subjects), detail))
    histories(shown, DISPLACEMENT)
    if velocities:
        histories(velocities, VELOCITY)
    relative_panel(page.portrait, subjects, view)
    if speed:
        motor_speed_panel(page.bottom, subjects, view, PANEL_CM)
    _finish(figure, page, subjects)
    return figure


def _first(subjects: Sequence[Subject]) -> list[Curve]:
    """Velocities of both blocks of one run, or of block 1 of several."""
    return curve_groups(subjects, VELOCITY)[0]


def _finish(figure: Figure, page: Page, subjects: Sequence[Subject]) -> None:
    if len(subjects) == 1:
        page.bottom.set_title("", loc="right")
        legend_above(page.bottom)
    legend_above(page.tops[0])
    letter_panels(page.panels)
    figure.align_ylabels()
    figure.suptitle(_heading(subjects), x=0.01, ha="left", fontsize=8)


def _page(figure: Figure, groups: int, whole: bool) -> Page:
    """Displacements above (one panel, or one per block); below them the others in two columns."""
    grid = figure.add_gridspec(3, 2, width_ratios=(1.25, 1))
    tops = [grid[0, :]] if groups == 1 else [grid[0, 0], grid[0, 1]]
    left = [] if whole else [grid[1, 0]]
    cells = [*tops, *left, grid[1:, 1], grid[1 if whole else 2 :, 0]]
    return _named([figure.add_subplot(cell) for cell in cells], groups, whole)


def _column(figure: Figure, groups: int, whole: bool) -> Page:
    """The same axes, one below the other."""
    return _named(list(figure.subplots(groups + (2 if whole else 3), 1)), groups, whole)


def _named(axes: list[Axes], groups: int, whole: bool) -> Page:
    *rest, portrait, bottom = axes
    return Page(rest[:groups], None if whole else rest[groups], portrait, bottom)


def _heading(subjects: Sequence[Subject]) -> str:
    if len(subjects) > 1:
        return ", ".join(subject.name for subject in subjects)
    title = subjects[0].title
    return f"{subjects[0].name}: {title}" if title else subjects[0].name

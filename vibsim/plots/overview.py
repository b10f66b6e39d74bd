"""One page about a run, or a few: the machine, displacements, a detail, the relative portrait, the speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from vibsim.physics.rates import motor_columns
from vibsim.plots.machine import machine_panel, machine_size
from vibsim.plots.samples import common_window, detail_span
from vibsim.plots.sheet import CM, LABEL_SHARE, characters, legend_above, letter_panels, sheet
from vibsim.plots.style import points
from vibsim.plots.subject import Subject
from vibsim.plots.time_histories import (
    DISPLACEMENT,
    VELOCITY,
    HistoryCurve,
    Panel,
    curve_groups,
    histories,
    is_short,
    motor_speed_panel,
    relative_panel,
    rotor_speed_panel,
    rotor_speeds,
)
from vibsim.plots.traces import mark_detail
from vibsim.plots.view import View

PANEL_CM = 5.2
BESIDE_CM = 10.5  # width of a machine up to which the portrait has room beside it
LARGEST = 1.02  # width of a machine that is drawn, relative to the sheet: its margins give way a little
HEADING_CM = 0.7
APART_CM = 0.3  # between the machine and what is below it
LABEL_CM = 1.8  # what labels of axes take of the width beside the machine


@dataclass(frozen=True)
class Page:
    """The axes of the page, in the order in which they are read.

    tops : the displacements, of all bodies or of one each
    middle : the detail; None where single periods are seen above
    machine : the drawing of the machine; None where runs are several, or it is too wide for the page
    portrait_first : whether the portrait stands above the others, beside the machine
    narrow : whether all stand one below the other
    """

    tops: list[Axes]
    middle: Axes | None
    portrait: Axes
    bottom: Axes
    machine: Axes | None = None
    portrait_first: bool = False
    narrow: bool = False

    @property
    def panels(self) -> list[Axes]:
        """All of them but the machine."""
        middle = [] if self.middle is None else [self.middle]
        if self.portrait_first:
            return [self.portrait, *self.tops, *middle, self.bottom]
        return [
            *self.tops,
            *middle,
            *([self.portrait, self.bottom] if middle or self.narrow else [self.bottom, self.portrait]),
        ]


def overview_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """The machine, and panels that suit what the scenes have: a page of them, or a column."""
    groups = curve_groups(subjects, DISPLACEMENT)
    alone = len(subjects) == 1
    window = common_window(subjects, view.window)
    whole = alone and view.detail is None and is_short(subjects[0], window)
    detail = window if whole else detail_span(subjects, view)
    page = _page(view, subjects, len(groups), whole)
    figure = page.portrait.get_figure(root=True)
    assert isinstance(figure, Figure)
    shown = [Panel(axes, group, window) for axes, group in zip(page.tops, groups, strict=True)]
    motors = all(motor_columns(subject.scene) for subject in subjects)
    speed = motors or all(rotor_speeds(subject.scene) for subject in subjects)
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
        panel = motor_speed_panel if motors else rotor_speed_panel
        panel(page.bottom, subjects, view, PANEL_CM)
    if page.machine is not None:
        machine_panel(page.machine, subjects[0].case.long_values())
    _finish(figure, page, subjects)
    return figure


def _first(subjects: Sequence[Subject]) -> list[HistoryCurve]:
    """Velocities of all bodies of one run, or of the first one of several."""
    return curve_groups(subjects, VELOCITY)[0]


def _finish(figure: Figure, page: Page, subjects: Sequence[Subject]) -> None:
    if len(subjects) == 1:
        page.bottom.set_title("", loc="right")
        legend_above(page.bottom)
    legend_above(page.tops[0])
    letter_panels(page.panels)
    figure.align_ylabels()
    room = LABEL_SHARE * characters(figure.get_figwidth())
    figure.suptitle(_heading(subjects, room), x=0.01, ha="left", fontsize=points(8))


def _machine(subjects: Sequence[Subject], view: View) -> tuple[float, float] | None:
    """Width and height of the machine's drawing [cm]; None for several runs, and on too narrow a sheet."""
    if len(subjects) > 1:
        return None
    width, height = machine_size(subjects[0].case.long_values())
    return (width, height) if width <= LARGEST * view.width_cm else None


def _page(view: View, subjects: Sequence[Subject], groups: int, whole: bool) -> Page:
    """The axes: on a page the portrait stands beside the machine where there is room, else beside detail and
    speed; in a column all are one below the other.
    """
    size, wide = _machine(subjects, view), view.width == "page"
    if size is None:
        return _panels(sheet(view, PANEL_CM * (3 if wide else _rows(groups, whole))), wide, groups, whole)
    if wide and size[0] <= BESIDE_CM:
        return _beside(view, size, groups, whole)
    height = size[1] + HEADING_CM + APART_CM + PANEL_CM * (3 if wide else _rows(groups, whole))
    figure = sheet(view, height)
    engine = figure.get_layout_engine()
    assert isinstance(engine, ConstrainedLayoutEngine)
    engine.set(rect=(0, 0, 1, 1 - (size[1] + APART_CM) / (figure.get_figheight() / CM)))
    return replace(_panels(figure, wide, groups, whole), machine=_head(figure, size))


def _rows(groups: int, whole: bool) -> int:
    """Panels of a column."""
    return groups + (2 if whole else 3)


def _head(figure: Figure, size: tuple[float, float]) -> Axes:
    """Axes of a width and height [cm] under the heading, outside the layout of the others."""
    sheet_cm = figure.get_figwidth() / CM, figure.get_figheight() / CM
    width, height = min(size[0] / sheet_cm[0], 1.0), size[1] / sheet_cm[1]
    place = (0, 1 - HEADING_CM / sheet_cm[1] - height, width, height)
    axes = figure.add_axes(place, label="<machine>")
    axes.set_in_layout(False)
    return axes


def _beside(view: View, size: tuple[float, float], groups: int, whole: bool) -> Page:
    """The portrait beside the machine; below them the others, as wide as the page."""
    heights = [max(size[1] + HEADING_CM, PANEL_CM), *[PANEL_CM] * (groups + (1 if whole else 2))]
    figure = sheet(view, sum(heights))
    ratios = (size[0] + LABEL_CM, view.width_cm - size[0] - LABEL_CM)
    grid = figure.add_gridspec(len(heights), 2, height_ratios=heights, width_ratios=ratios)
    *cells, last = [grid[row, :] for row in range(1, len(heights))]
    page = _named([figure.add_subplot(cell) for cell in (*cells, grid[0, 1], last)], groups, whole)
    return replace(page, machine=_head(figure, size), portrait_first=True)


def _panels(figure: Figure, wide: bool, groups: int, whole: bool) -> Page:
    """Displacements above (one panel, or one per body); below them the others in two columns, or one."""
    if not wide:
        page = _named(list(figure.subplots(_rows(groups, whole), 1)), groups, whole)
        return replace(page, narrow=True)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.25, 1))
    tops = [grid[0, :]] if groups == 1 else [grid[0, 0], grid[0, 1]]
    left = [] if whole else [grid[1, 0]]
    cells = [*tops, *left, grid[1:, 1], grid[1 if whole else 2 :, 0]]
    return _named([figure.add_subplot(cell) for cell in cells], groups, whole)


def _named(axes: list[Axes], groups: int, whole: bool) -> Page:
    *rest, portrait, bottom = axes
    return Page(rest[:groups], None if whole else rest[groups], portrait, bottom)


def _heading(subjects: Sequence[Subject], room: float) -> str:
    """Name and title of the case, or as much of them as goes into a line of so many characters."""
    if len(subjects) > 1:
        return ", ".join(subject.name for subject in subjects)
    name, title = subjects[0].name, subjects[0].title
    wishes = [f"{name}: {title}", title] if title else []
    return next((text for text in wishes if len(text) <= room), name)

"""How the paper lays out its figures, from the panels of `vibsim.plots`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator

from vibsim.plots.displacement import DISPLACEMENT
from vibsim.plots.displacement_frequency import displacement_frequency_panels
from vibsim.plots.motor import motor_panel
from vibsim.plots.motor_speed import SPEED, motor_speed_panel
from vibsim.plots.phase import moving, phase_panels
from vibsim.plots.samples import common_window
from vibsim.plots.sheet import legend_above, time_axis
from vibsim.plots.spans import detail_span
from vibsim.plots.stiffness import stiffness_panel
from vibsim.plots.style import overlay
from vibsim.plots.subject import Subject
from vibsim.plots.time_history import Panel, curve_groups, histories
from vibsim.plots.time_marks import mark_detail
from vibsim.plots.view import View

WHOLE = View()
NARROW = 0.55  # width of a lone characteristic, of the page
SECOND = 1.0  # [s] in which the greatest x1 - x2 is looked for: several vibrations of every motor


def draw_stiffness(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Spring force against x1 - x2."""
    stiffness_panel(_centred(sheet), subjects[:1])


def draw_motors(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Torque against speed of several motors."""
    motor_panel(_centred(sheet), subjects)


def draw_displacements(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """A row for each run: displacements of both blocks, and a detail with impacts."""
    rows = sheet.subfigures(len(subjects), 1, squeeze=False)[:, 0]
    for row, subject in zip(rows, subjects, strict=True):
        _title(row, subject)
        whole, detail = row.subplots(1, 2, gridspec_kw={"width_ratios": (1.5, 1)})
        span = detail_span([subject], WHOLE)
        curves = curve_groups([subject], DISPLACEMENT)[0]
        window = common_window([subject], None)
        histories([Panel(whole, curves, window), Panel(detail, curves, span)], DISPLACEMENT)
        mark_detail(whole, span)
        legend_above(whole)


def draw_portraits(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """A column for each run: phase portrait of block 1 above that of block 2."""
    columns = sheet.subfigures(1, len(subjects), squeeze=False)[0]
    for column, subject in zip(columns, subjects, strict=True):
        column.suptitle(subject.name, fontsize=8, fontweight="bold")
        panels: Any = column.subplots(2, 1)
        phase_panels(panels, [subject], WHOLE, moving([subject]))
        for axes in panels:
            axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))


def draw_passage(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Motor speed against time, beside the displacements against the motor's speed."""
    _title(sheet, subjects[0])
    left, right = sheet.subfigures(1, 2, width_ratios=(1.25, 1), squeeze=False)[0]
    speed = left.subplots()
    motor_speed_panel(speed, subjects, WHOLE, height_cm=7.0)
    legend_above(speed)
    panels = right.subplots(2, 1, sharex=True)
    displacement_frequency_panels(panels, subjects, WHOLE, moving(subjects))
    panels[-1].set_xlabel(f"Motor speed {SPEED} (Hz)")
    right.align_ylabels()


def draw_growth(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Greatest x1 - x2 in each second [mm] against time, of several runs."""
    axes = sheet.subplots()
    for i, subject in enumerate(subjects):
        t, reach = reach_by_second(subject.result)
        axes.plot(t, 1e3 * reach, label=subject.name, linewidth=1.0, gid="reach", **overlay(i))
    axes.set_ylim(bottom=0)
    axes.set_ylabel("Greatest $x_1 - x_2$ (mm)")
    time_axis(axes, common_window(subjects, None))
    legend_above(axes)


def reach_by_second(result: Any) -> tuple[np.ndarray, np.ndarray]:
    """Middle of each whole second of a run [s], and the greatest x1 - x2 of its samples [m]."""
    time, y = result["time"], result["x1"] - result["x2"]
    edges = np.arange(time[0], time[-1] + SECOND / 2, SECOND)
    starts = np.searchsorted(time, edges[:-1])
    return (edges[:-1] + edges[1:]) / 2, np.maximum.reduceat(y, starts)


def _centred(sheet: Figure) -> Axes:
    """Axes in the middle of the sheet."""
    side = (1 - NARROW) / 2
    axes: Any = sheet.subfigures(1, 3, width_ratios=(side, NARROW, side), squeeze=False)[0, 1].subplots()
    return axes


def _title(sheet: Figure | SubFigure, subject: Subject) -> None:
    sheet.suptitle(f"{subject.name}: {subject.title}", x=0.01, ha="left", fontsize=8)

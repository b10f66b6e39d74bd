"""How the paper lays out its figures, from the panels of `vibsim.plots`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator

from vibsim.analysis import judge_capture
from vibsim.plots.cases.motor import motor_panel
from vibsim.plots.cases.stiffness import stiffness_panel
from vibsim.plots.motion.natural_frequencies import motor_of
from vibsim.plots.motion.samples import common_window
from vibsim.plots.motion.spans import detail_span
from vibsim.plots.motion.time_marks import mark_detail
from vibsim.plots.page.sheet import legend_above, letter_panels, time_axis
from vibsim.plots.runs.displacement import DISPLACEMENT
from vibsim.plots.runs.displacement_frequency import displacement_frequency_panels
from vibsim.plots.runs.motor_speed import SPEED, motor_speed_panel
from vibsim.plots.runs.phase import moving, phase_panels
from vibsim.plots.runs.relative import relative_panel
from vibsim.plots.runs.time_history import Panel, curve_groups, histories
from vibsim.plots.style import overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

WHOLE = View()
NARROW = 0.55  # width of a lone characteristic, of the page
SECOND = 1.0  # [s] in which the greatest x1 - x2 is looked for: several vibrations of every motor


def draw_stiffness(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Spring force against x1 - x2."""
    stiffness_panel(_centred(sheet), subjects[:1])


def draw_motors(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """Torque against speed of several motors, and where each of them runs: in the end, and while held."""
    axes = _centred(sheet)
    motor_panel(axes, subjects)
    for i, subject in enumerate(subjects):
        capture, colour = judge_capture(subject.result), overlay(i)["color"]
        if capture.final_speed_hz is not None:
            place = _point(subject, capture.final_speed_hz)
            axes.plot(*place, "o", color=colour, markersize=4.5, gid="final")
        if capture.until is not None and capture.speed_hz is not None:
            axes.plot(
                *_point(subject, capture.speed_hz), "s", color=colour, markersize=4, markerfacecolor="white",
                gid="held",
            )  # fmt: skip


def _point(subject: Subject, speed_hz: float) -> tuple[float, float]:
    """Mean speed [Hz] and torque [mN m]: the torque is linear in the speed, and so are their means."""
    motor = motor_of(subject.scene)
    return speed_hz, 1e3 * motor.M0 * (1 - 2 * np.pi * speed_hz / motor.Omega0)


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
        letter_panels([whole, detail])


def draw_portraits(sheet: Figure, subjects: Sequence[Subject]) -> None:
    """A row for each run: portraits of blocks 1 and 2, and of their relative motion, free of drift."""
    rows = sheet.subfigures(len(subjects), 1, squeeze=False)[:, 0]
    for row, subject in zip(rows, subjects, strict=True):
        mark = "(b)" if subject.scene.has_motor else "(a)"
        row.suptitle(f"{mark} {subject.name}: {subject.case.title}", x=0.01, ha="left", fontsize=8)
        panels: Any = row.subplots(1, 3)
        phase_panels(panels[:2], [subject], WHOLE, moving([subject]))
        relative_panel(panels[2], [subject], WHOLE)
        panels[2].set_xlabel(panels[2].get_xlabel().removeprefix("Relative displacement "))
        panels[2].set_ylabel(panels[2].get_ylabel().removeprefix("Relative velocity "))
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
    for axes in panels:
        axes.set_ylabel(axes.get_ylabel().removeprefix("Displacement "))
    letter_panels([speed, panels[0]])
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
    axes: Axes = sheet.subfigures(1, 3, width_ratios=(side, NARROW, side), squeeze=False)[0, 1].subplots()
    return axes


def _title(sheet: Figure | SubFigure, subject: Subject) -> None:
    known = " (true motion)" if "comment" in subject.result.attrs else ""  # the caption says how it was had
    sheet.suptitle(f"{subject.name}: {subject.title}{known}", x=0.01, ha="left", fontsize=8)

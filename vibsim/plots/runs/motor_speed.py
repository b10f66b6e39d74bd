"""Speed of the motor against time, with the frequencies at which it may be captured."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motion.envelope import Envelope
from vibsim.plots.motion.natural_frequencies import motor_of, natural_frequencies
from vibsim.plots.motion.samples import POINTS_PER_COLUMN, Series, common_window, series, window_of
from vibsim.plots.motion.time_marks import annotate_runs
from vibsim.plots.motion.turns import TURNS, turn_times
from vibsim.plots.page.margin_labels import Level, draw_levels
from vibsim.plots.page.sheet import above_wider, legend_above, pixel_columns, sheet, time_axis
from vibsim.plots.style import BLUE, GREY, SKY, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View

NEAR = 0.25  # frequencies up to this part of the drawn range beyond it are drawn too
HEIGHT_CM = 5.6
SPEED = r"$\dot\varphi/2\pi$"


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """phidot / 2 pi [Hz] against time [s]; no-load speed and natural frequencies as labelled levels."""
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    motor_speed_panel(axes, subjects, view)
    legend_above(axes)
    return figure


def motor_speed_panel(
    axes: Axes, subjects: Sequence[Subject], view: View, height_cm: float = HEIGHT_CM
) -> None:
    """The speed in given axes, instantaneous as a pale band and averaged over turns as a line.

    height_cm : height of the figure that the axes would fill [cm]
    """
    window = common_window(subjects, view.window)
    low, high = math.inf, -math.inf
    for i, subject in enumerate(subjects):
        span = window_of(subject, window)
        t, phidot = series(subject.result, ("phidot",), span, pixel_columns(axes))["phidot"]
        hertz = phidot / (2 * math.pi)
        low, high = min(low, hertz.min()), max(high, hertz.max())
        pale, clear = _looks(subject, i, len(subjects))
        axes.plot(t, hertz, gid="phidot", zorder=above_wider(hertz), **pale)
        mean = mean_speed(subject, span, pixel_columns(axes))
        if len(mean[0]) or len(subjects) > 1:
            axes.plot(*mean, gid="mean", linewidth=0.9, zorder=2.9, **clear)
    colours = [overlay(i)["color"] for i in range(len(subjects))] if len(subjects) > 1 else [GREY]
    annotate_runs(axes, subjects, window, colours, impacts=False)
    _draw_frequencies(axes, subjects, low, high, (height_cm - 1.6) * 28)
    axes.set_ylabel(f"Motor speed {SPEED} (Hz)")
    time_axis(axes, window)


def _looks(subject: Subject, index: int, count: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """How the band and the line of a subject look; in a picture of one, both are named."""
    if count == 1:
        return {"color": SKY, "label": "instantaneous"}, {"color": BLUE, "label": f"mean of {TURNS} turns"}
    look = overlay(index)
    return {"color": look["color"], "alpha": 0.35}, {**look, "label": subject.name}


def mean_speed(subject: Subject, span: Span, columns: int) -> Series:
    """Mean speed over TURNS turns of the rotor [Hz] at their middle [s]; an envelope where they are many."""
    turns = turn_times(subject.result, span)
    middle, hertz = (turns[:-TURNS] + turns[TURNS:]) / 2, TURNS / (turns[TURNS:] - turns[:-TURNS])
    if len(middle) <= POINTS_PER_COLUMN * columns:
        return middle, hertz
    envelope = Envelope(*span, columns)
    envelope.add(middle, hertz)
    return envelope.points()


def _draw_frequencies(
    axes: Axes, subjects: Sequence[Subject], low: float, high: float, height_pt: float
) -> None:
    reach = NEAR * (high - low) or 0.1 * abs(high) or 1.0
    levels = [level for level in levels_of(subjects) if low - reach <= level.value <= high + reach]
    low, high = (
        min([low, *(level.value for level in levels)]),
        max([high, *(level.value for level in levels)]),
    )
    margin = 0.06 * (high - low) or 0.1
    axes.set_ylim(low - margin, high + margin)
    draw_levels(axes, levels, height_pt)


def levels_of(subjects: Sequence[Subject]) -> list[Level]:
    """Omega0 and natural frequencies [Hz] of the subjects, equal ones once, each named with its value."""
    levels: dict[tuple[str, float], Level] = {}
    for subject in subjects:
        no_load = motor_of(subject.scene).Omega0 / (2 * math.pi)
        named: list[tuple[str, float, dict[str, Any]]] = [(r"$\Omega_0$", no_load, {"linestyle": "-"})]
        named += [(f.label, f.hz, {"linestyle": (0, (4, 2))}) for f in natural_frequencies(subject.scene)]
        for label, hz, look in named:
            levels.setdefault((label, hz), Level(hz, f"{label}  {hz:.2f}", look))
    return list(levels.values())

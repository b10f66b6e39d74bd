"""Speed of the motor against time, with the frequencies at which it may be captured."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.margin_labels import Level, draw_levels
from vibsim.plots.natural_frequencies import natural_frequencies
from vibsim.plots.samples import common_window, series, window_of
from vibsim.plots.sheet import above_wider, legend_above, pixel_columns, sheet, time_axis
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.time_marks import annotate_run
from vibsim.plots.view import View

NEAR = 0.25  # frequencies up to this part of the drawn range beyond it are drawn too
HEIGHT_CM = 5.6
SPEED = r"$\dot\varphi/2\pi$"


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """phidot / 2 pi [Hz] against time [s]; no-load speed and natural frequencies as labelled levels."""
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    motor_speed_panel(axes, subjects, view)
    if len(subjects) > 1:
        legend_above(axes)
    return figure


def motor_speed_panel(axes: Axes, subjects: Sequence[Subject], view: View, height_cm: float = HEIGHT_CM) -> None:
    """The speed in given axes; height_cm is that of the sheet around them."""
    window = common_window(subjects, view.window)
    low, high = math.inf, -math.inf
    for i, subject in enumerate(subjects):
        found = series(subject.result, ("phidot",), window_of(subject, window), pixel_columns(axes))
        t, hertz = found["phidot"][0], found["phidot"][1] / (2 * math.pi)
        low, high = min(low, hertz.min()), max(high, hertz.max())
        look = overlay(i, dashed=False) if len(subjects) > 1 else {"color": BLUE}
        axes.plot(t, hertz, label=subject.name, gid="phidot", **look, zorder=above_wider(hertz))
    if len(subjects) == 1:
        annotate_run(axes, subjects[0], window)
    _draw_frequencies(axes, subjects, low, high, (height_cm - 1.6) * 28)
    axes.set_ylabel(f"Motor speed {SPEED} (Hz)")
    time_axis(axes, window)


def _draw_frequencies(axes: Axes, subjects: Sequence[Subject], low: float, high: float, height_pt: float) -> None:
    reach = NEAR * (high - low) or 0.1 * abs(high) or 1.0
    levels = [level for level in levels_of(subjects) if low - reach <= level.value <= high + reach]
    low, high = min([low, *(level.value for level in levels)]), max([high, *(level.value for level in levels)])
    margin = 0.06 * (high - low) or 0.1
    axes.set_ylim(low - margin, high + margin)
    draw_levels(axes, levels, height_pt)


def levels_of(subjects: Sequence[Subject]) -> list[Level]:
    """Omega0 and natural frequencies [Hz] of the subjects, equal ones once, each named with its value."""
    levels: dict[tuple[str, float], Level] = {}
    for subject in subjects:
        no_load = subject.scene.Omega0 / (2 * math.pi)
        named = [(r"$\Omega_0$", no_load, {"linestyle": "-"})]
        named += [(f.label, f.hz, {"linestyle": (0, (4, 2))}) for f in natural_frequencies(subject.scene)]
        for label, hz, look in named:
            levels.setdefault((label, hz), Level(hz, f"{label}  {hz:.2f}", look))
    return list(levels.values())

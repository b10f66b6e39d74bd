"""Displacements against the motor's speed: the passage through resonance in one picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, to_rgb
from matplotlib.figure import Figure

from vibsim.plots.motion.samples import window_of
from vibsim.plots.motion.time_marks import trust_remark
from vibsim.plots.motion.trace import Block, Trace, draw_trace, trace
from vibsim.plots.motion.turn_extremes import TurnExtremes, turn_extremes
from vibsim.plots.page.quantities import Scale, scale_for, seconds, symbol
from vibsim.plots.page.sheet import legend_above, letter_panels, note, sheet
from vibsim.plots.runs.motor_speed import SPEED
from vibsim.plots.runs.phase import moving
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span, View

LOOPS_UP_TO = 40  # turns that are seen as loops; of more, the extremes of each
HERTZ = Scale(1.0, "Hz")
PALE, PALER = "0.86", 0.22  # grey of one run; what is left of the colour of one of several
COLOURS_OF_TIME = "viridis"


@dataclass(frozen=True)
class Passage:
    """Displacement of a block of one run against the motor's speed, and the extremes where turns are many."""

    subject: Subject
    loops: Trace
    extremes: TurnExtremes | None
    colour: Any


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Displacements [m] against phidot / 2 pi [Hz]; the whole run unless the view has a window.

    Many turns overlap to an area: it is pale then, and upon it stand the least and the greatest displacement
    of every turn at the mean speed of that turn, coloured by time (by run where they are several).
    """
    columns = moving(subjects)
    figure = sheet(view, 1.4 + 4.4 * len(columns))
    panels = list(figure.subplots(len(columns), 1, squeeze=False, sharex=True)[:, 0])
    shown = displacement_frequency_panels(panels, subjects, view, columns)
    panels[-1].set_xlabel(f"Motor speed {SPEED} (Hz)")
    if shown is not None:
        figure.colorbar(shown, ax=panels, label="Time (s)", pad=0.02, aspect=40)
    spans = [window_of(subject, view.window) for subject in subjects]
    remarks = [*dict.fromkeys(map(seconds, spans)), trust_remark(subjects, spans)]
    note(panels[0], "; ".join(filter(None, remarks)))
    if len(subjects) > 1:
        legend_above(panels[0], markerscale=4)
    letter_panels(panels)
    figure.align_ylabels()
    return figure


def displacement_frequency_panels(
    panels: Sequence[Axes], subjects: Sequence[Subject], view: View, columns: Sequence[str]
) -> Any:
    """The displacements `columns`, each in given axes; the artist whose colours tell the time, if any."""
    spans = [window_of(subject, view.window) for subject in subjects]
    drawn = [_passages(subjects, spans, column) for column in columns]
    scale = scale_for("m", *(passage.loops.y for passages in drawn for passage in passages))
    shown = None
    for axes, column, passages in zip(panels, columns, drawn, strict=True):
        for passage in passages:
            shown = _draw(axes, passage, column, scale, alone=len(subjects) == 1) or shown
        axes.margins(0.04)
        axes.set_ylabel(scale.label(f"Displacement {symbol(column)}"))
    return shown


def _passages(subjects: Sequence[Subject], spans: Sequence[Span], column: str) -> list[Passage]:
    def plane(columns: Block) -> tuple[np.ndarray, np.ndarray]:
        return columns["phidot"] / (2 * math.pi), columns[column]

    passages = []
    for i, (subject, span) in enumerate(zip(subjects, spans, strict=True)):
        if column in subject.tables.samples:
            colour = overlay(i)["color"] if len(subjects) > 1 else BLUE
            loops = trace(subject.result, ("phidot", column), plane, span)
            extremes = turn_extremes(subject.result, column, span)
            many = len(extremes.hertz) > LOOPS_UP_TO
            passages.append(Passage(subject, loops, extremes if many else None, colour))
    return passages


def _draw(axes: Axes, passage: Passage, column: str, scale: Scale, alone: bool) -> Any:
    """One run: loops, and on them the extremes; what tells the time by colours, if anything does."""
    many = passage.extremes is not None
    look: dict[str, Any] = {"color": passage.colour, "linewidth": 0.3, "gid": column}
    if many:
        look["color"] = PALE if alone else tuple(1 - (1 - part) * PALER for part in to_rgb(passage.colour))
    name = passage.subject.name
    draw_trace(axes, passage.loops, (HERTZ, scale), **look, label="" if many else name)
    return _draw_extremes(axes, passage, scale, name, alone) if many else None


def _draw_extremes(axes: Axes, passage: Passage, scale: Scale, name: str, alone: bool) -> Any:
    extremes = passage.extremes
    assert extremes is not None
    x = np.concatenate([extremes.hertz, extremes.hertz])
    y = scale(np.concatenate([extremes.least, extremes.greatest]))
    size, rasterized = 1.6, len(x) > 10_000
    if not alone:
        axes.plot(
            x, y, linestyle="none", marker="o", markersize=1.2, markeredgewidth=0, color=passage.colour,
            label=name, gid="extremes", rasterized=rasterized, zorder=2.95,
        )  # fmt: skip
        return None
    times = np.concatenate([extremes.t, extremes.t])
    return axes.scatter(
        x, y, s=size, c=times, cmap=COLOURS_OF_TIME, norm=Normalize(float(times.min()), float(times.max())),
        linewidths=0, gid="extremes", rasterized=rasterized, zorder=2.95,
    )  # fmt: skip

"""Capture over an ensemble of starts: how probable it is, and which starts lead to it."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motion.frequency_marks import mark_frequencies
from vibsim.plots.page.sheet import note, sheet
from vibsim.plots.style import BLUE, VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import ascending, draws_by_ratio, is_speed, label_of, numbers, show_span
from vibsim.plots.sweeps.capture_map import SHADES
from vibsim.plots.sweeps.curves import DIRECTION_NAMES, frequencies
from vibsim.plots.sweeps.plane import missing_note
from vibsim.plots.sweeps.verdict_colours import legend_of, scatter_classes
from vibsim.plots.view import View
from vibsim.sweeps.computations.capture_verdict import VERDICTS

HEIGHT_CM = 6.8
CAPTURED = VERDICTS["captured"]


def draw_probability(subject: Subject, view: View) -> Figure:
    """Share of the members that are captured against what was swept, with Wilson's interval of 95 %."""
    result = subject.result
    axis = next(axis for axis in result.axes if len(axis) > 1 and axis is not result.members)
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    share = result.probability(result["capture"] == CAPTURED)
    directions = result.directions if result.plan.carry else result.directions[:1]
    for d, direction in enumerate(directions):
        order = ascending(axis)
        x, colour = numbers(axis)[order], (BLUE, VERMILLION)[d]
        estimate, low, high = (
            values[..., d].ravel()[order] for values in (share.estimate, share.low, share.high)
        )
        axes.fill_between(x, low, high, color=colour, alpha=0.2, linewidth=0, gid="interval")
        name = DIRECTION_NAMES[direction] if len(directions) > 1 else ""
        axes.plot(x, estimate, color=colour, marker="o", markersize=2, label=name, gid="probability")
    axes.set_ylim(-0.03, 1.03)
    show_span(axes, (x[0], x[-1]), 0.0, draws_by_ratio(axis), view)
    axes.set_xlabel(label_of(axis))
    axes.set_ylabel("Probability of capture")
    _say(axes, f"{len(result.members)} starts each; band: 95 %", subject)
    if is_speed(axis.key):
        mark_frequencies([axes], frequencies([subject]), (view.width_cm - 1.6) * 28)
    if len(directions) > 1:
        figure.legend(loc="outside lower center", ncols=2)
    return figure


def draw_starts(subject: Subject, view: View) -> Figure:
    """Start values of the members, coloured by the verdict: two of them, or one and the last speed."""
    result = subject.result
    spreads, verdicts = result.members.spreads, result["capture"][..., 0].ravel()
    drawn = [result.members.drawn[spread.key] for spread in spreads]
    if len(spreads) == 1:
        drawn.append(result["final_speed"][..., 0].ravel())
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    scatter_classes(axes, drawn[0], drawn[1], verdicts, SHADES, view)
    axes.set_xlabel(label_of(spreads[0]))
    axes.set_ylabel(label_of(spreads[1]) if len(spreads) == 2 else r"Last speed $\dot\varphi/2\pi$ (Hz)")
    share = result.probability(result["capture"] == CAPTURED)
    estimate, low, high = (
        float(100 * np.ravel(values)[0]) for values in (share.estimate, share.low, share.high)
    )
    _say(axes, f"captured: {estimate:.3g} % ({low:.3g} to {high:.3g})", subject)
    legend_of(figure, SHADES, verdicts)
    return figure


def _say(axes: Axes, words: str, subject: Subject) -> None:
    """A note above the axes, and what of the sweep is missing."""
    note(axes, "; ".join(filter(None, [words, missing_note(subject)])))

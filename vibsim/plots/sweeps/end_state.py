"""Basins of attraction of a motion without a source: which starts end at rest, which in vibration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.page.sheet import note, sheet
from vibsim.plots.style import BLUE, ORANGE, VERMILLION
from vibsim.plots.subject import Subject
from vibsim.plots.sweeps.axes import along, ascending, draws_by_ratio, label_of, numbers, show_span
from vibsim.plots.sweeps.ensemble_pictures import Pictures, share_map
from vibsim.plots.sweeps.map_sheet import map_sheet
from vibsim.plots.sweeps.plane import missing_note, plane_of
from vibsim.plots.sweeps.verdict_colours import Shade, lay_classes, legend_of, scatter_classes
from vibsim.plots.view import View
from vibsim.sweeps.computations.end_state import VERDICTS
from vibsim.sweeps.ensemble import Share

HEIGHT_CM = 6.8
UNDRAWN = 0.005  # greatest share of a curve that would lie on the axis
EDGE = 0.02  # of the range, beside the first and last mark
COLOURS = {"undecided": VERMILLION, "rest": BLUE, "vibration": ORANGE}
SHADES = [Shade(name, COLOURS[name]) for name in VERDICTS]
MARKS = {"undecided": "^", "rest": "o", "vibration": "s"}


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """What suits the sweep.

    Two ranges: the verdict on every point, as colours; with an ensemble at every point, the share of its
    members that come to rest. One range and an ensemble: the share of each verdict against the range. An
    ensemble alone over two start values: its starts, coloured by the verdict.
    """
    (subject,) = subjects
    return PICTURES.draw(subject, view)


def _draw_map(subject: Subject, view: View) -> Figure:
    plane, verdicts = plane_of(subject), subject.result["end_state"]
    figure, panels = map_sheet(plane, 1, view)
    for d, axes in enumerate(panels):
        lay_classes(axes, plane, plane.grid(verdicts, d), SHADES, "end_state")
    legend_of(figure, SHADES, verdicts[..., : len(panels)])
    return figure


def _draw_shares(subject: Subject, view: View) -> Figure:
    """Shares with Wilson's interval of 95 %, which is a bar where it is wider than a mark."""
    result = subject.result
    axis = result.axes[along(result)]
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    for shade in SHADES:
        share = result.probability(result["end_state"] == VERDICTS[shade.name])
        if np.nanmax(share.estimate) > UNDRAWN:
            _draw_share(axes, axis, share, shade)
    axes.set_ylim(-0.03, 1.03)
    x = numbers(axis)[ascending(axis)]
    show_span(axes, (x[0], x[-1]), EDGE, draws_by_ratio(axis), view)
    axes.set_xlabel(label_of(axis))
    axes.set_ylabel("Share of the starts")
    figure.legend(loc="outside lower center", ncols=2)
    doubts = int(np.count_nonzero(result["end_state"] == VERDICTS["undecided"]))
    doubts_text = f"; {doubts} undecided" if doubts else ""
    _say(axes, f"{len(result.members)} starts each; bars: 95 %{doubts_text}", subject)
    return figure


def _draw_share(axes: Axes, axis: Any, share: Share, shade: Shade) -> None:
    order = ascending(axis)
    x = numbers(axis)[order]
    estimate, low, high = (v[..., 0].ravel()[order] for v in (share.estimate, share.low, share.high))
    bars = np.array([estimate - low, high - estimate])
    drawn = axes.errorbar(
        x, estimate, np.maximum(bars, 0), label=shade.name, color=shade.colour, marker=MARKS[shade.name],
        markersize=2.5, capsize=1.5, elinewidth=0.7,
    )  # fmt: skip
    drawn.lines[0].set_gid(shade.name)


def _draw_starts(subject: Subject, view: View) -> Figure:
    """Two start values of the members; of one alone, against the displacement at the end."""
    result = subject.result
    spreads, verdicts = result.members.spreads, result["end_state"][..., 0].ravel()
    drawn = [result.members.drawn[spread.key] for spread in spreads]
    labels = [label_of(spread) for spread in spreads]
    if len(spreads) == 1:
        name = next(name for name in result.plan.columns if name.startswith("end_x"))
        drawn.append(result[name][..., 0].ravel())
        labels.append(f"{name.removeprefix('end_')} at the end (m)")
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    scatter_classes(axes, drawn[0], drawn[1], verdicts, SHADES, view)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    share = result.probability(result["end_state"] == VERDICTS["rest"])
    estimate, low, high = (float(100 * np.ravel(v)[0]) for v in (share.estimate, share.low, share.high))
    _say(axes, f"rest: {estimate:.3g} % ({low:.3g} to {high:.3g})", subject)
    legend_of(figure, SHADES, verdicts)
    return figure


def _say(axes: Axes, words: str, subject: Subject) -> None:
    """A note above the axes, and what of the sweep is missing."""
    note(axes, "; ".join(filter(None, [words, missing_note(subject)])))


PICTURES = Pictures(
    _draw_map, _draw_starts, _draw_shares, share_map("end_state", VERDICTS["rest"], "at rest")
)  # after the functions that it names

"""Basins of attraction: which attractor every start ends on; shares of attractors over a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibsim.plots.capture_pictures import HATCHES, Shade, lay_classes, map_sheet, scatter_classes
from vibsim.plots.sheet import legend_below, note, sheet
from vibsim.plots.style import BLUE, GREEN, MARKERS, ORANGE, PALE, PINK, SKY, VERMILLION, YELLOW
from vibsim.plots.subject import Subject
from vibsim.plots.sweep_axes import (
    ascending,
    draws_by_ratio,
    label_of,
    missing_note,
    numbers,
    plane_of,
    show_span,
)
from vibsim.plots.view import View
from vibsim.sweeps.attractors import Attractors, parameter_axes
from vibsim.sweeps.quantities import DONE, NONE

HEIGHT_CM = 6.8
LINE_CM = 0.4  # of a legend
EDGE = 0.02  # of the range, beside the first and last mark
COLOURS = (  # of attractors or branches, those of the largest shares first; what prints alike is hatched
    (BLUE, ""), (ORANGE, ""), (PALE, ""), (VERMILLION, "////"), (GREEN, "...."), (PINK, "\\\\\\\\"),
    (YELLOW, "----"), (SKY, "xxxx"),
)  # fmt: skip
OTHERS = Shade("other attractors", "0.75", "||||")
UNDECIDED = Shade("undecided", "0.95", "++++")


def basins_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """What suits the sweep.

    A parameter and starts at each of its values: the share of every attractor against it, a line for every
    branch. Two ranges: the attractor of every point, as colours. An ensemble alone over two start values: its
    starts, coloured by the attractor.
    """
    (subject,) = subjects
    if shows_shares(subject):
        return _draw_shares(subject, view)
    return _draw_map(subject, view) if subject.result.members is None else _draw_starts(subject, view)


def shows_shares(subject: Subject) -> bool:
    """Whether the shares over the one parameter that is swept are drawn: it has several starts at a value."""
    result = subject.result
    parameters = [i for i in parameter_axes(result.plan) if len(result.axes[i]) > 1]
    starts = [axis for i, axis in enumerate(result.axes) if i not in parameters and len(axis) > 1]
    return len(parameters) == 1 and (len(starts) > 1 or result.members in starts)


Side = tuple[int, int]  # a branch, and whether the mirror image of its orbits


class _Classes:
    """The branches of the attractors of a sweep and their mirror images, those of the largest shares first,
    each with its colour.

    An attractor of a single combination of parameters is a branch of its own.
    """

    def __init__(self, attractors: Attractors):
        self._attractors = attractors
        counts: dict[Side, int] = {}
        for i, branch in enumerate(attractors["branch"].tolist()):
            mirrored = round(attractors["share_mirror"][i] / attractors["share"][i] * attractors["count"][i])
            for side, count in ((0, int(attractors["count"][i]) - mirrored), (1, mirrored)):
                if count:
                    counts[branch, side] = counts.get((branch, side), 0) + count
        self.sides = sorted(counts, key=lambda side: (-counts[side], side))
        few = self.sides[: len(COLOURS)]
        self.shades = [Shade(self._words(*side), *look) for side, look in zip(few, COLOURS, strict=False)]
        self.shades += [OTHERS, UNDECIDED]

    @property
    def legend_cm(self) -> float:
        """Height of the lines of the legend beyond the first two [cm]."""
        return LINE_CM * max(len(self.shades) - 4, 0)

    def shares(self, branch: int, mirrored: int) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the attractors of a branch, and the shares of their orbits or of the mirror images."""
        attractors = self._attractors
        rows = np.flatnonzero(attractors["branch"] == branch)
        images = attractors["share_mirror"][rows]
        shares = images if mirrored else attractors["share"][rows] - images
        return rows[shares > 0], shares[shares > 0]

    def _words(self, branch: int, mirrored: int) -> str:
        """Kind, period and multiplier of the attractors of a branch, and their share."""
        rows, shares = self.shares(branch, mirrored)
        words = self._attractors.words(int(rows[0]))
        words = words if len(rows) == 1 else words.partition(",")[0]
        image = " (mirror image)" if mirrored else ""
        return f"{words}{image}: {100 * shares[0]:.3g} %" if len(rows) == 1 else f"{words}{image}"

    def of(self, labels: np.ndarray, mirrored: np.ndarray, status: np.ndarray) -> np.ndarray:
        """Index into the shades of each point; NaN where it was not computed."""
        branches = self._attractors["branch"].tolist() or [NONE]
        codes = np.array([[self._code((branch, side)) for side in (0, 1)] for branch in branches], float)
        classes = np.where(labels == NONE, len(self.shades) - 1.0, codes[np.maximum(labels, 0), mirrored])
        return np.where(status == DONE, classes, np.nan)

    def _code(self, side: Side) -> int:
        place = self.sides.index(side) if side in self.sides else len(self.sides)
        return min(place, len(self.shades) - 2)

    def legend(self, figure: Figure, classes: np.ndarray) -> None:
        """The legend of the classes that occur, with how many are undecided."""
        known = classes[~np.isnan(classes)].astype(int)
        edge: dict[str, Any] = {"edgecolor": HATCHES, "linewidth": 0.4}
        shown = [shade for code, shade in enumerate(self.shades) if (known == code).any()]
        patches = [Patch(facecolor=shade.colour, hatch=shade.hatch, **edge) for shade in shown]
        undecided = int((known == len(self.shades) - 1).sum())
        names = [f"undecided ({undecided})" if shade is UNDECIDED else shade.name for shade in shown]
        if shown:
            legend_below(figure, patches, names, handlelength=1.2)


def _draw_map(subject: Subject, view: View) -> Figure:
    plane, result = plane_of(subject), subject.result
    classes = _Classes(result.attractors)
    codes = classes.of(result["attractor"], result["attractor_mirrored"], result["status"])
    figure, panels = map_sheet(plane, 1, view)
    for d, axes in enumerate(panels):
        lay_classes(axes, plane, plane.grid(codes, d), classes.shades, "attractor")
    classes.legend(figure, codes[..., : len(panels)])
    return figure


def _draw_starts(subject: Subject, view: View) -> Figure:
    """Two start values of the members; of one alone, against the number of the attractor."""
    result = subject.result
    spreads, classes = result.members.spreads, _Classes(result.attractors)
    drawn = [result.members.drawn[spread.key] for spread in spreads]
    labels = [label_of(spread) for spread in spreads]
    if len(spreads) == 1:
        drawn.append(result["attractor"][..., 0].ravel())
        labels.append("Number of the attractor")
    figure = sheet(view, HEIGHT_CM + classes.legend_cm)
    axes = figure.subplots()
    codes = classes.of(result["attractor"], result["attractor_mirrored"], result["status"])[..., 0].ravel()
    scatter_classes(axes, drawn[0], drawn[1], codes, classes.shades, view)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    note(axes, missing_note(subject))
    classes.legend(figure, codes)
    return figure


def _draw_shares(subject: Subject, view: View) -> Figure:
    """Shares with their standard errors, a line for every branch."""
    result = subject.result
    attractors, classes = result.attractors, _Classes(result.attractors)
    (position,) = (i for i in parameter_axes(result.plan) if len(result.axes[i]) > 1)
    axis = result.axes[position]
    figure = sheet(view, HEIGHT_CM + classes.legend_cm)
    axes = figure.subplots()
    for k, side in enumerate(classes.sides[: len(COLOURS)]):
        rows, shares = classes.shares(*side)
        values = numbers(axis)[attractors["point"][rows]]
        order = np.argsort(values, kind="stable")
        bars = np.sqrt(shares * (1 - shares) / _starts(attractors, rows))
        drawn = axes.errorbar(
            values[order], shares[order], bars[order], label=classes.shades[k].name,
            color=classes.shades[k].colour, marker=MARKERS[k % len(MARKERS)], markersize=2.5, capsize=1.5,
            elinewidth=0.7,
        )  # fmt: skip
        drawn.lines[0].set_gid(f"branch {side[0]}" + " mirrored" * side[1])
    x = numbers(axis)[ascending(axis)]
    axes.set_ylim(-0.03, 1.03)
    show_span(axes, (x[0], x[-1]), EDGE, draws_by_ratio(axis), view)
    axes.set_xlabel(label_of(axis))
    axes.set_ylabel("Share of the starts")
    handles, labels = axes.get_legend_handles_labels()
    legend_below(figure, handles, labels)
    undecided = int(((result["attractor"] == NONE) & (result["status"] == DONE)).sum())
    more = len(classes.sides) - len(COLOURS)
    remarks = [
        "bars: standard errors",
        f"{undecided} undecided" if undecided else "",
        f"{more} more attractors, not drawn" if more > 0 else "",
        missing_note(subject),
    ]
    note(axes, "; ".join(filter(None, remarks)))
    return figure


def _starts(attractors: Attractors, rows: np.ndarray) -> np.ndarray:
    """How many starts the shares of attractors are of."""
    return np.asarray(attractors["count"][rows] / attractors["share"][rows])

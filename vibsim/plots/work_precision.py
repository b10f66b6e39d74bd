"""The work-precision diagram: error against processor time of every method, and until when it is faithful."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from vibsim.evidence.benchmark.families import Family, family_of
from vibsim.evidence.benchmark.row import Row
from vibsim.evidence.benchmark.verdicts import error_at, faster, most_accurate
from vibsim.plots.errors import PlotError
from vibsim.plots.page.curve_labels import Named, write_names
from vibsim.plots.page.sheet import letter_panels, note, sheet
from vibsim.plots.page.user_text import as_text
from vibsim.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, SKY, VERMILLION, points
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

HEIGHT_CM = 8.5
LEADS = 2  # peers that an arrow says the distance of
SIDE_BY_SIDE = {"ncols": 2, "width_ratios": (2.8, 1)}
OWN: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.8, "markersize": 5.0, "zorder": 4}
PEER: dict[str, Any] = {"linewidth": 0.8, "markersize": 3.2, "zorder": 3}
RING: dict[str, Any] = {
    "marker": "o", "markersize": 8.0, "markerfacecolor": "none", "markeredgecolor": GREY, "linestyle": "none",
    "markeredgewidth": 0.8, "zorder": 2,
}  # fmt: skip
DASHED = (0, (4, 1.5))
UNDRAWN = {"orders"}  # they crowd where the curve of the Taylor series ends; the table has them
LOOKS: dict[str, dict[str, Any]] = {
    "closed-form": {**OWN, "marker": "*", "markersize": 9.0},
    "taylor": {**OWN, "marker": "o"},
    "python": {**OWN, "marker": "o", "markerfacecolor": "white"},
    "heyoka": {**PEER, "color": BLUE, "marker": "D"},
    "dop853": {**PEER, "color": GREEN, "marker": "o"},
    "lsoda": {**PEER, "color": SKY, "marker": "^"},
    "radau": {**PEER, "color": PINK, "marker": "v"},
    "rk45": {**PEER, "color": BLACK, "marker": "x", "linestyle": DASHED},
    "tanh": {**PEER, "color": ORANGE, "marker": "s", "linestyle": DASHED},
    "rk4": {**PEER, "color": GREY, "marker": "+", "linestyle": DASHED},
}


def look_of(family: Family) -> dict[str, Any]:
    """Line and markers of a family."""
    return LOOKS.get(family.name, {**PEER, "color": GREY, "marker": "."})


@dataclass(frozen=True)
class Curve:
    """One family: processor time per second of motion [s], error [m], faithful time [s] of its rows (n), and
    whether they missed events while they were faithful.
    """

    family: Family
    time: np.ndarray
    error: np.ndarray
    faithful: np.ndarray
    missed: np.ndarray


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Errors against times in double logarithm, and beside it the faithful times."""
    if len(subjects) > 1:
        raise PlotError(f"kind work-precision shows one bench at a time, not {len(subjects)}")
    bench = subjects[0].result
    drawn = curves(bench)
    if not drawn:
        raise PlotError(f"{subjects[0].path}: no method in it came to {bench.telling_time:g} s")
    narrow = view.width == "column"  # then one panel stands below the other
    figure = sheet(view, 1.6 * HEIGHT_CM if narrow else HEIGHT_CM)
    shape: dict[str, Any] = {"nrows": 2, "height_ratios": (1.6, 1)} if narrow else SIDE_BY_SIDE
    axes, beside = figure.subplots(**shape)
    _draw_curves(axes, drawn)
    axes.set_xlabel("Least processor time per second of motion (s)")
    axes.set_ylabel(f"Largest error of the displacements until {bench.telling_time:g} s (m)")
    leads = _leads(axes, bench, drawn)
    note(axes, f"{as_text(bench.attrs['case_name'])}; {_legend(drawn, leads)}")
    note(beside, f"error within {1e3 * bench.faithful_error:.3g} mm")
    _draw_faithful(beside, drawn, float(bench["time"][-1]))
    letter_panels([axes, beside])
    write_names(axes, [*leads, *_names(drawn)])
    return figure


def curves(bench: Any) -> list[Curve]:
    """The families that came to the telling time, their rows in the order of the ladder."""
    listed = []
    for method in dict.fromkeys(row.method for row in bench.rows if row.method not in UNDRAWN):
        rows = [row for row in bench.rows if row.method == method and isfinite(error_at(bench, row))]
        if rows:
            columns = [
                np.array(values)
                for values in (
                    [row.time_per_second for row in rows],
                    [error_at(bench, row) for row in rows],
                    [row.faithful_time for row in rows],
                    [_missed(row) for row in rows],
                )
            ]
            listed.append(Curve(family_of(method), *columns))
    return listed


def _missed(row: Row) -> bool:
    """Whether a row stepped over events while its displacements were still faithful."""
    count = row.counted()
    return count is not None and count.missed > 0


def _legend(drawn: Sequence[Curve], leads: Sequence[Named]) -> str:
    """What dashes, rings and arrows mean, as far as they are there."""
    words = ["dashed: events not located"] if any(_is_dashed(curve.family) for curve in drawn) else []
    words += ["ringed: events missed"] if any(curve.missed.any() for curve in drawn) else []
    words += ["arrows: vibsim at no larger error"] if leads else []
    return "; ".join(words)


def _is_dashed(family: Family) -> bool:
    return look_of(family).get("linestyle") is DASHED


def _draw_curves(axes: Axes, drawn: Sequence[Curve]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for curve in drawn:
        axes.plot(curve.time, curve.error, gid=curve.family.name, **look_of(curve.family))
        if curve.missed.any():
            axes.plot(curve.time[curve.missed], curve.error[curve.missed], gid="missed", **RING)
    axes.margins(0.1, 0.1)
    axes.yaxis.set_major_locator(LogLocator(numticks=12))


def _names(drawn: Sequence[Curve]) -> list[Named]:
    """The name of each family, to stand beside its most accurate row or where there is room."""
    named = []
    for curve in drawn:
        order = np.argsort(curve.error)
        weight = "bold" if curve.family.own else "normal"
        look = {"color": look_of(curve.family)["color"], "fontweight": weight}
        named.append(Named(curve.family.mark, curve.time[order], curve.error[order], look))
    return named


def _leads(axes: Axes, bench: Any, drawn: Sequence[Curve]) -> list[Named]:
    """Arrows from the two most accurate peers to vibsim at no larger error; the words beside them."""
    peers = [most_accurate(bench, curve.family.name) for curve in drawn if not curve.family.own]
    best = sorted((row for row in peers if row), key=lambda row: error_at(bench, row))
    leads = []
    for row in best[:LEADS]:
        times = faster(bench, row)
        if times is not None and times > 1:
            leads.append(_lead(axes, row.time_per_second, times, error_at(bench, row)))
    return leads


def _lead(axes: Axes, time: float, times: float, error: float) -> Named:
    axes.annotate(
        "", (time / times, error), (time, error),
        arrowprops={"arrowstyle": "-|>", "color": VERMILLION, "linewidth": 0.8, "shrinkA": 4, "shrinkB": 5},
    )  # fmt: skip
    places = time / times ** np.array([0.5, 1.0, 0.0])  # the middle of the arrow, its head, its tail
    look = {"color": VERMILLION, "gid": "lead"}
    return Named(f"{float(f'{times:.2g}'):g} x faster", places, np.full(3, error), look)


def _draw_faithful(axes: Axes, drawn: Sequence[Curve], span: float) -> None:
    """A line of marks per family: the faithful times of its settings."""
    for place, curve in enumerate(drawn):
        look = {**look_of(curve.family), "linewidth": 0.8}
        axes.plot(curve.faithful, np.full(len(curve.faithful), -place), gid="faithful", **look)
    axes.set_yticks(-np.arange(len(drawn)), [curve.family.mark for curve in drawn], fontsize=points(6.5))
    for label, curve in zip(axes.get_yticklabels(), drawn, strict=True):
        label.set_color(look_of(curve.family)["color"])
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(-0.05 * span, 1.05 * span)
    axes.set_xlabel("Faithful until (s)")

"""Pictures of a fit (candidates over their free parameters) and of a bench (speed against error)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from vibsim.cases.problems import counted
from vibsim.evidence.benchmark.bench_result import BenchRow, error_at, faster, most_accurate
from vibsim.evidence.benchmark.plan import SolverFamily, family_of
from vibsim.fitting.fit_result import FitResult
from vibsim.fitting.plan import number_of
from vibsim.fitting.search import Judgement
from vibsim.fitting.statements import FreeParameter
from vibsim.plots.sheet import (
    NamedQuantity,
    amount,
    draw_by_ratio,
    legend_below,
    letter_panels,
    note,
    sheet,
    write_names,
)
from vibsim.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, SKY, VERMILLION, points
from vibsim.plots.subject import PlotError, Subject, View, as_text
from vibsim.plots.sweep_axes import words_of

FIT_HEIGHT_CM = 7.0
PENALTY = "Penalty (0: every statement holds)"
SIZE = 26  # of a point [pt^2]
ROOM = 0.04  # of the range, beside the first and last point


def fit_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Price of the candidates judged from all starts; the best ringed, the printed values crossed."""
    fit: FitResult = subjects[0].result
    figure = sheet(view, FIT_HEIGHT_CM)
    axes = figure.subplots()
    free = fit.plan.free[:2]
    judged = [each for each in fit.ranking if _is_placed(each, free)]
    if len(free) == 1:
        _along(axes, fit, judged, free[0])
    else:
        _plane(figure, axes, fit, judged, free)
    note(axes, f"{len(judged)} of {counted(len(fit.candidates), 'candidate')}")
    marks = [mark for mark in axes.get_lines() if mark.get_gid() in ("best", "printed")]
    legend_below(figure, marks, [str(mark.get_label()) for mark in marks], markerscale=0.7)
    return figure


def _is_placed(judged: Judgement, free: Sequence[FreeParameter]) -> bool:
    return any(each.key in judged.candidate.changes for each in free) or not judged.candidate.changes


def _along(axes: Axes, fit: FitResult, judged: Sequence[Judgement], free: FreeParameter) -> None:
    """The penalty against one parameter."""
    axes.plot(
        [_value(each, free) for each in judged], [each.price for each in judged], "o", color=BLUE,
        markersize=3.5, gid="price",
    )  # fmt: skip
    _mark(axes, (_value(fit.best, free), fit.best.price), None)
    axes.set_ylabel(PENALTY)
    _axis(axes, "x", free)


def _plane(
    figure: Figure, axes: Axes, fit: FitResult, judged: Sequence[Judgement], free: Sequence[FreeParameter]
) -> None:
    """The penalty in colours over two parameters, candidates of a high one below those of a low one."""
    order = sorted(judged, key=lambda each: -each.price)
    x, y = ([_value(each, one) for each in order] for one in free)
    shown = axes.scatter(
        x, y, c=[each.price for each in order], s=SIZE, cmap="viridis_r", edgecolors="white",
        linewidths=0.4, gid="price",
    )  # fmt: skip
    figure.colorbar(shown, ax=axes, label=PENALTY, pad=0.02, aspect=30)
    _mark(axes, tuple(_value(fit.best, one) for one in free), tuple(one.printed[0] for one in free))
    for which, one in zip("xy", free, strict=True):
        _axis(axes, which, one)


def scatter_shares(
    axes: Axes, places: Sequence[tuple[float, float]], shares: Sequence[float], label: str
) -> None:
    """Points of a plane coloured by a share from 0 to 1, high ones on top, with the key beside."""
    order = np.argsort(np.array(shares), kind="stable")
    x, y = (np.array([place[i] for place in places])[order] for i in (0, 1))
    shown = axes.scatter(
        x, y, c=np.array(shares)[order], s=SIZE, vmin=0, vmax=1, cmap="viridis", edgecolors=GREY,
        linewidths=0.3, gid="share",
    )  # fmt: skip
    figure: Any = axes.figure
    figure.colorbar(shown, ax=axes, label=label, pad=0.02, aspect=30)


def _value(judged: Judgement, free: FreeParameter) -> float:
    number = number_of(judged.candidate, free)
    return free.printed[0] if np.isnan(number) else number


def _mark(axes: Axes, best: Any, printed: Any) -> None:
    axes.plot(
        *best, "o", color="black", markersize=9, markerfacecolor="none", markeredgewidth=1.3, gid="best",
        label="best",
    )  # fmt: skip
    if printed is not None:
        axes.plot(
            *printed, "x", color="black", markersize=6, markeredgewidth=1.3, gid="printed",
            label="as in the case",
        )  # fmt: skip


def _axis(axes: Axes, which: str, free: FreeParameter) -> None:
    words = words_of(free.key) or free.name
    label = f"{words} ({free.unit})" if free.unit else words
    axes.set(**{f"{which}label": label})
    if free.by_ratio:
        draw_by_ratio(axes, which)
    axes.margins(*((ROOM, None) if which == "x" else (None, ROOM)))


# The work-precision diagram: error against processor time of every method, and until when it is faithful.


WORK_PRECISION_HEIGHT_CM = 8.5
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
    "heyoka": {**PEER, "color": BLUE, "marker": "D"},
    "dop853": {**PEER, "color": GREEN, "marker": "o"},
    "lsoda": {**PEER, "color": SKY, "marker": "^"},
    "radau": {**PEER, "color": PINK, "marker": "v"},
    "rk45": {**PEER, "color": BLACK, "marker": "x", "linestyle": DASHED},
    "tanh": {**PEER, "color": ORANGE, "marker": "s", "linestyle": DASHED},
    "rk4": {**PEER, "color": GREY, "marker": "+", "linestyle": DASHED},
}


def look_of(family: SolverFamily) -> dict[str, Any]:
    """Line and markers of a family."""
    return LOOKS.get(family.name, {**PEER, "color": GREY, "marker": "."})


@dataclass(frozen=True)
class WorkPrecisionCurve:
    """One family: processor time per second of motion [s], error [m], faithful time [s] of its rows (n), and
    whether they missed events while they were faithful.
    """

    family: SolverFamily
    time: np.ndarray
    error: np.ndarray
    faithful: np.ndarray
    missed: np.ndarray


def work_precision_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Errors against times in double logarithm, and beside it the faithful times."""
    if len(subjects) > 1:
        raise PlotError(f"kind work-precision shows one bench at a time, not {len(subjects)}")
    bench = subjects[0].result
    drawn = curves(bench)
    if not drawn:
        raise PlotError(f"{subjects[0].path}: no method in it came to {bench.telling_time:g} s")
    narrow = view.width == "column"  # then one panel stands below the other
    figure = sheet(view, 1.6 * WORK_PRECISION_HEIGHT_CM if narrow else WORK_PRECISION_HEIGHT_CM)
    shape: dict[str, Any] = {"nrows": 2, "height_ratios": (1.6, 1)} if narrow else SIDE_BY_SIDE
    axes, beside = figure.subplots(**shape)
    _draw_curves(axes, drawn)
    axes.set_xlabel("Processor time per second of motion (s)")
    axes.set_ylabel(f"Largest error of the displacements until {bench.telling_time:g} s ({bench.error_unit})")
    leads = _leads(axes, bench, drawn)
    note(axes, f"{as_text(bench.attrs['case_name'])}; {_legend(drawn, leads)}")
    note(beside, f"error within {amount(bench.faithful_error, bench.error_unit)}")
    _draw_faithful(beside, drawn, float(bench["time"][-1]))
    letter_panels([axes, beside])
    write_names(axes, [*leads, *_names(drawn)])
    return figure


def curves(bench: Any) -> list[WorkPrecisionCurve]:
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
            listed.append(WorkPrecisionCurve(family_of(method), *columns))
    return listed


def _missed(row: BenchRow) -> bool:
    """Whether a row stepped over events while its displacements were still faithful."""
    count = row.counted()
    return count is not None and count.missed > 0


def _legend(drawn: Sequence[WorkPrecisionCurve], leads: Sequence[NamedQuantity]) -> str:
    """Words for dashes, rings and arrows, as far as they are drawn."""
    words = ["dashed: events not located"] if any(_is_dashed(curve.family) for curve in drawn) else []
    words += ["ringed: events missed"] if any(curve.missed.any() for curve in drawn) else []
    words += ["arrows: vibsim at no larger error"] if leads else []
    return "; ".join(words)


def _is_dashed(family: SolverFamily) -> bool:
    return look_of(family).get("linestyle") is DASHED


def _draw_curves(axes: Axes, drawn: Sequence[WorkPrecisionCurve]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for curve in drawn:
        axes.plot(curve.time, curve.error, gid=curve.family.name, **look_of(curve.family))
        if curve.missed.any():
            axes.plot(curve.time[curve.missed], curve.error[curve.missed], gid="missed", **RING)
    axes.margins(0.1, 0.1)
    axes.yaxis.set_major_locator(LogLocator(numticks=12))


def _names(drawn: Sequence[WorkPrecisionCurve]) -> list[NamedQuantity]:
    """The name of each family, to stand beside its most accurate row or where there is room."""
    named = []
    for curve in drawn:
        order = np.argsort(curve.error)
        weight = "bold" if curve.family.own else "normal"
        look = {"color": look_of(curve.family)["color"], "fontweight": weight}
        named.append(NamedQuantity(curve.family.mark, curve.time[order], curve.error[order], look))
    return named


def _leads(axes: Axes, bench: Any, drawn: Sequence[WorkPrecisionCurve]) -> list[NamedQuantity]:
    """Arrows from the two most accurate peers to vibsim at no larger error; the words beside them."""
    peers = [most_accurate(bench, curve.family.name) for curve in drawn if not curve.family.own]
    best = sorted((row for row in peers if row), key=lambda row: error_at(bench, row))
    leads = []
    for row in best[:LEADS]:
        times = faster(bench, row)
        if times is not None and times > 1:
            leads.append(_lead(axes, row.time_per_second, times, error_at(bench, row)))
    return leads


def _lead(axes: Axes, time: float, times: float, error: float) -> NamedQuantity:
    axes.annotate(
        "", (time / times, error), (time, error),
        arrowprops={"arrowstyle": "-|>", "color": VERMILLION, "linewidth": 0.8, "shrinkA": 4, "shrinkB": 5},
    )  # fmt: skip
    places = time / times ** np.array([0.5, 1.0, 0.0])  # the middle of the arrow, its head, its tail
    look = {"color": VERMILLION, "gid": "lead"}
    return NamedQuantity(f"{float(f'{times:.2g}'):g} x faster", places, np.full(3, error), look)


def _draw_faithful(axes: Axes, drawn: Sequence[WorkPrecisionCurve], span: float) -> None:
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

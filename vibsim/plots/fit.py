"""A fit: the candidates over their first two free parameters, or the price over one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.fitting.fit_result import FitResult
from vibsim.fitting.goals.free_parameter import FreeParameter
from vibsim.fitting.judgement import Judgement
from vibsim.fitting.store.fit_file import number_of
from vibsim.plots.page.log_axis import draw_by_ratio
from vibsim.plots.page.sheet import legend_below, note, sheet
from vibsim.plots.style import BLUE, GREY
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

HEIGHT_CM = 7.0
SIZE = 26  # of a point [pt^2]
ROOM = 0.04  # of the range, beside the first and last point


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Price of the candidates judged from all starts; the best ringed, the printed values crossed."""
    fit: FitResult = subjects[0].result
    figure = sheet(view, HEIGHT_CM)
    axes = figure.subplots()
    free = fit.plan.free[:2]
    judged = [each for each in fit.ranking if _is_placed(each, free)]
    if len(free) == 1:
        _along(axes, fit, judged, free[0])
    else:
        _plane(figure, axes, fit, judged, free)
    note(axes, f"{len(judged)} of {len(fit.candidates)} candidates")
    marks = [mark for mark in axes.get_lines() if mark.get_gid() in ("best", "printed")]
    legend_below(figure, marks, [str(mark.get_label()) for mark in marks], markerscale=0.7)
    return figure


def _is_placed(judged: Judgement, free: Sequence[FreeParameter]) -> bool:
    return any(each.key in judged.candidate.changes for each in free) or not judged.candidate.changes


def _along(axes: Axes, fit: FitResult, judged: Sequence[Judgement], free: FreeParameter) -> None:
    """The price against one parameter."""
    axes.plot(
        [_value(each, free) for each in judged], [each.price for each in judged], "o", color=BLUE,
        markersize=3.5, gid="price",
    )  # fmt: skip
    _mark(axes, (_value(fit.best, free), fit.best.price), None)
    axes.set_ylabel("Price")
    _axis(axes, "x", free)


def _plane(
    figure: Figure, axes: Axes, fit: FitResult, judged: Sequence[Judgement], free: Sequence[FreeParameter]
) -> None:
    """The price in colours over two parameters, dear candidates below cheap ones."""
    order = sorted(judged, key=lambda each: -each.price)
    x, y = ([_value(each, one) for each in order] for one in free)
    shown = axes.scatter(
        x, y, c=[each.price for each in order], s=SIZE, cmap="viridis_r", edgecolors="white",
        linewidths=0.4, gid="price",
    )  # fmt: skip
    figure.colorbar(shown, ax=axes, label="Price", pad=0.02, aspect=30)
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
            label="as printed",
        )  # fmt: skip


def _axis(axes: Axes, which: str, free: FreeParameter) -> None:
    label = f"{free.name} ({free.unit})" if free.unit else free.name
    axes.set(**{f"{which}label": label})
    if free.by_ratio:
        draw_by_ratio(axes, which)
    axes.margins(*((ROOM, None) if which == "x" else (None, ROOM)))

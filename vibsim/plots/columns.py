"""Any two columns of a result against each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.cases.problems import did_you_mean
from vibsim.plots.samples import rows, window_of
from vibsim.plots.sheet import as_text, legend_above, sheet
from vibsim.plots.style import BLUE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.traces import LINE_UP_TO, VECTOR_UP_TO, Trace, one_per_pixel, trace
from vibsim.plots.view import PlotError, View
from vibsim.results.labelled import Arrays, Labelled, Tidy

EVENTS = "events/"  # before the name of a column of events


def columns_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Column `view.y` against column `view.x`: of the samples of a run within the window a line, as smooth as
    the motion where both are states; of everything else points, those whose x lies within the window.
    """
    if not view.x or not view.y:
        raise PlotError("two columns go against each other: give both of them, x and y")
    figure = sheet(view, 6.4)
    axes = figure.subplots()
    for i, subject in enumerate(subjects):
        table, names = _table(subject, (view.x, view.y))
        of_samples = table.dims == ("time",)
        drawn = _of_samples(subject, table, names, view) if of_samples else _points(table, names, view)
        look = overlay(i) if len(subjects) > 1 else {"color": BLUE}
        if not drawn.joined:
            look |= {"linestyle": "none", "marker": "o", "markersize": 1.5}
        many = len(drawn.x) > VECTOR_UP_TO
        axes.plot(drawn.x, drawn.y, label=subject.name, gid="columns", linewidth=0.5, rasterized=many, **look)
        if i == 0:
            _label(axes, table, names)
    axes.margins(0.04)
    if len(subjects) > 1:
        legend_above(axes)
    return figure


def _of_samples(subject: Subject, table: Tidy, names: Sequence[str], view: View) -> Trace:
    """The samples within the window [s]; of states also instants between them."""
    span, result = window_of(subject, view.window), subject.result
    if set(names) <= {"time", *subject.tables.states}:
        columns = tuple(dict.fromkeys(("time", *names)))
        return trace(result, columns, lambda block: (block[names[0]], block[names[1]]), span)
    within = rows(result, span)
    x, y = (np.asarray(table.values(name, within), float) for name in names)
    return Trace(x, y, True) if len(x) <= LINE_UP_TO else Trace(*one_per_pixel(lambda: [(x, y)]), False)


def _points(table: Tidy, names: Sequence[str], view: View) -> Trace:
    """The rows in which both columns are known, x within the window. Raises PlotError for none."""
    x, y = (np.asarray(table.values(name), float) for name in names)
    low, high = view.window or (-np.inf, np.inf)
    known = (x >= low) & (x <= high) & ~np.isnan(x) & ~np.isnan(y)
    if not known.any():
        raise PlotError("nothing is known of both columns" + (" within the window" if view.window else ""))
    x, y = x[known], y[known]
    if len(x) > LINE_UP_TO:
        x, y = one_per_pixel(lambda: [(x, y)])
    return Trace(x, y, joined=False)


def _table(subject: Subject, names: tuple[str, str]) -> tuple[Tidy, list[str]]:
    """The table that has both columns, and their names in it. Raises PlotError."""
    arrays = _arrays(subject, names)
    inner = [name.removeprefix(EVENTS) for name in names]
    for name in inner:
        if name not in arrays.datasets:
            near = did_you_mean(name, arrays.datasets)
            raise PlotError(
                f"{subject.path} has no column {name!r}{near}; it has {', '.join(arrays.datasets)}"
            )
    further = {d for name in inner for d in arrays.datasets[name].dims} & set(arrays.further)
    if len(further) > 1:
        raise PlotError(f"{names[0]} and {names[1]} have no rows in common: they run along {sorted(further)}")
    return Tidy(arrays, *further), inner


def _arrays(subject: Subject, names: tuple[str, str]) -> Arrays:
    result = subject.result
    if not isinstance(result, Labelled):
        raise PlotError(f"{subject.path} has no columns to draw: x and y are for results")
    of_events = [name.startswith(EVENTS) for name in names]
    if any(of_events) and subject.reads != "trajectory":
        raise PlotError(f"{subject.path} has no events")
    if any(of_events) and not all(of_events):
        raise PlotError(f"{names[0]} and {names[1]}: one is of events and one is not")
    return subject.result.events.arrays() if any(of_events) else result.arrays()


def _label(axes: Axes, table: Tidy, names: Sequence[str]) -> None:
    for name, axis in zip(names, (axes.xaxis, axes.yaxis), strict=True):
        column = table.arrays.column(name)
        unit = f" ({column.units})" if column.units and column.units != "1" else ""
        axis.set_label_text(as_text(name) + unit)
        if column.flags:
            axis.set_ticks(list(column.flags.values()), list(column.flags))


# Axes of the user's, in the place of a figure that a kind of picture would make for itself.


class GivenAxes:
    """Stands for a figure whose panels are these axes; everything else is asked of their own figure.

    Raises PlotError where a picture needs another number of panels.
    """

    def __init__(self, axes: Sequence[Axes]):
        self._axes = list(axes)
        self._figure = axes[0].get_figure(root=True)

    def __call__(self, **_: Any) -> GivenAxes:
        """Itself, as `matplotlib.figure.Figure` would be made."""
        return self

    def subplots(
        self, nrows: int = 1, ncols: int = 1, *, squeeze: bool = True, gridspec_kw: Any = None, **_: Any
    ) -> Any:
        """The axes in the shape asked for."""
        self._check(nrows * ncols)
        grid = np.array(self._axes, dtype=object).reshape(nrows, ncols)
        if not squeeze:
            return grid
        return grid[0, 0] if grid.size == 1 else grid.squeeze()

    def _check(self, count: int) -> None:
        if count != len(self._axes):
            panels = "1 panel" if count == 1 else f"{count} panels"
            raise PlotError(
                f"this picture has {panels}, and ax gives {len(self._axes)}: give as many, or leave ax out"
            )

    def add_gridspec(self, *args: Any, **options: Any) -> Any:
        """Pictures of unequal panels lay out a whole sheet."""
        raise PlotError("this picture lays out a whole sheet of panels: leave ax out")

    add_axes = add_subplot = add_gridspec

    def suptitle(self, *args: Any, **options: Any) -> None:
        """The title of the whole sheet is the user's."""

    def legend(self, handles: Any, labels: Any, **_: Any) -> Any:
        """A legend of the picture stands in its last panel."""
        return self._axes[-1].legend(handles, labels)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._figure, name)

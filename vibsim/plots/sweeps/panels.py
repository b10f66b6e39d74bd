"""Panels beside and below each other, as many in a row as the width of the picture allows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.page.sheet import letter_panels, sheet
from vibsim.plots.style import points
from vibsim.plots.sweeps.curves import Curve, families
from vibsim.plots.view import View

PANEL_WIDTH_CM = 7.0  # at least
PAGE_CM = 23.0  # what a journal leaves of a page for a picture
FOOT_CM = 2.0  # axis label and legend below the panels


def in_columns(count: int, view: View, panel_cm: float = PANEL_WIDTH_CM) -> int:
    """How many of `count` panels, so wide at least, go into a row."""
    return min(count, max(1, int(view.width_cm // panel_cm)))


def spread_over(items: Sequence[Any], most: int) -> list[Any]:
    """At most so many of the items, evenly spread from the first to the last."""
    places = np.linspace(0, len(items) - 1, max(min(most, len(items)), 1))
    return [items[round(place)] for place in places]


@dataclass(frozen=True)
class CurvePanels:
    """Panels of their own for the curves of a sweep, as many as a page has room for.

    Attributes
    ----------
    figure : the figure
    drawn : the curves shown (n)
    panels : one below the other for each curve, (n, rows)
    omitted : words about curves left out; empty for none
    """

    figure: Figure
    drawn: list[Curve]
    panels: np.ndarray
    omitted: str

    @property
    def top_right(self) -> Axes:
        """The last panel of the upper row, for remarks."""
        columns = len({axes.get_subplotspec().colspan.start for axes in self.panels[:, 0]})
        axes: Axes = self.panels[columns - 1, 0]
        return axes


def curve_panels(
    curves: Sequence[Curve],
    view: View,
    heights_cm: Sequence[float],
    panel_cm: float = PANEL_WIDTH_CM,
    margins_cm: float = FOOT_CM,
) -> CurvePanels:
    """Panels for the curves, each with rows of these heights; axes are shared, curves named above them."""
    columns, rows = in_columns(len(curves), view, panel_cm), len(heights_cm)
    drawn = _as_many(curves, columns * max(1, int((PAGE_CM - margins_cm) / sum(heights_cm))))
    columns = min(columns, len(drawn))
    blocks = -(-len(drawn) // columns)
    figure = sheet(view, blocks * sum(heights_cm) + margins_cm)
    ratios = {"height_ratios": list(heights_cm) * blocks}
    grid = figure.subplots(blocks * rows, columns, squeeze=False, sharex=True, gridspec_kw=ratios)
    stacked = grid.reshape(blocks, rows, columns).transpose(0, 2, 1).reshape(-1, rows)
    for axes in stacked[len(drawn) :].ravel():
        axes.remove()
    panels = stacked[: len(drawn)]
    for row in panels.T:
        for i, axes in enumerate(row):
            axes.sharey(row[0]) if i else None
            axes.tick_params(labelleft=i % columns == 0)
    for i in range(max(0, len(drawn) - columns), len(drawn)):
        panels[i, -1].tick_params(labelbottom=True)
    for axes, curve in zip(panels[:, 0], drawn, strict=True):
        axes.set_title(curve.label, loc="left", pad=3, fontsize=points(7), gid="curve")
    letter_panels(list(panels.ravel()))
    left_out = f"{len(drawn)} of {len(curves)} curves" if len(drawn) < len(curves) else ""
    return CurvePanels(figure, drawn, panels, left_out)


def _as_many(curves: Sequence[Curve], most: int) -> list[Curve]:
    """At most so many of the curves, evenly spread, up and down of a family together."""
    together = families(curves)
    size = max(map(len, together))
    return [curve for family in spread_over(together, max(most // size, 1)) for curve in family]


def label_outer(panels: np.ndarray, x_label: str, y_labels: Sequence[str]) -> None:
    """Label what stands at the left and at the foot of panels (n, rows) of curves."""
    columns = len({axes.get_subplotspec().colspan.start for axes in panels[:, 0]})
    for axes in panels[-columns:, -1]:
        axes.set_xlabel(x_label)
    for stack in panels[::columns]:
        for axes, label in zip(stack, y_labels, strict=True):
            axes.set_ylabel(label)


def finish(grid: np.ndarray, count: int, x_label: str, y_label: str) -> None:
    """Take away the panels beyond `count` and label the axes at the left and at the foot of a grid (n, m)."""
    columns = grid.shape[1]
    for axes in grid.flat[count:]:
        axes.remove()
    for axes in grid.flat[max(0, count - columns) : count]:
        axes.set_xlabel(x_label)
        axes.tick_params(labelbottom=True)
    for axes in grid.flat[:count:columns]:
        axes.set_ylabel(y_label)

"""Panels beside and below each other, as many in a row as the width of the picture allows."""

from __future__ import annotations

import numpy as np

from vibsim.plots.view import View

PANEL_WIDTH_CM = 7.0  # at least


def in_columns(count: int, view: View) -> int:
    """How many of `count` panels go into a row."""
    return min(count, max(1, int(view.width_cm // PANEL_WIDTH_CM)))


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

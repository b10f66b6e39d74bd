"""Axes of the user's, in the place of a figure that a kind of picture would make for itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.errors import PlotError


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

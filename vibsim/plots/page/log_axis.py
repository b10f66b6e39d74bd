"""Logarithmic axes whose ticks are plain numbers, few enough to stand beside each other."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from vibsim.cases.number import number

WIDE = 2.0  # decades from which powers of ten are enough
SHORT = 0.5  # decades below which ticks are as on a linear axis
MOST = 6  # ticks of what is shorter


def draw_by_ratio(axes: Axes, which: str) -> None:
    """Make the axis x or y logarithmic."""
    axes.set(**{f"{which}scale": "log"})
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_major_locator(Powers())
    axis.set_major_formatter(FuncFormatter(lambda value, _: number(value, 6)))
    axis.set_minor_formatter(NullFormatter())


class Powers(LogLocator):
    """Ticks at 1, 10, 100 ..., at 1, 2, 5, 10 ... of few decades, at equal steps of a short range."""

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        """Places of the ticks in a range."""
        if not 0 < vmin < vmax:
            return list(super().tick_values(vmin, vmax))
        decades = math.log10(vmax / vmin)
        if decades < SHORT:
            return [x for x in MaxNLocator(MOST, steps=[1, 2, 5, 10]).tick_values(vmin, vmax) if x > 0]
        self.set_params(subs=(1.0,) if decades >= WIDE else (1.0, 2.0, 5.0))
        return list(super().tick_values(vmin, vmax))

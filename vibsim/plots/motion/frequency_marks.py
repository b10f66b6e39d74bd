"""Natural frequencies on a frequency axis: a thin line through every panel, the name above the first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.motion.natural_frequencies import Frequency
from vibsim.plots.page.margin_labels import FONT_SIZE, LINE_HEIGHT, spread
from vibsim.plots.style import GREY, points

NAME_PT = 8  # names above the axes
TITLE_PT = 9  # and above a title


def mark_frequencies(panels: Sequence[Axes], frequencies: Sequence[Frequency], width_pt: float) -> None:
    """Mark the frequencies within the x limits.

    Titles of the panels come before it.

    width_pt : width of the axes [pt], as far as it is known before layout
    """
    low, high = panels[0].get_xlim()
    inside = sorted((f for f in frequencies if low <= f.hz <= high), key=lambda f: f.hz)
    at = np.array([(f.hz - low) / (high - low) for f in inside])
    places = spread(at, points(FONT_SIZE) * LINE_HEIGHT / width_pt)
    titles = [panels[0].get_title(loc) for loc in ("left", "right")]
    above = NAME_PT + TITLE_PT * max(len(title.split("\n")) if title else 0 for title in titles)
    for frequency, x, place in zip(inside, at, places, strict=True):
        for axes in panels:
            axes.axvline(
                frequency.hz, color=GREY, linewidth=0.5, linestyle=(0, (4, 2)), zorder=1, gid="frequency"
            )
        panels[0].annotate(
            f"{frequency.label}  {frequency.hz:.2f}", (x, 1.0), (place, above),
            xycoords="axes fraction", textcoords=("axes fraction", "offset points"),
            ha="center", va="bottom", rotation=90, fontsize=points(FONT_SIZE), color="0.25",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": GREY, "shrinkA": 1, "shrinkB": 0},
        )  # fmt: skip

"""Labelled levels: horizontal lines across the axes, their names in the right margin, none upon another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.style import GREY, points

LINE_HEIGHT = 1.25  # of a label, in font sizes
FONT_SIZE = 6.5


@dataclass(frozen=True)
class Level:
    """A level of the y axis and its name."""

    value: float
    label: str
    look: dict[str, Any]


def draw_levels(axes: Axes, levels: Sequence[Level], height_pt: float, named: bool = True) -> None:
    """Draw the levels within the y limits, their names in the margin, moved apart where they would collide.

    height_pt : height of the axes [pt], as far as it is known before layout
    named : whether to write their names
    """
    low, high = axes.get_ylim()
    inside = sorted((level for level in levels if low <= level.value <= high), key=lambda level: level.value)
    heights = np.array([(level.value - low) / (high - low) for level in inside])
    places = spread(heights, points(FONT_SIZE) * LINE_HEIGHT / height_pt)
    for level, height, place in zip(inside, heights, places, strict=True):
        axes.axhline(
            level.value, **{"color": GREY, "linewidth": 0.5, "zorder": 2.95, "gid": "level", **level.look}
        )
        if not named:
            continue
        axes.annotate(
            level.label, (1.0, height), (8, place),
            xycoords="axes fraction", textcoords=("offset points", "axes fraction"),
            ha="left", va="center", fontsize=points(FONT_SIZE), color="0.25",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": GREY, "shrinkA": 1, "shrinkB": 0},
        )  # fmt: skip


def spread(heights: np.ndarray, gap: float) -> np.ndarray:
    """Places (n) for labels at ascending heights (n), `gap` apart or more, as near as that allows.

    Neighbours too close together form a group centred on its members (pool adjacent violators).
    """
    groups: list[tuple[float, int]] = []  # (mean of height minus own offset, members): where the group starts
    for height in heights:
        groups.append((float(height), 1))
        while len(groups) > 1 and groups[-2][0] + groups[-2][1] * gap > groups[-1][0]:
            (lower, n), (upper, m) = groups[-2:]
            groups[-2:] = [((n * lower + m * (upper - n * gap)) / (n + m), n + m)]
    return np.array([start + i * gap for start, members in groups for i in range(members)])

"""The relative motion of the blocks, and the stop in its plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.quantities import Scale
from vibsim.plots.style import GREY
from vibsim.plots.trace import Block

DISPLACEMENT = "$x_1 - x_2$"
VELOCITY = "$v_1 - v_2$"


def state_names(scene: Any) -> tuple[str, ...]:
    """Columns that the relative motion needs; a fixed block 2 has none."""
    return ("x1", "v1", "x2", "v2") if scene.has_block2 else ("x1", "v1")


def relative(block: Block) -> tuple[np.ndarray, np.ndarray]:
    """Relative displacement x1 - x2 [m] and velocity v1 - v2 [m/s], block 2 at rest or moving."""
    if "x2" not in block:
        return block["x1"], block["v1"]
    return block["x1"] - block["x2"], block["v1"] - block["v2"]


def stop_position(scene: Any) -> float:
    """The relative displacement x1 - x2 at which the stop is met [m]: -G in extension, +G in compression."""
    return -scene.stop_sign * scene.G


def draw_stop(axes: Axes, scene: Any, scale: Scale, label: bool = True) -> None:
    """The stop of two blocks as a dashed line across the axes, its equation above it."""
    draw_stop_line(axes, stop_position(scene), scale, stop_equation(scene) if label else "")


def stop_equation(scene: Any) -> str:
    """Where the stop of two blocks is met, as an equation."""
    return "$x_2 - x_1 = G$" if scene.stop_sign > 0 else "$x_1 - x_2 = G$"


def draw_stop_line(axes: Axes, position: float, scale: Scale, text: str) -> None:
    """A stop at a relative displacement [m] as a dashed line across the axes, a text above it."""
    at = float(scale(position))
    axes.axvline(at, color=GREY, linewidth=0.6, linestyle=(0, (4, 2)), zorder=0, gid="stop")
    if text:
        axes.annotate(
            text, (at, 1), (0, 2), xycoords=("data", "axes fraction"), textcoords="offset points",
            ha="center", va="bottom", fontsize=7, color=GREY,
        )  # fmt: skip

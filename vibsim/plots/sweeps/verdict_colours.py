"""Verdicts as colours: a class for each, a colour for each class, and their legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibsim.plots.page.sheet import legend_below
from vibsim.plots.sweeps.axes import shown
from vibsim.plots.sweeps.plane import Plane
from vibsim.plots.view import View

FEW = 400  # points that a panel holds at full size


@dataclass(frozen=True)
class Shade:
    """One class of a verdict: its name and colour."""

    name: str
    colour: str


def lay_classes(axes: Axes, plane: Plane, classes: np.ndarray, shades: Sequence[Shade], gid: str) -> None:
    """Colour cells by their class (n_up, n_across), an index into `shades`; NaN stays blank."""
    colours = ListedColormap([shade.colour for shade in shades])
    plane.lay(axes, classes, cmap=colours, vmin=-0.5, vmax=len(shades) - 0.5, gid=gid)


def scatter_classes(
    axes: Axes, x: np.ndarray, y: np.ndarray, classes: np.ndarray, shades: Sequence[Shade], view: View
) -> None:
    """Points (n) coloured by their class (n), an index into `shades`; many are drawn small."""
    size = float(np.clip(3.0 * (FEW / max(len(x), 1)) ** 0.5, 0.8, 3.0))
    for code, shade in enumerate(shades):
        of = classes == code
        axes.plot(
            x[of], y[of], linestyle="none", marker="o", markersize=size, color=shade.colour,
            markeredgecolor="0.3", markeredgewidth=min(0.3, size / 10), gid=shade.name,
        )  # fmt: skip
    axes.margins(x=0.03, y=0.06)
    axes.set_xlim(*shown(*axes.get_xlim(), view))


def legend_of(figure: Figure, shades: Sequence[Shade], classes: np.ndarray) -> None:
    """The legend of the classes that occur, with how many points each has."""
    known = classes[~np.isnan(classes)].astype(int)
    counts = np.bincount(known, minlength=len(shades))
    shown = [(shade, count) for shade, count in zip(shades, counts, strict=True) if count]
    if shown:
        patches = [Patch(facecolor=shade.colour, edgecolor="0.3", linewidth=0.4) for shade, _ in shown]
        legend_below(figure, patches, [f"{shade.name} ({count})" for shade, count in shown], handlelength=1.2)

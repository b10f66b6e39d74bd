"""Verdicts as colours: a class for each, a colour for each class, and their legend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from vibsim.plots.page.sheet import legend_below
from vibsim.plots.sweeps.axes import shown
from vibsim.plots.sweeps.plane import Plane
from vibsim.plots.view import View

FEW = 400  # points that a panel holds at full size
LIGHT = 0.75  # grey from which a point on white paper needs an edge
HATCHES = "0.25"  # their colour


def grey_of(colour: str) -> float:
    """The grey in which a colour prints, from 0 (black) to 1 (ITU-R BT.601)."""
    return float(np.dot(to_rgb(colour), (0.299, 0.587, 0.114)))


@dataclass(frozen=True)
class Shade:
    """One class of a verdict: its name, its colour, and hatches where its grey is that of another class."""

    name: str
    colour: str
    hatch: str = ""

    @property
    def edge(self) -> str:
        """The colour of the edge of a point: light ones have one."""
        return "0.3" if grey_of(self.colour) > LIGHT else "none"


def lay_classes(axes: Axes, plane: Plane, classes: np.ndarray, shades: Sequence[Shade], gid: str) -> None:
    """Colour and hatch cells by their class (n_up, n_across), an index into `shades`; NaN stays blank."""
    colours = ListedColormap([shade.colour for shade in shades])
    plane.lay(axes, classes, cmap=colours, vmin=-0.5, vmax=len(shades) - 0.5, gid=gid)
    for code, shade in enumerate(shades):
        if shade.hatch and np.any(classes == code):
            _hatch(axes, plane, classes == code, shade)


def _hatch(axes: Axes, plane: Plane, cells: np.ndarray, shade: Shade) -> None:
    x, y = plane.spans()
    boxes = [
        Path([(x[i, a], y[k, b]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))])
        for k, i in np.argwhere(cells)
    ]
    look: dict[str, Any] = {
        "facecolor": "none",
        "edgecolor": HATCHES,
        "hatch": shade.hatch,
        "linewidth": 0,
        "zorder": 0.6,
    }
    axes.add_patch(PathPatch(Path.make_compound_path(*boxes), gid=f"hatch {shade.name}", **look))


def scatter_classes(
    axes: Axes, x: np.ndarray, y: np.ndarray, classes: np.ndarray, shades: Sequence[Shade], view: View
) -> None:
    """Points (n) coloured by their class (n), an index into `shades`; many are drawn small."""
    size = float(np.clip(3.0 * (FEW / max(len(x), 1)) ** 0.5, 0.8, 3.0))
    for code, shade in enumerate(shades):
        of = classes == code
        axes.plot(
            x[of], y[of], linestyle="none", marker="o", markersize=size, color=shade.colour,
            markeredgecolor=shade.edge, markeredgewidth=min(0.3, size / 10), gid=shade.name,
        )  # fmt: skip
    axes.margins(x=0.03, y=0.06)
    axes.set_xlim(*shown(*axes.get_xlim(), view))


def legend_of(figure: Figure, shades: Sequence[Shade], classes: np.ndarray) -> None:
    """The legend of the classes that occur, with how many points each has."""
    known = classes[~np.isnan(classes)].astype(int)
    counts = np.bincount(known, minlength=len(shades))
    shown = [(shade, count) for shade, count in zip(shades, counts, strict=True) if count]
    if shown:
        edge: dict[str, Any] = {"edgecolor": HATCHES, "linewidth": 0.4}
        patches = [Patch(facecolor=shade.colour, hatch=shade.hatch, **edge) for shade, _ in shown]
        legend_below(figure, patches, [f"{shade.name} ({count})" for shade, count in shown], handlelength=1.2)

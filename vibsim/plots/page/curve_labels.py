"""Names written beside curves, each where it covers no curve and no other name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from vibsim.plots.style import points

FONT_SIZE = 6.5
APART = 4.0  # pt between a point and its curve's name
CLEARANCE = 2.5  # pt around a curve that no name may touch
ALIGNMENTS = (  # horizontal, vertical: where the name stands from the point, the better first
    ("left", "center"), ("left", "top"), ("left", "bottom"),
    ("center", "top"), ("center", "bottom"), ("right", "center"), ("right", "top"), ("right", "bottom"),
)  # fmt: skip
SIDE = {"left": 1.0, "center": 0.0, "right": -1.0, "bottom": 1.0, "top": -1.0}


@dataclass(frozen=True)
class Named:
    """A curve in data coordinates (n), the end that its name belongs to first; what its name looks like."""

    name: str
    x: np.ndarray
    y: np.ndarray
    look: dict[str, Any] = field(default_factory=dict)


def write_names(axes: Axes, curves: Sequence[Named]) -> None:
    """Write the names, beside what is written on the axes already. Limits and scales must be final."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.draw_without_rendering()
    clear = CLEARANCE * figure.dpi / 72
    covered = [Bbox(np.array([at - clear, at + clear])) for curve in curves for at in _along(axes, curve)]
    covered += [text.get_window_extent() for text in axes.texts]  # of an annotation, arrow included
    for curve in curves:
        box = _write(axes, curve, covered)
        covered.append(box)


def _write(axes: Axes, curve: Named, covered: Sequence[Bbox]) -> Bbox:
    """Try every place; the first that is free, else the first."""
    tried: list[tuple[Any, Bbox]] = []
    for x, y in zip(curve.x, curve.y, strict=True):
        for across, along in ALIGNMENTS:
            text = axes.annotate(
                curve.name, (x, y), (APART * SIDE[across], APART * SIDE.get(along, 0.0)),
                textcoords="offset points", ha=across, va=along,
                **{"fontsize": points(FONT_SIZE), "gid": "name", **curve.look},
            )  # fmt: skip
            box = text.get_window_extent()
            if _inside(box, axes.bbox) and not _overlaps(box, covered):
                for other, _ in tried:
                    other.remove()
                return box
            tried.append((text, box))
    for other, _ in tried[1:]:
        other.remove()
    return tried[0][1]


def _along(axes: Axes, curve: Named) -> np.ndarray:
    """Points along the polygon of a curve, in pixels (m, 2)."""
    corners = axes.transData.transform(np.column_stack([curve.x, curve.y]))
    parts = [np.linspace(a, b, 30) for a, b in pairwise(corners)]
    return np.concatenate([corners[:1], *parts])


def _inside(box: Bbox, frame: Bbox) -> bool:
    return bool(box.x0 > frame.x0 and box.x1 < frame.x1 and box.y0 > frame.y0 and box.y1 < frame.y1)


def _overlaps(box: Bbox, others: Iterable[Bbox]) -> bool:
    return any(box.overlaps(other) for other in others)

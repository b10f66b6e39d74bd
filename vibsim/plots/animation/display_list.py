"""A drawing whose every vertex moves along with a few channels: bodies, base, stops, rotor.

    vertex = start + sum of coefficient * channel

The drawing is made once with all channels at 0 and once with each at 1, and the differences are the
coefficients. Films and pages draw from the same list.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.patches import Circle, FancyBboxPatch, Rectangle

ROUND = np.linspace(0, 2 * np.pi, 25)  # corners of a circle


@dataclass(frozen=True)
class Shape:
    """One line, area, arrow or text.

    Attributes
    ----------
    kind : "line", "area", "arrow" or "text"
    vertices : (n, 2) [cm]
    look : colour, fill, width [pt], dash, text, size [pt], align
    key : dotted key of the part that it belongs to, or empty
    """

    kind: str
    vertices: np.ndarray
    look: dict[str, Any]
    key: str = ""


@dataclass
class Recorder:
    """Takes the place of axes: what is drawn on it is kept as shapes."""

    shapes: list[Shape] = field(default_factory=list)

    def plot(self, x: Any, y: Any, gid: str | None = None, **look: Any) -> None:
        """A line through points."""
        own = {"colour": to_hex(look["color"]), "width": look["linewidth"]}
        own["dash"] = bool(look.get("linestyle"))
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        self.shapes.append(Shape("line", np.column_stack([x, y]), own, gid or ""))

    def add_patch(self, patch: Any) -> None:
        """An area with an edge."""
        look = {
            "fill": to_hex(patch.get_facecolor()) if patch.get_fill() else "",
            "colour": to_hex(patch.get_edgecolor()),
            "width": patch.get_linewidth(),
            "hatch": bool(patch.get_hatch()),
        }
        self.shapes.append(Shape("area", _corners(patch), look, patch.get_gid() or ""))

    def text(self, x: float, y: float, text: str, **look: Any) -> None:
        """A text at a point."""
        own = {name: look.get(name, "") for name in ("ha", "weight", "style")}
        own |= {"text": text, "size": look["fontsize"], "colour": to_hex(look["color"])}
        self.shapes.append(Shape("text", np.array([[x, y]], float), own))

    def annotate(self, text: str, xy: Any, xytext: Any, arrowprops: dict[str, Any], **_: Any) -> Any:
        """An arrow from a place to another."""
        look = {"colour": to_hex(arrowprops["color"]), "width": arrowprops["linewidth"]}
        look |= {"both": arrowprops["arrowstyle"].startswith("<")}
        self.shapes.append(Shape("arrow", np.array([xytext, xy], float), look))
        return _Named()


class _Named:
    def set_gid(self, gid: str | None) -> None:
        """Arrows need no name."""


def _corners(patch: Any) -> np.ndarray:
    if isinstance(patch, Circle):
        x, y = patch.center
        return np.column_stack([x + patch.radius * np.cos(ROUND), y + patch.radius * np.sin(ROUND)])
    assert isinstance(patch, Rectangle | FancyBboxPatch)
    x, y, width, height = patch.get_x(), patch.get_y(), patch.get_width(), patch.get_height()
    return np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height], [x, y]])


@dataclass(frozen=True)
class Moving:
    """A shape and how it moves: coefficients (channels, n, 2) by which its vertices follow the channels."""

    shape: Shape
    coefficients: np.ndarray

    def at(self, channels: np.ndarray) -> np.ndarray:
        """Vertices (n, 2) [cm] for the values of the channels."""
        return self.shape.vertices + np.tensordot(channels, self.coefficients, axes=1)


def moving_shapes(draw: Callable[[Recorder, np.ndarray], None], count: int) -> list[Moving]:
    """The display list of what `draw` draws for the values of `count` channels, to which it is linear.

    Raises ValueError where it draws different shapes for different values.
    """
    still = _recorded(draw, np.zeros(count))
    moved = [_recorded(draw, unit) for unit in np.eye(count)]
    if any([shape.vertices.shape for shape in each] != [s.vertices.shape for s in still] for each in moved):
        raise ValueError("the drawing has different shapes for different positions")
    return [
        Moving(shape, np.array([each[i].vertices - shape.vertices for each in moved]))
        for i, shape in enumerate(still)
    ]


def _recorded(draw: Callable[[Recorder, np.ndarray], None], channels: np.ndarray) -> Sequence[Shape]:
    recorder = Recorder()
    draw(recorder, channels)
    return recorder.shapes

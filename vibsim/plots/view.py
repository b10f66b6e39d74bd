"""What the user asked to see: window, detail, width."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

Span = tuple[float, float]

WIDTHS_CM = {"column": 8.6, "page": 17.8}
PAGE_FROM_CM = 14.0  # width from which panels stand side by side
SMALLEST_CM, LARGEST_CM = 3.0, 120.0


@dataclass(frozen=True)
class View:
    """How to look at the subjects.

    Attributes
    ----------
    window : first and last instant [s], or None: what suits the kind
    detail : the span enlarged in time histories [s], or None: the last seconds with impacts
    width : "column" (8.6 cm), "page" (17.8 cm), or None: what suits the kind
    size_cm : width and height [cm] of the picture, or None: what suits the kind
    x, y : the two columns that are drawn against each other, in the place of a kind
    canvas : what makes a figure, called as `matplotlib.figure.Figure` is; None: that
    poincare : whether phase portraits carry the points at which the periods of the source end
    """

    window: Span | None = None
    detail: Span | None = None
    width: str | None = None
    size_cm: tuple[float, float] | None = None
    x: str | None = None
    y: str | None = None
    canvas: Callable[..., Any] | None = None
    poincare: bool = False

    @property
    def width_cm(self) -> float:
        return self.size_cm[0] if self.size_cm else WIDTHS_CM[self.width or "column"]

    def for_kind(self, width: str) -> View:
        """The view, with the width that suits the kind unless the user says otherwise."""
        if self.size_cm:
            return replace(self, width="page" if self.size_cm[0] >= PAGE_FROM_CM else "column")
        return replace(self, width=self.width or width)


def parse_size(text: str) -> tuple[float, float]:
    """`12x8` as width and height [cm]. Raises PlotError."""
    width, times, height = text.lower().partition("x")
    try:
        size = float(width), float(height)
    except ValueError:
        size = (math.nan, math.nan)
    if not times or not all(SMALLEST_CM <= length <= LARGEST_CM for length in size):
        allowed = f"each {SMALLEST_CM:g} to {LARGEST_CM:g} cm"
        raise PlotError(f"{text!r} is no size: write WIDTHxHEIGHT in cm, such as 12x8, {allowed}")
    return size


def parse_span(text: object) -> Span:
    """`100:110`, `:20`, `100:` or (100, 110) as (first, last) [s], an open end infinite. Raises PlotError."""
    from vibsim.results.result import read_window

    try:
        return read_window(text)
    except ValueError as error:
        raise PlotError(str(error)) from None


# What a user can get wrong about a picture.


class PlotError(Exception):
    """One line, ready to print: an unknown or unfit kind, a window outside the run, an unknown suffix.

    >>> import vibsim
    >>> try:
    ...     vibsim.plot("II-B", "phase-portrait")
    ... except vibsim.PlotError as error:
    ...     print(str(error).partition(":")[0])
    unknown kind 'phase-portrait'
    """

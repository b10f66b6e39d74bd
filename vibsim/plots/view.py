"""What the user asked to see: window, detail, width."""

from __future__ import annotations

import math
from dataclasses import dataclass

from vibsim.plots.errors import PlotError

Span = tuple[float, float]

WIDTHS_CM = {"column": 8.6, "page": 17.8}


@dataclass(frozen=True)
class View:
    """How to look at the subjects.

    Attributes
    ----------
    window : first and last instant [s], or None: what suits the kind
    detail : the span enlarged in time histories [s], or None: the last seconds with impacts
    width : "column" (8.6 cm), "page" (17.8 cm), or None: what suits the kind
    """

    window: Span | None = None
    detail: Span | None = None
    width: str | None = None

    @property
    def width_cm(self) -> float:
        return WIDTHS_CM[self.width or "column"]


def parse_span(text: str) -> Span:
    """`100:110`, `:20` or `100:` as (first, last) [s]; an open end is infinite. Raises PlotError."""
    first, colon, last = text.partition(":")
    try:
        span = (float(first) if first.strip() else -math.inf, float(last) if last.strip() else math.inf)
    except ValueError:
        span = (math.nan, math.nan)
    if not colon or math.isnan(span[0]) or math.isnan(span[1]):
        raise PlotError(f"{text!r} is not a span: write FIRST:LAST in seconds, such as 100:110")
    if not span[0] < span[1]:
        raise PlotError(f"the span {text} is empty: its first instant must come before its last")
    return span

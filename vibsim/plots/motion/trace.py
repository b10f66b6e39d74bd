"""Curves in a plane of state variables, honest about what is drawn and small on the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.plots.motion.dense import dense
from vibsim.plots.motion.impacts import impacts_of
from vibsim.plots.motion.samples import blocks, rows, samples
from vibsim.plots.motion.thinning import one_per_pixel
from vibsim.plots.page.quantities import Scale
from vibsim.plots.page.sheet import above_wider
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span

Block = Mapping[str, np.ndarray]
Plane = Callable[[Block], tuple[np.ndarray, np.ndarray]]

SMOOTH_UP_TO = 20_000  # samples: a span up to this gets instants between its samples
LINE_UP_TO = 200_000  # samples: up to this a line joins them; beyond, one dot per pixel
VECTOR_UP_TO = 20_000  # points: larger ones are pixels in a PDF or SVG, at 600 dpi
RINGS_UP_TO = 60  # impacts marked by rings; more by dots


@dataclass(frozen=True)
class Trace:
    """Points (x, y), each (n), SI; joined by a line, or the dots of a long run."""

    x: np.ndarray
    y: np.ndarray
    joined: bool


def trace(result: Any, names: tuple[str, ...], plane: Plane, span: Span) -> Trace:
    """The run within the span as seen in a plane.

    Parameters
    ----------
    names : the columns that `plane` needs
    plane : maps columns by name to (x, y)
    """
    within = rows(result, span)
    count = within.stop - within.start
    if count <= SMOOTH_UP_TO:
        return Trace(*plane(dense(result, names, span)), joined=True)
    if count <= LINE_UP_TO:
        return Trace(*plane(samples(result, names, span)), joined=True)
    return Trace(
        *one_per_pixel(lambda: (plane(block) for block in blocks(result, names, span))), joined=False
    )


def impact_points(subject: Subject, names: tuple[str, ...], plane: Plane, span: Span) -> Trace:
    """The states of a body at which contact begins within the span, in the same plane."""
    columns = tuple(name for name in names if name != "time")
    t, *values = impacts_of(subject, span, *columns)
    return Trace(*plane({"time": t, **dict(zip(columns, values, strict=True))}), joined=False)


def draw_trace(axes: Axes, drawn: Trace, scales: tuple[Scale, Scale], **look: Any) -> None:
    """Draw a trace; one with many points is rasterized in vector files."""
    if not drawn.joined:
        look = {**look, "linestyle": "none", "marker": ",", "markersize": 0.5}
    x, y = scales[0](drawn.x), scales[1](drawn.y)
    look.setdefault("zorder", above_wider(x))
    axes.plot(x, y, rasterized=len(x) > VECTOR_UP_TO, **{"linewidth": 0.5, **look})


def draw_impacts(axes: Axes, impacts: Trace, scales: tuple[Scale, Scale], colour: Any) -> None:
    """Mark impacts on a trace: rings, or dots where they are many."""
    few = len(impacts.x) <= RINGS_UP_TO
    axes.plot(
        scales[0](impacts.x), scales[1](impacts.y), linestyle="none", marker="o", zorder=3,
        markersize=2.4 if few else 1.4, markeredgewidth=0.5 if few else 0, color=colour if few else "black",
        markerfacecolor="white" if few else "black", gid="impacts",
    )  # fmt: skip

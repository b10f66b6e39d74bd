"""Where in the plane of J and c the motors do what the paper says of them."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.cases.values.quantities import parse_quantity
from vibsim.evidence.reports.measured.measurements import Numbers
from vibsim.plots.fit import scatter_shares
from vibsim.plots.page.sheet import sheet
from vibsim.plots.view import View

KEYS = ("excitation.J", "coupling.c")
DIMENSIONS = {"excitation.J": "inertia", "coupling.c": "damping"}
PANELS = (
    ("II-B captured for good", (0,)),
    ("II-C held, away in time, ends at 6.2 Hz", (1, 2, 3)),
)
Point = tuple[float, float]  # J in g m^2, c in N s/m


def draw_search(plane: Numbers, printed: Point, reading: Point) -> Figure:
    """Share of the starts from which statements hold, at every point; printed: cross, reading: ring.

    plane : of `parameter_search.search_plane`. Of several statements the least share counts.
    """
    figure = sheet(View(width="page"), 8.2)
    panels = figure.subplots(1, len(PANELS), sharex=True, sharey=True)
    for axes, (title, statements) in zip(panels, PANELS, strict=True):
        places, shares = points_of(plane["ranking"], statements)
        scatter_shares(axes, places, shares, "Share of starts")
        _mark(axes, printed, reading)
        axes.set(xscale="log", yscale="log", xlabel="Moment of inertia $J$ (g m²)", title=title)
    panels[0].set_ylabel("Damping $c$ (N s/m)")
    return figure


def points_of(ranking: Sequence[Numbers], statements: Sequence[int]) -> tuple[list[Point], list[float]]:
    """Places of the candidates that change both numbers, and the least share of the statements there."""
    moved = [row for row in ranking if all(key in row["changes"] for key in KEYS)]
    places = [place_of(row["changes"]) for row in moved]
    return places, [min(_share(row, each) for each in statements) for row in moved]


def place_of(changes: Numbers) -> Point:
    """J [g m^2] and c [N s/m] of changes in the units of a case."""
    inertia, damping = (parse_quantity(changes[key], DIMENSIONS[key]).number() for key in KEYS)
    return 1e3 * inertia, damping


def _share(row: Numbers, statement: int) -> float:
    counts = row["statements"][statement]
    return float(counts["count"] / counts["of"])


def _mark(axes: Axes, printed: Point, reading: Point) -> None:
    axes.plot(*printed, "x", color="black", markersize=7, markeredgewidth=1.4, clip_on=False)
    axes.plot(*reading, "o", color="black", markersize=9, markerfacecolor="none", markeredgewidth=1.4)

"""Where in the plane of m3 and c the motors are captured, and for how long."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibsim.plots.sheet import sheet
from vibsim.plots.style import BLUE, GREEN, ORANGE, SKY
from vibsim.plots.view import View
from vibsim.reports.claims_of_capture import RESONANT_HZ
from vibsim.reports.claims_of_escape import ABOUT_100
from vibsim.reports.measurements import Numbers
from vibsim.reports.parameter_search import TOGETHER

PASSED, BRIEF, ABOUT, LONG, CAPTURED = range(5)
CLASSES = {
    PASSED: ("passes", "0.92"),
    BRIEF: (f"held 30 to {ABOUT_100[0]:.0f} s, then escapes", SKY),
    ABOUT: (f"held {ABOUT_100[0]:.0f} to {ABOUT_100[1]:.0f} s, then escapes", ORANGE),
    LONG: ("held longer, then escapes", GREEN),
    CAPTURED: ("captured to the end", BLUE),
}
BRIEF_FROM = 30.0  # [s]


def draw_search(rows: Sequence[Numbers], names: Sequence[str], readings: Numbers) -> Figure:
    """A map for each case, the printed parameters a cross, the readings a ring.

    rows : the grid of `parameter_search.search_together`; readings : m3 and c by key
    """
    figure = sheet(View(width="page"), 8.2)
    panels = figure.subplots(1, len(names), squeeze=False)[0]
    for axes, name in zip(panels, names, strict=True):
        _map(axes, rows, name)
        axes.plot(*readings["printed"], "x", color="black", markersize=6, markeredgewidth=1.4)
        axes.plot(
            *readings["reading"],
            "o",
            color="black",
            markersize=7,
            markerfacecolor="none",
            markeredgewidth=1.4,
        )
        axes.set_title(name, fontsize=8, fontweight="bold")
    handles = [
        Patch(facecolor=colour, edgecolor="0.5", linewidth=0.4, label=label)
        for label, colour in CLASSES.values()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def class_of(outcome: Numbers) -> int:
    """Which of CLASSES a run belongs to."""
    if outcome.get("since") is None or outcome["speed_hz"] > RESONANT_HZ:
        return PASSED
    if outcome["until"] is None:
        return CAPTURED if outcome["verdict"] == "captured" else PASSED
    held = outcome["until"] - outcome["since"]
    if held < BRIEF_FROM or outcome["verdict"] != "escaped":
        return PASSED
    return BRIEF if held < ABOUT_100[0] else ABOUT if held <= ABOUT_100[1] else LONG


def _map(axes: Axes, rows: Sequence[Numbers], name: str) -> None:
    first, second = TOGETHER
    m3, c = np.array(first.values), np.array(second.values)
    found = {(row["at"][first.key], row["at"][second.key]): class_of(row[name]) for row in rows}
    classes = np.array([[found[a, b] for a in first.values] for b in second.values])
    colours: Any = ListedColormap([colour for _, colour in CLASSES.values()])
    axes.pcolormesh(
        1e3 * edges(m3), geometric_edges(c), classes, cmap=colours, norm=BoundaryNorm(range(6), 5),
        edgecolors="white", linewidth=0.3,
    )  # fmt: skip
    axes.set_yscale("log")
    axes.set_xlabel("Unbalanced mass $m_3$ (g)")
    axes.set_ylabel("Damping $c$ (N s/m)")


def edges(centres: np.ndarray) -> np.ndarray:
    """Borders (n + 1) halfway between ascending values (n)."""
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


def geometric_edges(centres: np.ndarray) -> np.ndarray:
    """The same by ratio."""
    return np.exp(edges(np.log(centres)))

"""Pictures that decide a claim: drift over ensembles, holds and escapes, regimes beside Table 1."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibsim.evidence.reports.claims.claim import Numbers
from vibsim.evidence.reports.claims.evidence import members
from vibsim.evidence.reports.claims.of_capture import NATURAL_HZ
from vibsim.evidence.reports.claims.of_escape import ABOUT_100, JUMPED_HZ
from vibsim.evidence.reports.measured.paper_runs import EQUAL_FORCE, MOTORS, PRINTED, READINGS
from vibsim.evidence.reports.measured.regimes_nearby import DAMPINGS, FREQUENCIES, LAWS
from vibsim.plots.page.sheet import legend_below, sheet
from vibsim.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, SHADE, SKY, VERMILLION
from vibsim.plots.view import View

PAGE = View(width="page")
SLOWEST = 1e-3  # [mm/s] less is drawn here: 0.3 mm in 300 s
SIDEWAYS = 0.28  # half width of a cloud of points, in the distance of two cases
KINDS = {
    "periodic": "0.85", "transient": SKY, "quasi-periodic": ORANGE, "chaotic": VERMILLION, "undecided": BLACK,
}  # fmt: skip
CAPTURED = ("II-B", "II-C", *READINGS)
COLOURS = dict(zip(CAPTURED, (BLUE, ORANGE, GREEN, VERMILLION), strict=True))
RING: dict[str, Any] = {"color": BLACK, "markersize": 5, "markerfacecolor": "none", "markeredgewidth": 1.0}
CROSS: dict[str, Any] = {"color": BLACK, "markersize": 5, "markeredgecolor": "white", "markeredgewidth": 0.6}
SOURCES = ((BLUE, "ideal, Table 1"), (SKY, "ideal, equal force"), (ORANGE, "motor"))
MARKS = dict(zip(CAPTURED, "osD^", strict=True))


def draw_drift(numbers: Numbers) -> Figure:
    """Rates of displacement of every perturbed start, case by case: overall, and in the second half."""
    figure = sheet(PAGE, 8.0)
    names = [name for three in zip(PRINTED, EQUAL_FORCE, MOTORS, strict=True) for name in three]
    panels = figure.subplots(1, 2, sharey=True)
    for axes, key, title in zip(panels, ("overall", "drift"), ("Overall", "Second half"), strict=True):
        for place, name in enumerate(names):
            rates = [1e3 * abs(each[key]) for each in members(numbers, name) if each.get(key) is not None]
            colour = ORANGE if name in MOTORS else SKY if name in EQUAL_FORCE else BLUE
            _cloud(axes, place, np.maximum(rates, SLOWEST), colour, name)
            axes.plot(place, max(1e3 * abs(_from_rest(numbers, name, key)), SLOWEST), "o", **RING)
        axes.set_yscale("log")
        axes.set_title(title, fontsize=8, fontweight="bold")
        _name_places(axes, names)
    panels[0].set_ylabel("Rate of displacement $|dx_2/dt|$ (mm/s)")
    handles = [Patch(facecolor=colour, label=label) for colour, label in SOURCES]
    legend_below(figure, handles, [label for _, label in SOURCES], handlelength=1.2)
    return figure


def _from_rest(numbers: Numbers, name: str, key: str) -> float:
    run = numbers["runs"][name]
    return float(run["overall"] if key == "overall" else run["drift"]["rate"] or np.nan)


def draw_capture(numbers: Numbers) -> Figure:
    """Speed while held, beside final speed against the time of release, of every perturbed start."""
    figure = sheet(PAGE, 7.6)
    speeds, ends = figure.subplots(1, 2, width_ratios=(1, 1.6))
    speeds.axhline(NATURAL_HZ, color=GREY, linewidth=0.8, linestyle="--")
    ends.axvspan(*ABOUT_100, color=SHADE, linewidth=0, zorder=0)
    ends.axhspan(*JUMPED_HZ, color=SHADE, linewidth=0, zorder=0)
    for place, name in enumerate(CAPTURED):
        held = [each for each in members(numbers, name) if each.get("since") is not None]
        _cloud(speeds, place, [each["speed_hz"] for each in held], COLOURS[name], name)
        last = numbers["runs"][name]["t_end"]
        times = [last if each["until"] is None else each["until"] for each in held]
        ends.plot(
            times, [each["final_hz"] for each in held], MARKS[name], color=COLOURS[name], markersize=3,
            alpha=0.7, markeredgewidth=0, label=name, gid=name,
        )  # fmt: skip
    speeds.set_ylabel("Speed while held (Hz)")
    speeds.margins(y=0.1)
    _name_places(speeds, CAPTURED)
    ends.set_xlabel("Held until (s)")
    ends.set_ylabel("Final speed (Hz)")
    ends.set_xlim(0, 1.03 * max(numbers["runs"][name]["t_end"] for name in CAPTURED))
    legend_below(figure, *ends.get_legend_handles_labels())
    return figure


def draw_regimes(numbers: Numbers) -> Figure:
    """Regime of most starts at each frequency of the ideal source, a row for each law and damping."""
    figure = sheet(PAGE, 5.4)
    axes = figure.subplots()
    rows = [(law, c) for law in LAWS for c in DAMPINGS]
    regimes = {(row["law"], row["c"], row["hz"]): row["regime"] for row in numbers["nearby"]}
    kinds = list(KINDS)
    classes = np.array([[_class(kinds, regimes.get((*row, hz))) for hz in FREQUENCIES] for row in rows])
    half = (FREQUENCIES[1] - FREQUENCIES[0]) / 2
    edges = [hz - half for hz in FREQUENCIES] + [FREQUENCIES[-1] + half]
    colours = ListedColormap(list(KINDS.values()))
    axes.pcolormesh(
        edges, range(len(rows) + 1), classes, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5,
        edgecolors="white", linewidth=0.4, gid="regimes",
    )  # fmt: skip
    for row in numbers["nearby"]:
        if len({str(each["regime"]) for each in row["starts"]}) > 1:
            place = rows.index((row["law"], row["c"])) + 0.5
            axes.plot(row["hz"], place, "o", color="white", markersize=1.8, markeredgewidth=0, gid="disagree")
    for hz in (3.5, 5.5, 6.5):
        for law in LAWS:
            axes.plot(hz, rows.index((law, DAMPINGS[1])) + 0.75, "X", **CROSS)
    axes.set_yticks(np.arange(len(rows)) + 0.5, [f"{law}, c = {c:g}" for law, c in rows])
    axes.tick_params(length=0)
    axes.set_xlabel(r"Frequency of the ideal source $\omega/2\pi$ (Hz)")
    handles = [Patch(facecolor=colour, edgecolor="0.3", linewidth=0.4) for colour in KINDS.values()]
    legend_below(figure, handles, kinds, handlelength=1.2)
    return figure


def _class(kinds: Sequence[str], regime: str | None) -> float:
    return kinds.index(regime) if regime in kinds else float("nan")


def _cloud(axes: Axes, place: int, values: Any, colour: str, gid: str) -> None:
    """Values above a place, side by side in their order."""
    beside = place + np.linspace(-SIDEWAYS, SIDEWAYS, len(values)) if len(values) > 1 else [place]
    beside = beside[: len(values)]
    axes.plot(beside, values, "o", color=colour, markersize=2.2, alpha=0.7, markeredgewidth=0, gid=gid)


def _name_places(axes: Axes, names: Sequence[str]) -> None:
    axes.set_xticks(range(len(names)), names, rotation=30, ha="right", rotation_mode="anchor")
    axes.tick_params(axis="x", length=0)
    axes.set_xlim(-0.6, len(names) - 0.4)

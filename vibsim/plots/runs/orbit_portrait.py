"""A periodic orbit: its course in the relative phase plane, and its multipliers in the unit circle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.plots.motion.pairs import Pair, common_pairs, label_relative
from vibsim.plots.motion.relative_motion import draw_stop_line
from vibsim.plots.motion.trace import draw_impacts, impact_points
from vibsim.plots.motion.turns import states_at
from vibsim.plots.page.quantities import Scale, scale_for, seconds
from vibsim.plots.page.sheet import legend_above, letter_panels, note, sheet
from vibsim.plots.style import GREY, SHADE, overlay
from vibsim.plots.subject import Subject
from vibsim.plots.view import View

POINTS = 1600  # instants of a curve, besides those of the events; the engine computes the state at each
ROOM = 1.12  # around the unit circle, or the largest multiplier
RING = np.linspace(0, 2 * np.pi, 361)

Plane = tuple[np.ndarray, np.ndarray]


def draw(subjects: Sequence[Subject], view: View) -> Figure:
    """Relative velocity against relative displacement over one period, impacts as rings and returns to the
    section as squares; beside it the multipliers, filled where the orbit is stable.
    """
    wide = view.width == "page"
    figure = sheet(view, 7.2 if wide else 12.6)
    grid = {"width_ratios": (1.5, 1)} if wide else {"height_ratios": (1, 1.05)}
    panels = list(figure.subplots(*((1, 2) if wide else (2, 1)), squeeze=False, **grid).ravel())
    _portrait(panels[0], subjects)
    _circle(panels[1], subjects)
    if len(subjects) > 1:
        legend_above(panels[0])
    letter_panels(panels)
    return figure


def _portrait(axes: Axes, subjects: Sequence[Subject]) -> None:
    """The orbits in the plane of the motion of two ends against each other."""
    pairs = common_pairs(subjects)
    curves = [_curve(subject, pair) for subject, pair in zip(subjects, pairs, strict=True)]
    scales = scale_for("m", *(x for x, _ in curves)), scale_for("m/s", *(y for _, y in curves))
    for i, (subject, pair, (x, y)) in enumerate(zip(subjects, pairs, curves, strict=True)):
        colour = overlay(i)["color"]
        axes.plot(
            scales[0](x), scales[1](y), color=colour, linewidth=0.7, label=subject.name, gid="orbit", zorder=2
        )
        if subject.scene.has_stop:
            span = (0.0, subject.result.t_reached)
            draw_impacts(axes, impact_points(subject, pair.names, pair.plane, span), scales, colour)
        _returns(axes, subject, pair, scales, colour)
    for position, text in dict.fromkeys(stop for pair in pairs for stop in pair.stops):
        draw_stop_line(axes, position, scales[0], text if len(subjects) == 1 else "")
    axes.margins(0.06)
    label_relative(axes, pairs[0], scales)
    note(axes, "; ".join(dict.fromkeys(map(_said, subjects))), above=1 if pairs[0].stops else 0)


def _said(subject: Subject) -> str:
    """How long an orbit is."""
    n, of = subject.result.attrs["orbit_periods"], "turn" if subject.scene.has_motor else "period"
    return f"{n} {of}{'s' * (n > 1)}, {seconds((0.0, subject.result.t_reached))}"


def _curve(subject: Subject, pair: Pair) -> Plane:
    """The orbit through evenly spaced instants and those of its events, closed."""
    result, T = subject.result, subject.result.t_reached
    times = np.union1d(np.linspace(0, T, POINTS), np.asarray(result.events["t"]))
    return _plane(subject, pair, times)


def _returns(axes: Axes, subject: Subject, pair: Pair, scales: tuple[Scale, Scale], colour: str) -> None:
    """Where the orbit meets the section: the start, and each return that a timed section has."""
    result, n = subject.result, subject.result.attrs["orbit_periods"]
    share = np.arange(n if not subject.scene.has_motor else 1) / n
    x, y = _plane(subject, pair, share * result.t_reached)
    axes.plot(
        scales[0](x), scales[1](y), linestyle="none", marker="s", markersize=3.2, color=colour, gid="section",
        zorder=4,
    )  # fmt: skip


def _plane(subject: Subject, pair: Pair, times: np.ndarray) -> Plane:
    names = tuple(name for name in pair.names if name != "time")
    states = states_at(subject.result, names, times, len(times))
    return pair.plane({**states, "time": times})


def _circle(axes: Axes, subjects: Sequence[Subject]) -> None:
    """The multipliers in the complex plane, and the unit circle."""
    axes.fill(np.cos(RING), np.sin(RING), color=SHADE, linewidth=0, zorder=0)
    axes.plot(np.cos(RING), np.sin(RING), color=GREY, linewidth=0.6, zorder=1, gid="unit-circle")
    largest = 1.0
    for i, subject in enumerate(subjects):
        orbit = subject.result.orbit
        re, im = np.asarray(orbit["multiplier_real"]), np.asarray(orbit["multiplier_imaginary"])
        largest = max(largest, float(np.abs(re).max(initial=0)), float(np.abs(im).max(initial=0)))
        colour, inside = overlay(i)["color"], np.hypot(re, im) < 1
        for shown, face in ((inside, colour), (~inside, "white")):
            axes.plot(
                re[shown], im[shown], linestyle="none", marker="o", markersize=3.6, markeredgewidth=0.9,
                color=colour, markerfacecolor=face, gid="multipliers", zorder=3,
            )  # fmt: skip
    for line in (axes.axhline, axes.axvline):
        line(0, color=GREY, linewidth=0.4, zorder=1)
    axes.set_xlim(-ROOM * largest, ROOM * largest)
    axes.set_ylim(-ROOM * largest, ROOM * largest)
    axes.set_aspect("equal")
    axes.set_xlabel("Real part of the multipliers")
    axes.set_ylabel("Imaginary part")
    stable = ["stable" if subject.result.attrs["orbit_stable"] else "unstable" for subject in subjects]
    note(axes, ", ".join(stable))

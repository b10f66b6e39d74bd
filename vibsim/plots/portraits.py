"""Phase portraits of the blocks, as the paper draws them: velocity against displacement, drift included."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibsim.cases.problems import counted
from vibsim.physics.parts import columns_of
from vibsim.physics.rates import turning_columns
from vibsim.plots.poincare_sections import draw_poincare, drift_rate, states_at
from vibsim.plots.samples import (
    draw_stop_line,
    shown,
    steady_span,
)
from vibsim.plots.sheet import (
    Scale,
    few_ticks,
    legend_above,
    letter_panels,
    note,
    scale_for,
    seconds,
    sheet,
    signed,
    symbol,
)
from vibsim.plots.style import BLUE, GREY, SHADE, overlay
from vibsim.plots.subject import Span, Subject, View
from vibsim.plots.traces import (
    RINGS_UP_TO,
    UP_TO_TURNS,
    Block,
    Plane,
    PlottedPair,
    Trace,
    common_pairs,
    draw_belts,
    draw_impacts,
    draw_trace,
    folded,
    folded_angles,
    impact_points,
    label_relative,
    relative_traces,
    trace,
    trust_remark,
    within_a_turn,
)


@dataclass(frozen=True)
class Portrait:
    """The portrait of one block of one run: unit of its displacement, curve, impacts, span [s], drift taken
    out [m/s], its look, and whether it is an angle that is drawn up to whole turns.
    """

    subject: Subject
    unit: str
    span: Span
    curve: Trace
    impacts: Trace | None
    drift: float
    look: dict[str, Any]
    whole_turns: bool


def phase_picture(subjects: Sequence[Subject], view: View, less_drift: bool = False) -> Figure:
    """Velocity against displacement of each block; the last 50 periods unless the view has a window."""
    columns = moving(subjects)
    wide = view.width == "page"
    figure = sheet(view, 7.2 if wide else 6.2 * len(columns))
    grid = (1, len(columns)) if wide else (len(columns), 1)
    panels = list(figure.subplots(*grid, squeeze=False).ravel())
    phase_panels(panels, subjects, view, columns, less_drift)
    if len(subjects) > 1:
        legend_above(panels[0])
    letter_panels(panels)
    figure.align_ylabels()
    return figure


def moving(subjects: Sequence[Subject]) -> list[str]:
    """Columns of the displacements of blocks that move in any of the runs, in file order."""
    columns = [name for subject in subjects for name in subject.columns_in("m")]
    return list(dict.fromkeys(columns))


def phase_panels(
    panels: Sequence[Axes],
    subjects: Sequence[Subject],
    view: View,
    columns: Sequence[str],
    less_drift: bool = False,
) -> None:
    """The portraits of the blocks whose displacements are `columns`, in given axes; those of bodies that move
    are in the same units, and those of bodies that turn.

    less_drift : whether to take the mean velocity of each block out, so that a steady motion closes
    """
    drawn = [_portraits(subjects, view, column, less_drift) for column in columns]
    scales_of = {unit: _scales(drawn, unit) for unit in ("m", "rad")}
    for axes, column, portraits in zip(panels, columns, drawn, strict=True):
        subject = portraits[0].subject
        scales = scales_of[subject.unit("m", column)]
        _panel(axes, portraits, column, scales, view.poincare)
        less = " less drift" if less_drift else ""
        x, v = (subject.word(unit, column).capitalize() for unit in ("m", "m/s"))
        few_ticks(axes)
        axes.set_xlabel(scales[0].label(f"{x} {symbol(column)}{less}"))
        axes.set_ylabel(scales[1].label(f"{v} {symbol('v' + column[1:])}{less}"))


def _scales(drawn: Sequence[Sequence[Portrait]], unit: str) -> tuple[Scale, Scale]:
    """Scales of the displacements in that unit, m or rad, and of their velocities."""
    curves = [each.curve for portraits in drawn for each in portraits if each.unit == unit]
    return scale_for(unit, *(one.x for one in curves)), scale_for(f"{unit}/s", *(one.y for one in curves))


def _portraits(subjects: Sequence[Subject], view: View, column: str, less_drift: bool) -> list[Portrait]:
    portraits = []
    for i, subject in enumerate(subjects):
        if column in subject.columns_in("m"):
            span = shown(subject, view.window, steady_span)
            look = {**overlay(i), "alpha": 0.7} if len(subjects) > 1 else {"color": BLUE}
            portraits.append(_portrait(subject, column, span, less_drift, look))
    return portraits


def _portrait(subject: Subject, column: str, span: Span, less_drift: bool, look: dict[str, Any]) -> Portrait:
    drift = drift_rate(subject.result, column, span) if less_drift else 0.0
    names, plane = ("time", column, f"v{column[1:]}"), _less_drift(column, drift, span[0])
    curve = trace(subject.result, names, plane, span)
    impacts = impact_points(subject, names, plane, span) if subject.scene.has_stop else None
    scene = subject.scene
    turns = not less_drift and any(
        columns_of(scene.bodies[i].name)[0] == column for i in folded_angles(scene)
    )
    return Portrait(
        subject,
        subject.unit("m", column),
        span,
        folded(curve) if turns else curve,
        impacts,
        drift,
        look,
        turns,
    )


def _less_drift(column: str, drift: float, begin: float) -> Plane:
    """Function from columns of a run to displacement and velocity of a block without its drift."""
    velocity = f"v{column[1:]}"

    def plane(columns: Block) -> tuple[np.ndarray, np.ndarray]:
        if not drift:
            return columns[column], columns[velocity]
        return columns[column] - drift * (columns["time"] - begin), columns[velocity] - drift

    return plane


def _panel(
    axes: Axes, portraits: Sequence[Portrait], column: str, scales: tuple[Scale, Scale], poincare: bool
) -> None:
    for portrait in portraits:
        draw_trace(axes, portrait.curve, scales, label=portrait.subject.name, gid=column, **portrait.look)
        if portrait.impacts is not None:
            draw_impacts(axes, portrait.impacts, scales, portrait.look["color"])
    names = ("time", column, f"v{column[1:]}")
    sections = [(p.subject, names, _less_drift(column, p.drift, p.span[0]), p.span) for p in portraits]
    turns = portraits[0].whole_turns
    points_said = draw_poincare(axes, sections, scales, turns) if poincare else ""
    axes.margins(0.05)
    spans = [portrait.span for portrait in portraits]
    impacts = [len(p.impacts.x) for p in portraits if p.impacts is not None and len(p.impacts.x)]
    marks = "rings: impacts" if impacts and max(impacts) <= RINGS_UP_TO else "black dots: impacts"
    drifts = [portrait.drift for portrait in portraits if portrait.drift]
    scale = scale_for(f"{portraits[0].unit}/s", drifts)
    remarks = [
        *dict.fromkeys(map(seconds, spans)),
        f"drift {', '.join(signed(float(scale(drift))) for drift in drifts)} {scale.unit}" if drifts else "",
        marks if impacts else "",
        points_said,
        UP_TO_TURNS if turns else "",
        trust_remark([portrait.subject for portrait in portraits], spans),
    ]
    note(axes, "; ".join(filter(None, remarks)))


# Phase portraits of the blocks with their drift taken out: a steady motion closes, and its period shows.


def phase_drift_free_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """v - u against x - u t, u the drift rate of the block over the span; else as `runs.phase`."""
    return phase_picture(subjects, view, less_drift=True)


# A periodic orbit: its course in the relative phase plane, and its multipliers in the unit circle.


POINTS = 1600  # instants of a curve, besides those of the events; the engine computes the state at each
ROOM = 1.12  # around the unit circle, or the largest multiplier
RING = np.linspace(0, 2 * np.pi, 361)

Curve = tuple[np.ndarray, np.ndarray]


def orbit_portrait_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Relative velocity against relative displacement over one period, impacts as rings and returns to the
    section as squares; beside it the multipliers, filled where the orbit is stable.
    """
    wide = view.width == "page"
    figure = sheet(view, 7.2 if wide else 12.6)
    grid = {"width_ratios": (1.5, 1)} if wide else {"height_ratios": (1, 1.05)}
    panels = list(figure.subplots(*((1, 2) if wide else (2, 1)), squeeze=False, **grid).ravel())
    _orbit_portrait(panels[0], subjects)
    _circle(panels[1], subjects)
    if len(subjects) > 1:
        legend_above(panels[0])
    letter_panels(panels)
    return figure


def _orbit_portrait(axes: Axes, subjects: Sequence[Subject]) -> None:
    """The orbits in the plane of the motion of two ends against each other."""
    pairs = common_pairs(subjects)
    curves = [_curve(subject, pair) for subject, pair in zip(subjects, pairs, strict=True)]
    units = pairs[0].units
    scales = scale_for(units[0], *(x for x, _ in curves)), scale_for(units[1], *(y for _, y in curves))
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
    marks = ["rings: impacts"] if any(subject.scene.has_stop for subject in subjects) else []
    said = "; ".join(dict.fromkeys([*map(_said, subjects), *marks, "squares: returns to the section"]))
    note(axes, said, above=1 if pairs[0].stops else 0)


def _said(subject: Subject) -> str:
    """Length of an orbit, in periods or turns and in seconds."""
    n, of = subject.result.attrs["orbit_periods"], "turn" if turning_columns(subject.scene) else "period"
    return f"{counted(n, of)}, {seconds((0.0, subject.result.t_reached))}"


def _curve(subject: Subject, pair: PlottedPair) -> Curve:
    """The orbit through evenly spaced instants and those of its events, closed."""
    result, T = subject.result, subject.result.t_reached
    times = np.union1d(np.linspace(0, T, POINTS), np.asarray(result.events["t"]))
    curve = Trace(*_plane(subject, pair, times), joined=True)
    curve = folded(curve) if pair.whole_turns else curve
    return curve.x, curve.y


def _returns(
    axes: Axes, subject: Subject, pair: PlottedPair, scales: tuple[Scale, Scale], colour: str
) -> None:
    """Points of the orbit on the section: the start, and each return that a timed section has."""
    result, n = subject.result, subject.result.attrs["orbit_periods"]
    share = np.arange(1 if turning_columns(subject.scene) else n) / n
    x, y = _plane(subject, pair, share * result.t_reached)
    x = within_a_turn(x) if pair.whole_turns else x
    axes.plot(
        scales[0](x), scales[1](y), linestyle="none", marker="s", markersize=3.2, color=colour, gid="section",
        zorder=4,
    )  # fmt: skip


def _plane(subject: Subject, pair: PlottedPair, times: np.ndarray) -> Curve:
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
        for chosen, face in ((inside, colour), (~inside, "white")):
            axes.plot(
                re[chosen], im[chosen], linestyle="none", marker="o", markersize=3.6, markeredgewidth=0.9,
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


# Phase portrait of the relative motion.


BESIDE_STOP = 20  # characters of a remark that has room beside the name of the stop


def relative_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Relative velocity against relative displacement, and the stop.

    The last 50 periods unless the view has a window.
    """
    figure = sheet(view, 7.2)
    axes = figure.subplots()
    relative_panel(axes, subjects, view)
    if len(subjects) > 1:
        legend_above(axes)
    return figure


def relative_panel(axes: Axes, subjects: Sequence[Subject], view: View) -> None:
    """The portrait in given axes."""
    spans = [shown(subject, view.window, steady_span) for subject in subjects]
    pairs = common_pairs(subjects)
    traces = relative_traces(subjects, pairs, spans)
    units = pairs[0].units
    scales = (
        scale_for(units[0], *(each.x for each in traces)),
        scale_for(units[1], *(each.y for each in traces)),
    )
    for i, (subject, each) in enumerate(zip(subjects, traces, strict=True)):
        look = {**overlay(i), "alpha": 0.7} if len(subjects) > 1 else {"color": BLUE}
        draw_trace(axes, each, scales, label=subject.name, gid="relative", **look)
    points_said = ""
    if view.poincare:
        listed = zip(subjects, pairs, spans, strict=True)
        points_said = draw_poincare(
            axes,
            [(s, pair.names, pair.plane, span) for s, pair, span in listed],
            scales,
            pairs[0].whole_turns,
        )
    draw_belts(axes, pairs[0], scales[1])
    every = dict.fromkeys(stop for pair in pairs for stop in pair.stops)
    stops = [stop for stop in every if _is_near(stop[0], traces)]
    for position, text in stops:
        draw_stop_line(axes, position, scales[0], text if len(subjects) == 1 else "")
    axes.margins(0.05)
    label_relative(axes, pairs[0], scales)
    rest_said = "" if any(each.x.any() or each.y.any() for each in traces) else "no relative motion"
    turns_said = UP_TO_TURNS if pairs[0].whole_turns else ""
    said = (rest_said, *dict.fromkeys(map(seconds, spans)), points_said, turns_said)
    remarks = [*said, trust_remark(subjects, spans)]
    text = "; ".join(filter(None, remarks))
    crowded = len(text) > BESIDE_STOP or any(not name.startswith("$") for _, name in stops)
    note(axes, text, above=1 if len(subjects) == 1 and stops and crowded else 0)


def _is_near(position: float, traces: Sequence[Trace]) -> bool:
    """Whether a stop [m] is so near what motions reach that these are not squeezed where it is drawn."""
    x = np.concatenate([trace.x for trace in traces])
    low, high = float(np.nanmin(x)), float(np.nanmax(x))
    return max(low - position, position - high) <= FARTHEST * (high - low)


FARTHEST = 10.0  # from a motion to a stop that is drawn, in extents of the motion

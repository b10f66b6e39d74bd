"""Phase portraits of the blocks, as the paper draws them: velocity against displacement, drift included."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibsim.physics.parts import columns_of
from vibsim.physics.rates import common_period, turning_columns
from vibsim.plots.samples import (
    PERIODS_AT_MOST,
    common_window,
    draw_stop_line,
    events_within,
    last_half,
    shown,
    steady_span,
    window_of,
)
from vibsim.plots.sheet import (
    Scale,
    few_ticks,
    legend_above,
    letter_panels,
    note,
    say_inside,
    scale_for,
    seconds,
    sheet,
    signed,
    symbol,
    time_axis,
)
from vibsim.plots.spectra import states_at, turn_times
from vibsim.plots.style import BLUE, GREY, MARKERS, SHADE, dot_size, overlay
from vibsim.plots.subject import Span, Subject, View
from vibsim.plots.time_histories import draw_poincare, drift_rate
from vibsim.plots.traces import (
    RINGS_UP_TO,
    UP_TO_TURNS,
    Block,
    Plane,
    PlottedPair,
    Trace,
    common_pairs,
    draw_impacts,
    draw_trace,
    folded,
    folded_angles,
    impact_points,
    label_relative,
    relative_traces,
    trace,
    trust_marks,
    trust_remark,
    within_a_turn,
)
from vibsim.results.columns import closing_velocities


@dataclass(frozen=True)
class Portrait:
    """The portrait of one block of one run: curve, impacts, span [s], drift taken out [m/s], its look, and
    whether it is an angle that is drawn up to whole turns.
    """

    subject: Subject
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
    """The portraits of the blocks whose displacements are `columns`, in given axes, all in the same units.

    less_drift : whether to take the mean velocity of each block out, so that a steady motion closes
    """
    drawn = [_portraits(subjects, view, column, less_drift) for column in columns]
    every = [portrait.curve for portraits in drawn for portrait in portraits]
    units = subjects[0].unit("m"), subjects[0].unit("m/s")
    scales = (
        scale_for(units[0], *(each.x for each in every)),
        scale_for(units[1], *(each.y for each in every)),
    )
    for axes, column, portraits in zip(panels, columns, drawn, strict=True):
        _panel(axes, portraits, column, scales, view.poincare)
        less = " less drift" if less_drift else ""
        x, v = (subjects[0].word(unit).capitalize() for unit in ("m", "m/s"))
        few_ticks(axes)
        axes.set_xlabel(scales[0].label(f"{x} {symbol(column)}{less}"))
        axes.set_ylabel(scales[1].label(f"{v} {symbol('v' + column[1:])}{less}"))


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
    return Portrait(subject, span, folded(curve) if turns else curve, impacts, drift, look, turns)


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
    scale = scale_for(portraits[0].subject.unit("m/s"), drifts)
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
    units = subjects[0].unit("m"), subjects[0].unit("m/s")
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
    """How long an orbit is."""
    n, of = subject.result.attrs["orbit_periods"], "turn" if turning_columns(subject.scene) else "period"
    return f"{n} {of}{'s' * (n > 1)}, {seconds((0.0, subject.result.t_reached))}"


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
    """Where the orbit meets the section: the start, and each return that a timed section has."""
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


# Stroboscopic section of the relative motion: the state once per period of the source.


LEAST = 1e-2  # of the extent of the motion: the least that is shown


def stroboscopic_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Relative velocity against relative displacement (`pair_of`) at the end of each period of the source.

    The last half of the run by default.
    """
    figure = sheet(view, 7.2)
    axes = figure.subplots()
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    pairs = common_pairs(subjects)
    drawn = [section(*each) for each in zip(subjects, pairs, spans, strict=True)]
    units = subjects[0].unit("m"), subjects[0].unit("m/s")
    scales = scale_for(units[0], *(y for y, _ in drawn)), scale_for(units[1], *(u for _, u in drawn))
    for i, (subject, (y, u)) in enumerate(zip(subjects, drawn, strict=True)):
        colour = overlay(i)["color"] if len(subjects) > 1 else BLUE
        axes.plot(
            scales[0](y), scales[1](u), linestyle="none", marker=MARKERS[i % len(MARKERS)],
            markersize=dot_size(len(y)),
            markeredgewidth=0.3, markerfacecolor="none" if len(subjects) > 1 else colour, color=colour,
            label=subject.name, gid="section", rasterized=len(y) > 20_000,
        )  # fmt: skip
    axes.margins(0.06)
    _no_narrower_than_rounding(axes, subjects, pairs, spans, scales)
    label_relative(axes, pairs[0], scales)
    count = sum(len(y) for y, _ in drawn)
    if not count:
        say_inside(axes, "no period of the source ends here")
        axes.set(xticks=[], yticks=[])
    remarks = [f"{count} point{'' if count == 1 else 's'}", *dict.fromkeys(map(seconds, spans))]
    remarks += [UP_TO_TURNS] if pairs[0].whole_turns else []
    named = count > 0 and len(subjects) == 1 and _stops_if_near(axes, pairs[0], scales[0])
    note(axes, "; ".join(filter(None, [*remarks, trust_remark(subjects, spans)])), above=1 if named else 0)
    if len(subjects) > 1:
        legend_above(axes, markerscale=2)
    return figure


def _no_narrower_than_rounding(
    axes: Axes,
    subjects: Sequence[Subject],
    pairs: Sequence[PlottedPair],
    spans: Sequence[Span],
    scales: tuple[Scale, Scale],
) -> None:
    """Widen axes to a share of the motion: a periodic motion is a point, whose scatter is rounding."""
    traces = relative_traces(subjects, pairs, spans)
    motions = [each.x for each in traces], [each.y for each in traces]
    for axis, scale, values in zip((axes.xaxis, axes.yaxis), scales, motions, strict=True):
        low, high = axis.get_view_interval()
        every = scale(np.concatenate(values))
        least = LEAST * float(np.nanmax(every) - np.nanmin(every))
        if high - low < least:
            middle = (low + high) / 2
            axis.set_view_interval(middle - least / 2, middle + least / 2, ignore=True)


def section(subject: Subject, pair: PlottedPair, span: Span) -> tuple[np.ndarray, np.ndarray]:
    """Relative displacement [m] and velocity [m/s] (n) at each turn of the source within the span."""
    times = turn_times(subject.result, span)
    names = tuple(name for name in pair.names if name != "time")
    states = states_at(subject.result, names, times, PERIODS_AT_MOST + 1)
    y, u = pair.plane({**states, "time": times[times <= subject.result.t_reached]})
    return (within_a_turn(y) if pair.whole_turns else y), u


def _stops_if_near(axes: Axes, pair: PlottedPair, scale: Scale) -> bool:
    """The stops, but for those so far off that they would squeeze the section; whether any is drawn."""
    low, high = axes.get_xlim()
    near = [(at, text) for at, text in pair.stops if low <= float(scale(at)) <= high]
    for at, text in near:
        draw_stop_line(axes, at, scale, text)
    return bool(near)


# Velocity at which the blocks meet the stop: over time, over the source's phase, and its histogram.


BINS = 40  # at most
BINS_OF_ROOT = 4  # bins per cube root of the number of impacts: twice the rule of Rice, for narrow peaks
THINNEST = 0.012  # of the greatest velocity: a bar that can be seen
LONGEST_NOTE = 10  # characters above the narrow histogram
HEADROOM = 1.1  # beyond the longest bar of the histogram, and above the fastest impact
CLOSING = "Closing velocity"
NO_IMPACTS = "no impacts"


@dataclass(frozen=True)
class Impacts:
    """Instants [s], closing velocities [m/s] (into the stop: > 0), phases of the source [turns]; (n)."""

    t: np.ndarray
    closing: np.ndarray
    phase: np.ndarray | None

    def within(self, span: Span) -> Impacts:
        """Those within a span [s]."""
        inside = (self.t >= span[0]) & (self.t <= span[1])
        return Impacts(
            self.t[inside], self.closing[inside], self.phase[inside] if self.phase is not None else None
        )


def impact_velocity_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Closing velocity of each impact against time; of a settled motion its histogram and phase.

    Histogram and phases are those of the last half of the run, unless the view has a window.
    """
    window = common_window(subjects, view.window)
    of_subjects = [impacts_of(subject, window_of(subject, window)) for subject in subjects]
    spans = [_settled(subject, view, impacts) for subject, impacts in zip(subjects, of_subjects, strict=True)]
    settled = [impacts.within(span) for impacts, span in zip(of_subjects, spans, strict=True)]
    scale = scale_for(subjects[0].unit("m/s"), *(impacts.closing for impacts in of_subjects))
    with_phase = any(impacts.phase is not None for impacts in of_subjects)
    figure = sheet(view, 8.8 if with_phase else 5.0)
    grid = figure.add_gridspec(2 if with_phase else 1, 2, width_ratios=(4, 1))
    over_time = figure.add_subplot(grid[0, 0])
    histogram = figure.add_subplot(grid[0, 1], sharey=over_time)
    over_phase = figure.add_subplot(grid[1, :]) if with_phase else None
    colours = [overlay(i)["color"] for i in range(len(subjects))] if len(subjects) > 1 else [BLUE]
    for subject, impacts, late, colour in zip(subjects, of_subjects, settled, colours, strict=True):
        _dots(over_time, impacts.t, scale(impacts.closing), colour, subject.name)
        _histogram(histogram, scale(late.closing), colour, filled=len(subjects) == 1)
        if over_phase is not None and late.phase is not None:
            _dots(over_phase, 360 * late.phase, scale(late.closing), colour, subject.name)
    _finish(over_time, histogram, over_phase, scale, window)
    _say(subjects, (over_time, histogram, over_phase), (window, spans), settled, colours)
    if not any(len(impacts.t) for impacts in of_subjects):
        _say_none(over_time, histogram, over_phase)
    if len(subjects) > 1:
        legend_above(over_time, markerscale=5)
    letter_panels([axes for axes in (over_time, histogram, over_phase) if axes is not None])
    return figure


def _settled(subject: Subject, view: View, impacts: Impacts) -> Span:
    """The part of the run of which phases and frequencies are shown: the last half, or the view's window.

    All of the run where the last half has no impacts.
    """
    span = shown(subject, view.window, last_half)
    return span if len(impacts.within(span).t) else window_of(subject, view.window)


def _say(
    subjects: Sequence[Subject],
    panels: tuple[Axes, Axes, Axes | None],
    spans: tuple[Span, Sequence[Span]],
    settled: Sequence[Impacts],
    colours: Sequence[Any],
) -> None:
    """Marks of the trust horizons, and above each panel what it shows."""
    over_time, histogram, over_phase = panels
    lines = colours if len(subjects) > 1 else [GREY]
    trust = trust_marks(over_time, subjects, spans[0], lines)
    count = sum(len(impacts.t) for impacts in settled)
    words = f"{count} impact{'' if count == 1 else 's'}"
    listed = "; ".join(dict.fromkeys(map(seconds, spans[1])))
    if over_phase is None:
        note(over_time, "; ".join(filter(None, [trust, f"histogram: {words}, {listed}"])))
        return
    note(over_time, trust)
    note(over_phase, f"{words}, {listed}")
    if len(listed) <= LONGEST_NOTE:
        note(histogram, listed)


def impacts_of(subject: Subject, span: Span) -> Impacts:
    """The impacts of a run within the span, at all its stops; the phase is that of the common period of the
    forces and the base, or the angle of the rotor.
    """
    scene = subject.scene
    events = events_within(subject.result, None, span)
    t, closing = events["t"], closing_velocities(scene, events)
    rows, period = ~np.isnan(closing), common_period(scene)
    t, closing = t[rows], closing[rows]
    turning = turning_columns(scene)
    if turning is not None:
        return Impacts(t, closing, np.mod(events[turning[0]][rows] / (2 * math.pi), 1.0))
    if period is not None:
        turns = t * period.cycles + t * period.cycles_lo
        return Impacts(t, closing, np.mod(turns / period.turns, 1.0))
    return Impacts(t, closing, None)


def _say_none(over_time: Axes, histogram: Axes, over_phase: Axes | None) -> None:
    """Empty panels without a scale of velocities, which nothing has given them."""
    say_inside(over_time, NO_IMPACTS)
    for axes in filter(None, (over_time, histogram, over_phase)):
        axes.set_yticks([])
    histogram.set_xticks([0])


def _dots(axes: Axes, x: np.ndarray, y: np.ndarray, colour: str, label: str) -> None:
    axes.plot(
        x, y, linestyle="none", marker="o", markersize=dot_size(len(x)), markeredgewidth=0, color=colour,
        label=label, gid="impacts", rasterized=len(x) > 5_000, clip_on=not len(x),
        zorder=2.6,
    )  # fmt: skip


def _histogram(axes: Axes, values: np.ndarray, colour: str, filled: bool) -> None:
    if len(values):
        counts, edges = np.histogram(values, *_bins(values))
        axes.stairs(counts, edges, orientation="horizontal", fill=filled, color=colour, linewidth=0.7)


def _bins(values: np.ndarray) -> tuple[int, tuple[float, float]]:
    """Number and range of the bins, of which none is too thin to be seen."""
    low, high = float(values.min()), float(values.max())
    thinnest = THINNEST * high
    most = min(BINS, math.ceil(BINS_OF_ROOT * len(values) ** (1 / 3)))
    bins = max(1, min(most, int((high - low) / thinnest))) if thinnest > 0 else most
    room = max(0.0, bins * thinnest - (high - low)) / 2
    return bins, (low - room, high + room)


def _finish(over_time: Axes, histogram: Axes, over_phase: Axes | None, scale: Scale, window: Span) -> None:
    over_time.set_ylabel(scale.label(CLOSING))
    time_axis(over_time, window)
    histogram.tick_params(labelleft=False)
    histogram.set_xlabel("Count")
    histogram.set_xlim(0, HEADROOM * max(histogram.get_xlim()[1], 1))
    histogram.xaxis.set_major_locator(MaxNLocator(2, integer=True))
    over_time.set_ylim(0, max(over_time.get_ylim()[1], HEADROOM * over_time.dataLim.y1))
    if over_phase is not None:
        over_phase.set_xlim(0, 360)
        over_phase.set_xticks(range(0, 361, 60))
        over_phase.set_ylim(over_time.get_ylim())
        over_phase.set_xlabel("Phase of the source at impact (°)")
        over_phase.set_ylabel(scale.label(CLOSING))

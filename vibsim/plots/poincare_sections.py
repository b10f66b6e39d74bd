"""Sections of motions: the states at each period of the source, and the impacts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibsim.cases.problems import counted
from vibsim.cases.ramps import drive_turns
from vibsim.physics.connections import drifting_sets
from vibsim.physics.parts import Scene, columns_of
from vibsim.physics.rates import common_period, motor_columns, turning_columns
from vibsim.plots import traces
from vibsim.plots.samples import (
    PERIODS_AT_MOST,
    blocks,
    common_window,
    draw_stop_line,
    events_within,
    last_half,
    shown,
    window_of,
)
from vibsim.plots.sheet import (
    Scale,
    legend_above,
    letter_panels,
    note,
    say_inside,
    scale_for,
    seconds,
    sheet,
    time_axis,
)
from vibsim.plots.style import BLUE, GREY, MARKERS, VERMILLION, dot_size, overlay
from vibsim.plots.subject import Span, Subject, View, check_one_unit
from vibsim.plots.traces import (
    UP_TO_TURNS,
    Block,
    Plane,
    PlottedPair,
    common_pairs,
    dense,
    hermite,
    label_relative,
    relative_traces,
    root_time,
    samples_are_sparse,
    shown_part,
    trust_marks,
    trust_remark,
    within_a_turn,
)
from vibsim.results.columns import closing_velocities

# Turns of the source: the instants at which its phase passes a multiple of 2 pi.


TURN = 2 * math.pi
TURNS = 12  # to average over: a multiple of the periods 1, 2, 3, 4 and 6 that the motion may have


def turn_times(result: Any, span: Span) -> np.ndarray:
    """Instants within the span at which the source begins a period [s], ascending; none without a period.

    Forces and base: multiples of their common period; of a ramp of their frequency its periods. Motor or
    rotor: phi = 2 pi k, located on the cubic Hermite interpolant of phi between two samples (phi and phidot
    are stored, so its error is of fourth order in the output interval).
    """
    scene = result.case.scene()
    turning = motor_columns(scene) or turning_columns(scene)
    if turning is not None:
        parts = _joined_blocks(result, ("time", *turning), span)
        times = [_turns(part["time"], part[turning[0]], part[turning[1]]) for part in parts]
        return np.concatenate([np.empty(0), *times])
    if (turns := drive_turns(result.case, np.array(span))) is not None:
        return _starts_of_periods(result, span, turns)
    period = common_period(scene)
    if period is None:
        return np.empty(0)
    rate = period.cycles / period.turns
    first, last = math.ceil(span[0] * rate - 1e-9), math.floor(span[1] * rate + 1e-9)
    return np.asarray(np.clip(period.end(np.arange(first, last + 1)), *span))


def _starts_of_periods(result: Any, span: Span, turns: np.ndarray) -> np.ndarray:
    """Instants [s] at which a drive with a ramp has made whole periods, by PER_TURN instants in each."""
    t = np.linspace(*span, max(2, math.ceil(turns[1] - turns[0]) * PER_TURN))
    made = drive_turns(result.case, t)
    assert made is not None
    return np.interp(np.arange(math.ceil(turns[0] - 1e-9), math.floor(turns[1] + 1e-9) + 1), made, t)


def _joined_blocks(result: Any, names: tuple[str, ...], span: Span) -> Iterator[dict[str, np.ndarray]]:
    """Blocks of samples that begin with the last sample of the block before, so that no interval is lost."""
    last: dict[str, np.ndarray] | None = None
    for block in blocks(result, names, span):
        if last is not None:
            block = {name: np.concatenate([last[name], block[name]]) for name in names}
        last = {name: block[name][-1:] for name in names}
        yield block


def _turns(t: np.ndarray, phi: np.ndarray, phidot: np.ndarray) -> np.ndarray:
    """Passages of phi through multiples of 2 pi between samples; several to an interval where it is long."""
    turn = np.floor(phi / TURN).astype(np.int64)
    passed = np.diff(turn)
    count = np.abs(passed)
    left = np.repeat(np.arange(len(passed)), count)
    if not len(left):
        return np.empty(0)
    within = np.arange(len(left)) - np.repeat(
        np.cumsum(count) - count, count
    )  # 0, 1, ... inside each interval
    forward = passed[left] > 0
    target = TURN * np.where(forward, turn[left] + 1 + within, turn[left] - within)
    return root_time(t[left], t[left + 1], phi[left], phi[left + 1], phidot[left], phidot[left + 1], target)


def states_at(
    result: Any, names: tuple[str, ...], times: np.ndarray, exact_up_to: int
) -> dict[str, np.ndarray]:
    """Columns `names` at the instants `times` (n), ascending [s].

    Up to `exact_up_to` of them are evaluated by the engine; more are interpolated between samples, x by the
    cubic Hermite polynomial of x and v, v by its derivative.
    """
    times = times[times <= result.t_reached]
    if len(times) <= exact_up_to:
        return traces.states_at(result, names, times)
    parts: dict[str, list[np.ndarray]] = {name: [] for name in names}
    bodies = dict(columns_of(body.name) for body in result.case.scene().line)
    pairs = {name: bodies[name] for name in names if name in bodies}
    done = 0
    for block in _joined_blocks(result, ("time", *names), (-math.inf, math.inf)):
        stop = int(np.searchsorted(times, block["time"][-1], side="right"))
        inside, done = times[done:stop], stop
        left = np.clip(np.searchsorted(block["time"], inside, side="right") - 1, 0, len(block["time"]) - 2)
        for x, v in pairs.items():
            position, velocity = hermite(block["time"], block[x], block[v], left, inside)
            parts[x].append(position)
            parts[v].append(velocity)
    return {name: np.concatenate(parts[name]) for name in names}


# Least and greatest displacement in every turn of the motor, and its mean speed in that turn.


PER_TURN = 16  # instants evaluated in a turn where the samples are too few


@dataclass(frozen=True)
class TurnExtremes:
    """One value per turn of the motor (n).

    Attributes
    ----------
    t : middle of the turn [s]
    hertz : mean speed in it [Hz]
    least, greatest : of the displacement, among samples [m]
    """

    t: np.ndarray
    hertz: np.ndarray
    least: np.ndarray
    greatest: np.ndarray


def turn_extremes(result: Any, column: str, span: Span) -> TurnExtremes:
    """The extremes of `column` in each whole turn within the span that has samples."""
    return extremes_by_turn(result, ("time", column), lambda block: block[column], span)


def extremes_by_turn(
    result: Any, names: tuple[str, ...], read: Callable[[Block], np.ndarray], span: Span
) -> TurnExtremes:
    """The same of what `read` makes of the columns `names` [m]."""
    times = turn_times(result, span)
    count = max(len(times) - 1, 0)
    least, greatest = np.full(count, np.inf), np.full(count, -np.inf)
    for block in _stretches(result, names, span, count):
        turn, values = np.searchsorted(times, block["time"], side="right") - 1, read(block)
        inside = (turn >= 0) & (turn < count)
        np.minimum.at(least, turn[inside], values[inside])
        np.maximum.at(greatest, turn[inside], values[inside])
    turning = np.isfinite(least)
    middle, hertz = (times[:-1] + times[1:]) / 2, 1 / np.diff(times)
    return TurnExtremes(middle[turning], hertz[turning], least[turning], greatest[turning])


def _stretches(
    result: Any, names: tuple[str, ...], span: Span, turns: int
) -> Iterator[dict[str, np.ndarray]]:
    """The samples block by block; where they are sparse and the turns not too many, instants between."""
    if samples_are_sparse(result.case.scene()) and 0 < turns <= PERIODS_AT_MOST:
        yield dense(result, names, span, step=(span[1] - span[0]) / (turns * PER_TURN))
    else:
        yield from blocks(result, names, span)


# Points of the Poincare section in phase portraits.


EXACT_UP_TO = 5000  # stroboscopic points that the engine evaluates; more are interpolated
POINT_PT = 2.6  # of a point of the Poincare section
Section = tuple[Subject, tuple[str, ...], Plane, Span]  # columns, and what makes the plane of them


def draw_poincare(
    axes: Axes, sections: Sequence[Section], scales: tuple[Scale, Scale], whole_turns: bool = False
) -> str:
    """Where in a phase portrait the periods of the source end (forces and base: phase 0; motor: phi = 0), as
    points, angles up to whole turns if wanted; what they are, in words, empty for runs without a period.
    """
    drawn = 0
    for subject, names, plane, span in sections:
        times = turn_times(subject.result, span)
        columns = tuple(name for name in names if name != "time")
        x, y = plane({**states_at(subject.result, columns, times, EXACT_UP_TO), "time": times})
        x = within_a_turn(x) if whole_turns else x
        drawn += len(x)
        axes.plot(
            scales[0](x), scales[1](y), linestyle="none", marker="o", markersize=POINT_PT, color=VERMILLION,
            markeredgecolor="white", markeredgewidth=0.3, zorder=3.5, gid="poincare",
        )  # fmt: skip
    return "dots: once per period" if drawn else ""


# The slow drift of a block, by which friction and impacts carry it along while it vibrates.


ROUNDING = 1e-9  # of the greatest displacement: what points of a settled motion scatter by


def drift_rate(result: Any, column: str, span: Span) -> float:
    """Velocity at which a block travels over the span while it vibrates [m/s]; x is its `column`.

    From points a multiple of the source's period apart, the median of (x(t + nT) - x(t)) / nT: exact for a
    motion whose period divides n = 12, as those of 1, 2, 3, 4 and 6 turns do, whatever transient leads to it.
    With fewer turns in the span, n is half of them; with fewer than two there is no drift to tell from the
    vibration, and it is 0. So it is where nothing but rounding moves the points, and of a block that springs
    or stops hold.
    """
    times = turn_times(result, span)
    apart = min(TURNS, len(times) // 2)
    if apart < 1 or column not in free_columns(result.case.scene()):
        return 0.0
    x = states_at(result, (column, f"v{column[1:]}"), times, EXACT_UP_TO)[column]
    times = times[: len(x)]
    rate = float(np.median((x[apart:] - x[:-apart]) / (times[apart:] - times[:-apart])))
    return rate if abs(rate) * (span[1] - span[0]) > ROUNDING * np.abs(x).max() else 0.0


def free_columns(scene: Scene) -> set[str]:
    """Columns of the displacements of the blocks that nothing holds at the ground or the base."""
    return {columns_of(scene.bodies[body].name)[0] for one in drifting_sets(scene) for body in one.bodies}


# Stroboscopic section of the relative motion: the state once per period of the source.


LEAST = 1e-2  # of the extent of the motion: the least that is shown
AT_REST = 0.1  # of a displacement: what stays there is drawn as if it moved by so much


def stroboscopic_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Relative velocity against relative displacement (`pair_of`) at the end of each period of the source.

    The last half of the run by default.
    """
    figure = sheet(view, 7.2)
    axes = figure.subplots()
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    pairs = common_pairs(subjects)
    drawn = [section(*each) for each in zip(subjects, pairs, spans, strict=True)]
    units = pairs[0].units
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
    remarks = [counted(count, "point"), *dict.fromkeys(map(seconds, spans))]
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
    """Widen axes to a share of the motion, or of where it rests: a point scatters by rounding alone."""
    traces = relative_traces(subjects, pairs, spans)
    motions = [each.x for each in traces], [each.y for each in traces]
    for axis, scale, values in zip((axes.xaxis, axes.yaxis), scales, motions, strict=True):
        low, high = axis.get_view_interval()
        every = scale(np.concatenate(values))
        top, bottom = float(np.nanmax(every)), float(np.nanmin(every))
        least = LEAST * max(top - bottom, AT_REST * max(top, -bottom))
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
    """Instants [s], closing velocities (into the stop: > 0) in `unit`, m/s or rad/s, phases of the source
    [turns]; (n). others : how many impacts in the other unit there are besides, which are not among them.
    """

    t: np.ndarray
    closing: np.ndarray
    phase: np.ndarray | None
    unit: str
    others: int

    def within(self, span: Span) -> Impacts:
        """Those within a span [s]."""
        inside = (self.t >= span[0]) & (self.t <= span[1])
        phase = None if self.phase is None else self.phase[inside]
        return replace(self, t=self.t[inside], closing=self.closing[inside], phase=phase)


def impact_velocity_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Closing velocity of each impact against time; of a settled motion its histogram and phase.

    Histogram and phases are those of the last half of the run, unless the view has a window.
    """
    window = common_window(subjects, view.window)
    of_subjects = [impacts_of(subject, window_of(subject, window)) for subject in subjects]
    spans = [_settled(subject, view, impacts) for subject, impacts in zip(subjects, of_subjects, strict=True)]
    settled = [impacts.within(span) for impacts, span in zip(of_subjects, spans, strict=True)]
    paths = [subject.path for subject in subjects]
    units = [impacts.unit for impacts in of_subjects]
    check_one_unit("impacts", list(zip(paths, units, strict=True)))
    scale = scale_for(units[0], *(impacts.closing for impacts in of_subjects))
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
    words = counted(count, "impact")
    listed = "; ".join(dict.fromkeys(map(seconds, spans[1])))
    others = sum(impacts.others for impacts in settled)
    left_out = f"{others} in {'rad/s' if settled[0].unit == 'm/s' else 'm/s'} not shown" if others else ""
    if over_phase is None:
        note(over_time, "; ".join(filter(None, [trust, left_out, f"histogram: {words}, {listed}"])))
        return
    note(over_time, "; ".join(filter(None, [trust, left_out])))
    note(over_phase, f"{words}, {listed}")
    if len(listed) <= LONGEST_NOTE:
        note(histogram, listed)


def impacts_of(subject: Subject, span: Span) -> Impacts:
    """The impacts of a run within the span, at all its stops in the unit of the one that is struck most; the
    phase is that of the common period of the forces and the base, or the angle of the rotor.
    """
    scene, part = subject.scene, shown_part(subject)
    unit = scene.unit_between(part.P, part.Q)
    alike = [i for i, stop in enumerate(scene.stops) if scene.unit_between(stop.P, stop.Q) == unit]
    events = events_within(subject.result, None, span)
    t, closing = events["t"], closing_velocities(scene, events)
    impacts, period = ~np.isnan(closing), common_period(scene)
    rows = impacts & np.isin(events["part"], alike)
    t, closing, phase = t[rows], closing[rows], None
    turning = turning_columns(scene)
    if turning is not None:
        phase = np.mod(events[turning[0]][rows] / (2 * math.pi), 1.0)
    elif period is not None:
        phase = np.mod((t * period.cycles + t * period.cycles_lo) / period.turns, 1.0)
    return Impacts(t, closing, phase, f"{unit}/s", int(impacts.sum() - rows.sum()))


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

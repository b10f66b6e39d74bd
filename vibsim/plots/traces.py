"""Curves in a plane of state variables, honest about what is drawn and small on the page; and the two
bodies whose motion against each other is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from vibsim.cases.problems import counted
from vibsim.physics.connections import formulas_of, pairs_of, whole_turn_angles
from vibsim.physics.formulas import walk
from vibsim.physics.parts import GROUND
from vibsim.plots.samples import (
    blocks,
    difference,
    events_within,
    impact_times,
    impacts_of,
    rows,
    samples,
    shortest_period,
    source_period,
    stop_label,
    stop_position,
    stops_between,
    window_of,
)
from vibsim.plots.sheet import Scale, above_wider, label_axes, note, pixel_columns, plain_symbols
from vibsim.plots.style import GREY, SHADE, points
from vibsim.plots.subject import PlotError, Span, Subject, as_text, measured, unit_for
from vibsim.results.columns import IMPACT_CODES, PairMotion

Block = Mapping[str, np.ndarray]
Plane = Callable[[Block], tuple[np.ndarray, np.ndarray]]

SMOOTH_UP_TO = 20_000  # samples: a span up to this gets instants between its samples
LINE_UP_TO = 200_000  # samples: up to this a line joins them; beyond, one dot per pixel
VECTOR_UP_TO = 20_000  # points: larger ones are pixels in a PDF or SVG, at 600 dpi
TURN = 2 * np.pi
UP_TO_TURNS = "angle up to whole turns"  # what a picture with folded angles says
REST_PT = 3.0  # of the point that a motion at rest is
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


def folded_angles(scene: Any) -> list[int]:
    """Numbers of the bodies whose angle is drawn up to whole turns: those that forces bring back to where
    they were, as of a pendulum; not a shaft whose angle no force feels.
    """
    read = set(walk(one.formula for one in formulas_of(scene))) if scene.has_formulas else set()
    return [i for i in whole_turn_angles(scene) if ("x", i) in read]


def folded(drawn: Trace) -> Trace:
    """A trace whose x is an angle up to whole turns, within half a turn of 0: as a line it is broken where it
    goes from one turn into the next.
    """
    breaks = np.flatnonzero(np.diff(_turns(drawn.x))) + 1 if drawn.joined else np.empty(0, dtype=int)
    x, y = (np.insert(each, breaks, np.nan) for each in (within_a_turn(drawn.x), drawn.y))
    return Trace(x, y, drawn.joined)


def within_a_turn(angles: np.ndarray) -> np.ndarray:
    """Angles [rad] up to whole turns, within half a turn of 0."""
    return angles - TURN * _turns(angles)


def _turns(angles: np.ndarray) -> np.ndarray:
    return np.round(angles / TURN)


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
    if len(x) and not (np.ptp(x) or np.ptp(y)):  # at rest: a line of no length shows nothing
        look |= {"marker": "o", "markersize": REST_PT}
        x, y = x[:1], y[:1]
    axes.plot(x, y, rasterized=len(x) > VECTOR_UP_TO, **{"linewidth": 0.5, **look})


def draw_impacts(axes: Axes, impacts: Trace, scales: tuple[Scale, Scale], colour: Any) -> None:
    """Mark impacts on a trace: rings, or dots where they are many."""
    few = len(impacts.x) <= RINGS_UP_TO
    axes.plot(
        scales[0](impacts.x), scales[1](impacts.y), linestyle="none", marker="o", zorder=3,
        markersize=2.4 if few else 1.4, markeredgewidth=0.5 if few else 0, color=colour if few else "black",
        markerfacecolor="white" if few else "black", gid="impacts",
    )  # fmt: skip


# A short stretch of a run as smooth as the motion: samples, events, and instants between them.


PER_PERIOD = 40  # instants per shortest period: chords of 9 degrees, round at any print size
AT_MOST = 40_000  # instants to be evaluated


def dense(
    result: Any, names: tuple[str, ...], span: Span, step: float | None = None
) -> dict[str, np.ndarray]:
    """Columns `time` and `names` within the span, the events, and instants between them.

    Every sample and every event within the span is among the rows, as stored, and before an event at which
    velocities jump the state in front of it; the instants between are evaluated by the engine, further
    apart where the span is too long for all of them. A span with too many events comes back as samples alone.
    """
    names = tuple(name for name in names if name != "time")
    stored = samples(result, ("time", *names), span)
    if len(events_within(result, ("t",), span)["t"]) > AT_MOST:
        return stored
    between = _instants_between(stored["time"], span, step or _fine_step(result.case.scene()))
    between = between[between <= result.t_reached]  # of a run that was killed, samples may reach further
    before, after = _event_rows(result, names, span)
    # a sample at the instant of an event is the state after it
    parts = [before, stored, after, {**states_at(result, names, between), "time": between}]
    order = np.argsort(np.concatenate([part["time"] for part in parts]), kind="stable")
    return {name: np.concatenate([part[name] for part in parts])[order] for name in stored}


def _event_rows(result: Any, names: tuple[str, ...], span: Span) -> tuple[dict[str, np.ndarray], ...]:
    """Columns `time` and `names` of the events within the span: the states in front of them, and after."""
    before = {name: f"before_{name}" for name in names if f"before_{name}" in result.events}
    events = events_within(result, ("t", *names, *before.values()), span)
    after = {"time": events["t"], **{name: events[name] for name in names}}
    if not before:
        return {name: values[:0] for name, values in after.items()}, after
    return after | {name: events[column] for name, column in before.items()}, after


def states_at(result: Any, names: tuple[str, ...], times: np.ndarray) -> dict[str, np.ndarray]:
    """Columns `names` at ascending instants `times` (n) [s], the engine restarted from stored events.

    As `result.at`, but of a file only the events between the first and the last instant are read.
    """
    from vibsim.results.columns import states_at as restarted

    if not len(times):
        return {name: np.empty(0) for name in names}
    events = events_within(result, None, (float(times[0]), float(times[-1])), before=1)
    states = restarted(result.case.scene(), events, times, result.t_reached)
    return {name: states[name] for name in names}


def samples_are_sparse(scene: Any) -> bool:
    """Whether a line through the samples would miss vibrations: fewer than four to a period of the source."""
    period = source_period(scene)
    return period is not None and scene.sample_time(1) > period / 4


def _fine_step(scene: Any) -> float | None:
    period = shortest_period(scene)
    return None if period is None else period / PER_PERIOD


def _instants_between(time: np.ndarray, span: Span, step: float | None) -> np.ndarray:
    """Equally spaced instants between the samples [s], at most about AT_MOST."""
    knots = np.unique(np.concatenate([[span[0]], time, [span[1]]]))
    if step is None:
        return np.empty(0)
    pieces = np.maximum(np.ceil(np.diff(knots) / step), 1)
    if pieces.sum() > AT_MOST:
        pieces = np.maximum(np.floor(pieces * (AT_MOST / pieces.sum())), 1)
    within = (pieces - 1).astype(int)
    nth = np.arange(within.sum()) - np.repeat(np.cumsum(within) - within, within) + 1
    instants: np.ndarray = np.repeat(knots[:-1], within) + nth * np.repeat(np.diff(knots) / pieces, within)
    return instants


# Cubic Hermite interpolation between samples of a function and its derivative.


NEWTON_STEPS = 6  # quadratic from an error below the interval: 1 -> 2^-64 of it


def hermite(
    t: np.ndarray, f: np.ndarray, slope: np.ndarray, left: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Value and derivative (n) at the instants `at` (n), in the intervals that begin with samples `left`."""
    h = t[left + 1] - t[left]
    return _cubic((at - t[left]) / h, h, f[left], f[left + 1], slope[left], slope[left + 1])


def _cubic(
    s: np.ndarray, h: np.ndarray, f0: np.ndarray, f1: np.ndarray, d0: np.ndarray, d1: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Value and time derivative at s in [0, 1] of intervals of length h, end values f, slopes d."""
    a, b = h * d0 - (f1 - f0), (f1 - f0) - h * d1
    value = (1 - s) * f0 + s * f1 + s * (1 - s) * ((1 - s) * a + s * b)
    derivative = f1 - f0 + (1 - 2 * s) * ((1 - s) * a + s * b) + s * (1 - s) * (b - a)
    return value, derivative / h


def root_time(
    t0: np.ndarray,
    t1: np.ndarray,
    f0: np.ndarray,
    f1: np.ndarray,
    d0: np.ndarray,
    d1: np.ndarray,
    target: np.ndarray,
) -> np.ndarray:
    """Instants (n) at which the interpolant passes `target`, between f0 and f1: Newton, kept inside."""
    h = t1 - t0
    s = np.clip((target - f0) / (f1 - f0), 0.0, 1.0)
    for _ in range(NEWTON_STEPS):
        value, derivative = _cubic(s, h, f0, f1, d0, d1)
        steep = np.where(derivative == 0, 1.0, derivative)
        s = np.clip(s - np.where(derivative == 0, 0.0, (value - target) / (steep * h)), 0.0, 1.0)
    return np.asarray(t0 + s * h)


# Long portraits reduced to one sample per pixel.


Blocks = Callable[[], Iterable[tuple[np.ndarray, np.ndarray]]]


def one_per_pixel(blocks: Blocks, pixels: tuple[int, int] = (1200, 900)) -> tuple[np.ndarray, np.ndarray]:
    """The first sample (x, y) to fall into each pixel of the picture, of a series too long to draw.

    Parameters
    ----------
    blocks : called twice, yields the series block by block as (x, y), each (n)
    pixels : size of the grid laid over the range of the data

    Every point returned is a sample, and no sample lies farther than one pixel from a point returned.
    """
    x_low, x_span, y_low, y_span = _range(blocks)
    wide, high = pixels
    painted = np.zeros(wide * high, dtype=bool)
    kept_x, kept_y = [], []
    for x, y in blocks():
        column = np.minimum(((x - x_low) / x_span * wide).astype(np.int64), wide - 1)
        row = np.minimum(((y - y_low) / y_span * high).astype(np.int64), high - 1)
        pixel, first = np.unique(row * wide + column, return_index=True)
        first = first[~painted[pixel]]
        painted[pixel] = True
        kept_x.append(x[first])
        kept_y.append(y[first])
    return np.concatenate(kept_x), np.concatenate(kept_y)


def _range(blocks: Blocks) -> tuple[float, float, float, float]:
    x_low = y_low = np.inf
    x_high = y_high = -np.inf
    for x, y in blocks():
        x_low, x_high = min(x_low, x.min()), max(x_high, x.max())
        y_low, y_high = min(y_low, y.min()), max(y_high, y.max())
    return x_low, (x_high - x_low) or 1.0, y_low, (y_high - y_low) or 1.0


# The two bodies whose motion against each other is drawn, and the stops between them.


@dataclass(frozen=True)
class PlottedPair:
    """Two bodies, or a body and ground or base.

    Attributes
    ----------
    names : columns of a run that their relative motion needs
    plane : from these to relative displacement [m] and velocity [m/s]
    displacement, velocity : symbols of these
    words : their names in words: relative ones of two ends that may move, angles of ends that turn
    units : their SI units, m and m/s or rad and rad/s
    stops : relative displacement [m] at which each stop between them is met, and its name
    belts : relative velocity [m/s] at which the body rides on each belt between them, and its name
    whole_turns : whether it is an angle that whole turns bring back to where it was, as of a pendulum
    """

    names: tuple[str, ...]
    plane: Plane
    displacement: str
    velocity: str
    words: tuple[str, str]
    units: tuple[str, str]
    stops: tuple[tuple[float, str], ...]
    belts: tuple[tuple[float, str], ...] = ()
    whole_turns: bool = False


def pair_of(subject: Subject) -> PlottedPair:
    """The ends of the stop that is struck most often, else of the first link, else of the first friction,
    else the first body and ground.
    """
    scene, part = subject.scene, shown_part(subject)
    motion = PairMotion(scene, part)

    def plane(block: Any) -> tuple[np.ndarray, np.ndarray]:
        _, x, v = motion.above_rounding(block, "time")
        return x, v

    x, v = (difference(scene, part, letter) for letter in "xv")
    turning, relative = scene.unit_between(part.P, part.Q) == "rad", "relative " if " - " in x else ""
    first, second = (f"{relative}{measured(unit, turning)}".capitalize() for unit in ("m", "m/s"))
    units = unit_for("m", turning), unit_for("m/s", turning)
    stops = [(stop_position(stop, part), stop_label(stop)) for stop in stops_between(scene, part)]
    turns = part.Q == GROUND and part.P in folded_angles(scene)
    names, belts = ("time", *motion.columns), tuple(_belts(scene, part))
    return PlottedPair(names, plane, x, v, (first, second), units, tuple(stops), belts, turns)


def _belts(scene: Any, part: Any) -> Iterator[tuple[float, str]]:
    """Velocities v_P - v_Q of a part at which the ends stick on the belts between them, which move evenly."""
    for friction in scene.frictions:
        if (
            {friction.P, friction.Q} == {part.P, part.Q}
            and isinstance(friction.belt, float)
            and friction.belt
        ):
            yield (friction.belt if friction.P == part.P else -friction.belt), as_text(friction.name)


def columns_beside(subject: Subject, pair: PlottedPair) -> tuple[str, ...]:
    """Columns of the displacements in the unit of a pair, of all bodies that have it."""
    columns = subject.columns_in("m")
    return tuple(name for name in columns if subject.unit("m", name) == pair.units[0])


def common_pairs(subjects: Sequence[Subject]) -> list[PlottedPair]:
    """The pair of each subject; PlotError where they are not the motion of the same ends."""
    pairs = [pair_of(subject) for subject in subjects]
    if len({pair.displacement for pair in pairs}) > 1:
        several = ", ".join(plain_symbols(pair.displacement) for pair in pairs)
        raise PlotError(f"no relative motion is common to the runs: {several}; draw them one by one")
    return pairs


def relative_traces(
    subjects: Sequence[Subject], pairs: Sequence[PlottedPair], spans: Sequence[Span]
) -> list[Trace]:
    """The relative motion of each subject's pair within its span [s]."""
    drawn = [
        trace(subject.result, pair.names, pair.plane, span)
        for subject, pair, span in zip(subjects, pairs, spans, strict=True)
    ]
    return [folded(one) if pair.whole_turns else one for one, pair in zip(drawn, pairs, strict=True)]


def label_relative(axes: Axes, pair: PlottedPair, scales: tuple[Scale, Scale]) -> None:
    """Name the relative displacement of a pair across, its velocity upwards."""
    across, up = pair.words
    label_axes(axes, (across, scales[0].label(pair.displacement)), (up, scales[1].label(pair.velocity)))


def draw_belts(axes: Axes, pair: PlottedPair, scale: Scale) -> None:
    """The velocities of belts as dashed lines across the axes, named at the right."""
    for velocity, name in pair.belts:
        at = float(scale(velocity))
        axes.axhline(at, color=GREY, linewidth=0.6, linestyle=(0, (4, 2)), zorder=0, gid="belt")
        beside = ("top", -2) if velocity > 0 else ("bottom", 2)  # towards the middle of the picture
        axes.annotate(
            f"velocity of {name}", (1, at), (-3, beside[1]), xycoords=("axes fraction", "data"),
            textcoords="offset points", ha="right", va=beside[0], fontsize=points(6.5), color=GREY, zorder=4,
        )  # fmt: skip


def shown_part(subject: Subject) -> Any:
    """The part whose ends a relative motion is of, see `pair_of`."""
    scene = subject.scene
    if not scene.stops:
        return pairs_of(scene)[0]
    if len(scene.stops) == 1:
        return scene.stops[0]
    events = subject.result.events
    part = np.asarray(events["part"])[np.isin(np.asarray(events["kind"]), IMPACT_CODES)]
    return scene.stops[int(np.argmax(np.bincount(part, minlength=len(scene.stops))))]


# Marks on a time axis: where the impacts are, and until when each run is right.


HATCHES = ("////", "\\\\\\\\")  # of runs in turn: crossed where two of them are wrong
SPELT_OUT = 3  # trust horizons given in numbers


def annotate_runs(
    axes: Axes,
    subjects: Sequence[Subject],
    span: Span,
    colours: Sequence[Any] = (GREY,),
    impacts: bool = True,
) -> None:
    """The trust horizon of each run; for a single one also ticks for the impacts (where wanted); a note."""
    alone = subjects[0] if len(subjects) == 1 else None
    remarks = [
        impact_ticks(axes, alone, span) if impacts and alone else "",
        trust_marks(axes, subjects, span, colours),
    ]
    if alone and samples_are_sparse(alone.scene):
        remarks.append(f"samples every {alone.scene.sample_time(1):g} s")
    incomplete = [subject.name for subject in subjects if not subject.result.complete]
    if incomplete:
        remarks.append("incomplete run" if alone else f"incomplete: {', '.join(incomplete)}")
    note(axes, "; ".join(remark for remark in remarks if remark))


def impact_ticks(axes: Axes, subject: Subject, span: Span) -> str:
    """A tick below for every impact, as far as pixels can tell them apart; their number in words."""
    if not subject.scene.has_stop:
        return ""
    t = impact_times(subject.result, window_of(subject, span))
    pixel = ((t - span[0]) / (span[1] - span[0]) * pixel_columns(axes)).astype(int)
    distinct = t[np.unique(pixel, return_index=True)[1]]
    axes.plot(
        distinct, np.zeros(len(distinct)), linestyle="none", marker=2, markersize=2.2, markeredgewidth=0.3,
        color="0.6", transform=axes.get_xaxis_transform(), gid="impacts",
    )  # fmt: skip
    return counted(len(t), "impact")


def horizon_within(subject: Subject, span: Span) -> float | None:
    """The trust horizon [s] of a run where it lies before the end of what is shown, else None."""
    horizon = subject.result.trust_horizon
    return None if horizon is None or horizon >= min(span[1], subject.result.t_reached) else float(horizon)


def trust_remark(subjects: Sequence[Subject], spans: Sequence[Span], marked: bool = False) -> str:
    """The trust horizons of runs that end before what is shown of them, in words; empty where all is right.

    marked : whether the picture hatches what lies beyond
    """
    ends = [horizon_within(subject, span) for subject, span in zip(subjects, spans, strict=True)]
    horizons = [(end, span) for end, span in zip(ends, spans, strict=True) if end is not None]
    if not horizons:
        return ""
    plural = "s" if len(horizons) > 1 else ""
    digits = 4 if len(subjects) == 1 else 3
    listed = (
        f"{', '.join(f'{end:.{digits}g}' for end, _ in horizons)} s" if len(horizons) <= SPELT_OUT else ""
    )
    if all(end <= span[0] for end, span in horizons):
        return f"beyond the trust horizon{plural}" + (f", {listed}" if listed else "")
    return " ".join(
        filter(
            None,
            [f"trust horizon{plural}", listed, "(hatched beyond)" if marked and len(subjects) == 1 else ""],
        )
    )


def trust_marks(axes: Axes, subjects: Sequence[Subject], span: Span, colours: Sequence[Any] = (GREY,)) -> str:
    """Hatch what lies beyond a run's trust horizon, behind a dotted line; in words, empty where all is right.

    Of several runs each has lines of its own of the `colours`. A span that lies beyond as a whole is only
    said to.
    """
    alone = len(subjects) == 1
    for i, (subject, colour) in enumerate(zip(subjects, colours, strict=True)):
        horizon = horizon_within(subject, span)
        if horizon is None or horizon <= span[0]:
            continue
        axes.axvspan(
            horizon, span[1], facecolor="none", edgecolor=SHADE if alone else to_rgba(colour, 0.25),
            hatch=HATCHES[i % 2], linewidth=0, zorder=0, gid="beyond-trust",
        )  # fmt: skip
        axes.axvline(horizon, color=colour, linewidth=0.8, linestyle=(0, (1, 1.5)), gid="trust-horizon")
    return trust_remark(subjects, [span] * len(subjects), marked=True)


def mark_detail(axes: Axes, span: Span) -> None:
    """A frame about the span that another panel enlarges."""
    axes.axvspan(*span, facecolor="none", edgecolor="0.2", linewidth=0.7, zorder=3, gid="detail")

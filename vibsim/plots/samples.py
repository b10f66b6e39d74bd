"""Samples and events of a run within a span, and the stops and names of a relative motion.

Samples are read window by window and block by block, so that memory does not grow with the file.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Text

from vibsim.cases.problems import counted
from vibsim.engine.columns import part_columns
from vibsim.engine.modes.status import CONTACT, RESTING
from vibsim.physics import rates
from vibsim.physics.parts import BASE, GROUND, Motor, RigidStop, Scene, Stop, columns_of
from vibsim.physics.rates import motor_columns, turning_columns
from vibsim.physics.two_blocks import is_papers
from vibsim.plots.sheet import FONT_SIZE, LINE_HEIGHT, Scale, hertz_text, seconds, spread, symbol
from vibsim.plots.style import GREY, points
from vibsim.plots.subject import PlotError, Span, Subject, View, as_text
from vibsim.results.columns import IMPACT_CODES

BLOCK = 1 << 18  # rows: 2 MB per column
SHORTEST = 10  # windows without samples to the shortest period, at most
POINTS_PER_COLUMN = 4  # what an envelope keeps; a series shorter than that is drawn as it is

Series = tuple[np.ndarray, np.ndarray]


def whole_span(result: Any) -> Span:
    """First and last sampled instant [s]."""
    time = result.column("time")
    if len(time) < 2:
        raise PlotError(f"{result.case.name}: the run holds {counted(len(time), 'sample')}: nothing to draw")
    return float(time[0]), float(time[-1])


def window_of(subject: Subject, asked: Span | None) -> Span:
    """The part of `asked` (None: everything) that the run covers; PlotError when it covers nothing of it."""
    first, last = whole_span(subject.result)
    if asked is None:
        return first, last
    window = max(first, asked[0]), min(last, asked[1])
    if not window[0] < window[1]:
        covered = f"{subject.path}, which covers {first:g} to {last:g} s"
        raise PlotError(f"window {asked[0]:g}:{asked[1]:g} lies outside {covered}")
    _check_length(subject, window)
    return window


def _check_length(subject: Subject, window: Span) -> None:
    """PlotError for a window of fewer than two samples in which hardly anything moves: an empty picture."""
    within, period = rows(subject.result, window), shortest_period(subject.scene)
    if within.stop - within.start < 2 and (period is None or window[1] - window[0] < period / SHORTEST):
        shown = f"{window[0]:.9g}:{window[1]:.9g}"
        raise PlotError(f"window {shown} is too short: {subject.path} has nothing to draw in it")


def shown(subject: Subject, asked: Span | None, fallback: Callable[[Subject, Span], Span]) -> Span:
    """The part of `asked` that the run covers; without a wish, what `fallback` makes of all."""
    window = window_of(subject, asked)
    return fallback(subject, window) if asked is None else window


def common_window(subjects: Sequence[Subject], asked: Span | None) -> Span:
    """From the earliest to the latest instant that any of the subjects shows of `asked`."""
    windows = [window_of(subject, asked) for subject in subjects]
    return min(first for first, _ in windows), max(last for _, last in windows)


def shared_window(subjects: Sequence[Subject], asked: Span | None) -> Span:
    """The span that all the subjects cover, of `asked`."""
    windows = [window_of(subject, asked) for subject in subjects]
    return max(first for first, _ in windows), min(last for _, last in windows)


def rows(result: Any, span: Span) -> slice:
    """The samples within the span, both ends included."""
    time = result.column("time")
    return slice(bisect_left(time, span[0]), bisect_right(time, span[1]))


def blocks(result: Any, names: tuple[str, ...], span: Span) -> Iterator[dict[str, np.ndarray]]:
    """The samples within the span: blocks of columns by name, each up to BLOCK rows."""
    within = rows(result, span)
    for start in range(within.start, within.stop, BLOCK):
        part = slice(start, min(start + BLOCK, within.stop))
        yield {name: np.asarray(result.column(name)[part]) for name in names}


def samples(result: Any, names: tuple[str, ...], span: Span) -> dict[str, np.ndarray]:
    """All samples within the span, for spans known to be short."""
    within = rows(result, span)
    return {name: np.asarray(result.column(name)[within]) for name in names}


def series(result: Any, names: tuple[str, ...], span: Span, columns: int) -> dict[str, Series]:
    """Columns against time within the span, (t, values); envelopes where there is more than can be seen.

    columns : pixel columns across the axes
    """
    within = rows(result, span)
    if within.stop - within.start <= POINTS_PER_COLUMN * columns:
        values = samples(result, ("time", *names), span)
        return {name: (values["time"], values[name]) for name in names}
    envelopes = {name: Envelope(*span, columns) for name in names}
    for block in blocks(result, ("time", *names), span):
        for name, envelope in envelopes.items():
            envelope.add(block["time"], block[name])
    return {name: envelope.points() for name, envelope in envelopes.items()}


# Long series reduced to what a picture can show, without losing an extreme.
#
# Of all samples that fall into one pixel column, a drawn line shows the first, the least, the greatest and
# the last; the others cannot be seen. Keeping those four (the M4 aggregation, Jugel, Jerzak, Hackenbroich and
# Markl, "M4: a visualization-oriented time series data aggregation", PVLDB 7, 2014) leaves the picture as it
# was.


FIRST, LEAST, GREATEST, LAST = range(4)


class Envelope:
    """First, least, greatest and last sample of every pixel column, fed block by block.

    Parameters
    ----------
    start, stop : the span of the axis [s]
    columns : number of pixel columns across it

    Memory is 8 numbers per column, whatever the length of the series.
    """

    def __init__(self, start: float, stop: float, columns: int) -> None:
        self._start, self._columns = start, columns
        self._per_second = columns / (stop - start) if stop > start else 0.0
        self._t = np.full((columns, 4), np.nan)
        self._value = np.full((columns, 4), np.nan)

    def add(self, t: np.ndarray, values: np.ndarray) -> None:
        """Take in the next samples: ascending instants t (n) [s] and values (n)."""
        column = np.clip(((t - self._start) * self._per_second).astype(np.int64), 0, self._columns - 1)
        first = np.flatnonzero(np.diff(column, prepend=-1))
        for begin, end in zip(first, [*first[1:], len(t)], strict=True):
            self._merge(int(column[begin]), t[begin:end], values[begin:end])

    def _merge(self, column: int, t: np.ndarray, values: np.ndarray) -> None:
        kept_t, merged = self._t[column], self._value[column]
        rows = (0, int(np.argmin(values)), int(np.argmax(values)), len(t) - 1)
        fresh = np.isnan(kept_t[FIRST])
        replace = (
            fresh,
            fresh or values[rows[LEAST]] < merged[LEAST],
            fresh or values[rows[GREATEST]] > merged[GREATEST],
            True,
        )
        for which, row in enumerate(rows):
            if replace[which]:
                kept_t[which], merged[which] = t[row], values[row]

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """The samples kept, (t, values), in ascending time and without repetition."""
        filled = ~np.isnan(self._t[:, FIRST])
        t, order = self._t[filled], np.argsort(self._t[filled], axis=1, kind="stable")
        t = np.take_along_axis(t, order, axis=1).ravel()
        values = np.take_along_axis(self._value[filled], order, axis=1).ravel()
        distinct = np.diff(t, prepend=-np.inf) > 0
        return t[distinct], values[distinct]


# Frequencies at which the scene itself likes to vibrate, and the rhythm of its source.


MOST = 6  # natural frequencies that are named


@dataclass(frozen=True)
class Frequency:
    """A frequency [Hz] and its name, plain and as a mathtext label."""

    name: str
    label: str
    hz: float

    @property
    def text(self) -> str:
        """Label and value, as they stand beside a line."""
        return f"{self.label}  {hertz_text(self.hz)}"


def natural_frequencies(scene: Scene) -> list[Frequency]:
    """Linear and bilinear frequencies of the vibration (without friction and damping).

    Of the paper's two blocks sqrt(k1 / m1), the paper's natural frequency (block 2 held), and free-free: the
    blocks against each other, the motor's m3 counted to block 1; of other scenes f1, f2, ... with all stops
    open. Where there is one vibration with a stop, f1 without and f2 with the stop give the bilinear
    2 f1 f2 / (f1 + f2), the limit of large amplitudes, and half of it (a subharmonic of the impacting
    motion).
    """
    hertz = [rate / (2 * math.pi) for rate in rates.natural_rates(scene)]
    frequencies = _papers(scene, hertz[0]) if hertz and is_papers(scene) else []
    frequencies = frequencies or [
        Frequency(f"f{i}", f"$f_{{{i}}}$", hz) for i, hz in enumerate(hertz[:MOST], 1)
    ]
    bilinear = rates.bilinear_frequencies(scene)
    if len(bilinear) == 1:
        frequencies.append(Frequency("bilinear", "bilinear", bilinear[0]))
        frequencies.append(Frequency("half bilinear", "½ bilinear", bilinear[0] / 2))
    return frequencies


def _papers(scene: Scene, free: float) -> list[Frequency]:
    """Those of the two blocks of the paper, or of block 1 before a wall."""
    coupling = scene.links[0]
    held = rates.frequency(coupling.k, scene.bodies[coupling.P].m)
    frequencies = [Frequency("held", r"$\sqrt{k_1/m_1}$", held)]
    if coupling.Q != GROUND:
        frequencies.append(Frequency("free-free", "free–free", free))
    elif scene.has_motor:
        frequencies.append(Frequency("with motor", r"$\sqrt{k_1/(m_1+m_3)}$", free))
    return frequencies


def fractions(scene: Scene) -> list[Frequency]:
    """Fractions of the frequencies at which a motion with impacts may resonate too.

    q/p of the bilinear frequency: p impacts in q turns of the source. Half of it is in `natural_frequencies`.
    """
    frequencies = {frequency.name: frequency for frequency in natural_frequencies(scene)}
    if "bilinear" not in frequencies:
        return []
    own = next(frequencies[name] for name in ("free-free", "with motor", "held", "f1") if name in frequencies)
    parts = [("⅓ ", 1 / 3, frequencies["bilinear"]), ("⅔ ", 2 / 3, frequencies["bilinear"])]
    parts += [("¾ ", 3 / 4, frequencies["bilinear"]), ("½ ", 1 / 2, own), ("⅓ ", 1 / 3, own)]
    return [Frequency(sign + whole.name, sign + whole.label, part * whole.hz) for sign, part, whole in parts]


def source_period(scene: Scene, phidot: float | None = None) -> float | None:
    """Period of the source [s]; of the free vibration without one; None where nothing has a rhythm.

    phidot : mean speed of the motor, or of the rotor that turns the scene [rad/s], where known; the no-load
        speed of a motor otherwise
    """
    if phidot:
        return 2 * math.pi / abs(phidot)
    period = rates.source_period(scene)
    return period if math.isfinite(period) else None


def motor_of(scene: Scene) -> Motor:
    """The motor of a scene that has one."""
    assert scene.motor is not None
    return scene.motor


def shortest_period(scene: Scene) -> float | None:
    """Shortest period in the motion [s]: of a source or of the vibration with all stops in contact."""
    rates_of_scene = [*rates.source_rates(scene), *rates.natural_rates(scene, scene.stops)]
    return 2 * math.pi / max(rates_of_scene) if rates_of_scene else None


# Natural frequencies on a frequency axis: a thin line through every panel, the name above the first.


NAME_PT = 8  # names above the axes
TITLE_PT = 9  # and above a title


def mark_frequencies(panels: Sequence[Axes], frequencies: Sequence[Frequency], width_pt: float) -> None:
    """Mark the frequencies within the x limits.

    Titles of the panels come before it.

    width_pt : width of the axes [pt], as far as it is known before layout
    """
    low, high = panels[0].get_xlim()
    inside = sorted((f for f in frequencies if low <= f.hz <= high), key=lambda f: f.hz)
    at = np.array([(f.hz - low) / (high - low) for f in inside])
    places = spread(at, points(FONT_SIZE) * LINE_HEIGHT / width_pt)
    titles = [panels[0].get_title(loc) for loc in ("left", "right")]
    above = NAME_PT + TITLE_PT * max(len(title.split("\n")) if title else 0 for title in titles)
    over_lines = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
    for text in panels[0].findobj(Text):
        if text.get_text() and text.get_text() in titles:
            text.set(zorder=5, bbox=over_lines)
    for frequency, x, place in zip(inside, at, places, strict=True):
        for axes in panels:
            axes.axvline(
                frequency.hz, color=GREY, linewidth=0.5, linestyle=(0, (4, 2)), zorder=1, gid="frequency"
            )
        panels[0].annotate(
            frequency.text, (x, 1.0), (place, above),
            xycoords="axes fraction", textcoords=("axes fraction", "offset points"),
            ha="center", va="bottom", rotation=90, fontsize=points(FONT_SIZE), color="0.25",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": GREY, "shrinkA": 1, "shrinkB": 0},
        )  # fmt: skip


# The stops in the plane of a relative motion, and what motions of two ends against each other are called.


DISPLACEMENT = "$x_1 - x_2$"
VELOCITY = "$v_1 - v_2$"
LEFT = 0.1  # of the width: a stop within it has its name to the right
STOP = "stop"  # what the short form of a case calls its stop
PAPERS = (STOP, "coupling")  # and all that is between its blocks


def difference(scene: Scene, part: Any, letter: str) -> str:
    """x_P - x_Q, or with v, in symbols; a term at rest left out, the base in capitals."""
    if part.name in PAPERS and is_papers(scene):
        return {"x": DISPLACEMENT, "v": VELOCITY}[letter]  # a fixed block 2 too
    first, second = (
        "" if end == GROUND else letter.upper() if end == BASE else _symbol(scene, end, letter)
        for end in (part.P, part.Q)
    )
    return f"${first} - {second}$" if first and second else f"${first}$" if first else f"$-{second}$"


def _symbol(scene: Scene, end: int, letter: str) -> str:
    return symbol(f"{letter}_{scene.end_name(end)}").strip("$")


def stop_position(stop: Stop | RigidStop, part: Any) -> float:
    """x_P - x_Q of a part between the same ends at which the stop is met [m]."""
    position = -stop.sense * stop.gap
    return float(position if stop.P == part.P else -position)


def stops_between(scene: Scene, part: Any) -> list[Stop | RigidStop]:
    """The stops between the ends of a part."""
    return [stop for stop in scene.stops if {stop.P, stop.Q} == {part.P, part.Q}]


def stop_label(stop: Stop | RigidStop) -> str:
    """Label of a stop beside its line: its name; its equation for the paper's stop."""
    if stop.name != STOP:
        return as_text(stop.name)
    return "$x_2 - x_1 = G$" if stop.sense > 0 else "$x_1 - x_2 = G$"


def draw_stop_line(axes: Axes, position: float, scale: Scale, text: str) -> None:
    """A stop at a relative displacement [m] as a dashed line across the axes, a text above it."""
    at = float(scale(position))
    axes.axvline(at, color=GREY, linewidth=0.6, linestyle=(0, (4, 2)), zorder=0, gid="stop")
    low, high = axes.get_xlim()
    at_the_left = at - low < LEFT * (high - low)  # where the letter of the panel stands
    if text:
        axes.annotate(
            text, (at, 1), (0, 2), xycoords=("data", "axes fraction"), textcoords="offset points",
            ha="left" if at_the_left else "center", va="bottom", fontsize=points(7), color=GREY,
        )  # fmt: skip


# Events of a run within a span, and the impacts among them: contact begins, or a rigid stop is struck.


Events = dict[str, np.ndarray]
PUSHING = (CONTACT, RESTING)  # a lifted stop exerts no force


def events_within(result: Any, names: tuple[str, ...] | None, span: Span, before: int = 0) -> Events:
    """Event columns by name within the span, both ends included; of a file only those rows are read.

    Parameters
    ----------
    names : columns, or None for all
    before : how many events before the span to add, as far as there are any
    """
    column = getattr(result.events, "column", result.events.__getitem__)
    t = column("t")
    first = max(0, bisect_left(t, span[0]) - before)
    if before and first:
        first = bisect_left(t, t[first])  # all events of that instant
    within = slice(first, bisect_right(t, span[1]))
    return {name: np.asarray(column(name)[within]) for name in (result.events if names is None else names)}


def impact_events(result: Any, span: Span, *names: str) -> tuple[np.ndarray, ...]:
    """Times [s] and the columns `names` of the impacts within the span."""
    events = events_within(result, ("t", "kind", *names), span)
    rows = np.isin(events["kind"], IMPACT_CODES)
    return (events["t"][rows], *(events[name][rows] for name in names))


def impact_times(result: Any, span: Span) -> np.ndarray:
    """Instants of the impacts within the span [s], ascending."""
    return impact_events(result, span)[0]


def impacts_of(subject: Subject, span: Span, column: str, *others: str) -> tuple[np.ndarray, ...]:
    """Times [s] and columns of the impacts within the span in which the body of `column` takes part."""
    t, part, *values = impact_events(subject.result, span, "part", column, *others)
    rows = np.isin(part, stops_of(subject.scene, column))
    return (t[rows], *(value[rows] for value in values))


def stops_of(scene: Scene, column: str) -> list[int]:
    """Numbers of the stops that end at the body of a column of states."""
    own = [i for i, body in enumerate(scene.line) if column in columns_of(body.name)]
    return [number for number, stop in enumerate(scene.stops) if {stop.P, stop.Q} & set(own)]


def contact_spans(subject: Subject, span: Span) -> list[Span]:
    """The stretches of contact, or of rest, at any stop that meet the span, cut to it [s]."""
    names = part_columns(subject.scene)[: len(subject.scene.stops)]
    events = events_within(subject.result, ("t", *names), span, before=1)
    touching = [np.isin(events[name], PUSHING) for name in names]
    contact = np.any(touching, axis=0)
    ends = np.append(events["t"][1:], span[1])
    stretches = [(max(a, span[0]), min(b, span[1])) for a, b in zip(events["t"], ends, strict=True)]
    return [(a, b) for (a, b), closed in zip(stretches, contact, strict=True) if closed and a < b]


# Spans of time that suit a picture: the detail of a history, the steady end of a run.


DETAIL_PERIODS = 10
STEADY_PERIODS = 50
PERIODS_AT_MOST = 5000  # in the last half of a run, as far as it is shown by default


def period_of(subject: Subject, span: Span) -> float:
    """Period of the source [s], the motor's at the end of the span; a tenth of the span without rhythm."""
    phidot, turning = None, motor_columns(subject.scene) or turning_columns(subject.scene)
    if turning is not None:
        stop = rows(subject.result, span).stop
        tail = slice(max(0, stop - min(1000, BLOCK)), stop)
        phidot = float(np.mean(subject.result.column(turning[1])[tail]))
    return source_period(subject.scene, phidot) or (span[1] - span[0]) / 10


def round_number(length: float) -> float:
    """The nearest of 1, 2, 5, 10, 20, ... by ratio."""
    decade = 10.0 ** math.floor(math.log10(length))
    return min((step * decade for step in (1, 2, 5, 10)), key=lambda number: abs(math.log(number / length)))


def steady_span(subject: Subject, window: Span, periods: int = STEADY_PERIODS) -> Span:
    """The last `periods` of the source within the window, as a round number of seconds."""
    length = round_number(periods * period_of(subject, window))
    return max(window[0], window[1] - length), window[1]


def last_half(subject: Subject, window: Span) -> Span:
    """The second half of the run, at most its last 5000 periods; all of an orbit, which is settled."""
    if subject.holds_orbit:
        return window
    longest = PERIODS_AT_MOST * period_of(subject, window)
    return max((window[0] + window[1]) / 2, window[1] - longest), window[1]


def detail_span(subjects: Sequence[Subject], view: View) -> Span:
    """The span to enlarge: the view's detail, or the last ten periods in which the first run has impacts.

    Raises PlotError when the view's detail lies outside what is shown of every run.
    """
    window = shared_window(subjects, view.window)
    if view.detail is not None:
        return _within(window, view.detail)
    subject = subjects[0]
    length = round_number(DETAIL_PERIODS * period_of(subject, window))
    end = window[1]
    times = impact_times(subject.result, window) if subject.scene.has_stop else np.empty(0)
    if len(times) and times[-1] < end - length:
        end = min(end, float(times[-1]) + length / 5)
    return max(window[0], end - length), end


def _within(window: Span, asked: Span) -> Span:
    span = max(window[0], asked[0]), min(window[1], asked[1])
    if not span[0] < span[1]:
        raise PlotError(f"detail {asked[0]:g}:{asked[1]:g} lies outside what is shown, {seconds(window)}")
    return span

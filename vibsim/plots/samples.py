"""Samples of a run, read window by window and block by block, so that memory does not grow with the file."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from vibsim.physics import rates
from vibsim.physics.parts import GROUND, Motor, Scene
from vibsim.physics.two_blocks import is_papers
from vibsim.plots.sheet import FONT_SIZE, LINE_HEIGHT, spread
from vibsim.plots.style import GREY, points
from vibsim.plots.subject import Subject
from vibsim.plots.view import PlotError, Span

BLOCK = 1 << 18  # rows: 2 MB per column
SHORTEST = 10  # windows without samples to the shortest period, at most
POINTS_PER_COLUMN = 4  # what an envelope keeps; a series shorter than that is drawn as it is

Series = tuple[np.ndarray, np.ndarray]


def whole_span(result: Any) -> Span:
    """First and last sampled instant [s]."""
    time = result.column("time")
    if len(time) < 2:
        raise PlotError(f"{result.case.name}: the run holds {len(time)} samples: nothing to draw")
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
    for frequency, x, place in zip(inside, at, places, strict=True):
        for axes in panels:
            axes.axvline(
                frequency.hz, color=GREY, linewidth=0.5, linestyle=(0, (4, 2)), zorder=1, gid="frequency"
            )
        panels[0].annotate(
            f"{frequency.label}  {frequency.hz:.2f}", (x, 1.0), (place, above),
            xycoords="axes fraction", textcoords=("axes fraction", "offset points"),
            ha="center", va="bottom", rotation=90, fontsize=points(FONT_SIZE), color="0.25",
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": GREY, "shrinkA": 1, "shrinkB": 0},
        )  # fmt: skip

"""Motions by frequency: displacements against the motor's speed, and amplitude spectra."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize, to_rgb
from matplotlib.figure import Figure

from vibsim.analysis.analysis import (
    displacement,
    fastest,
    is_still,
    motions_of,
    spectrum_of,
    unit_of_motion,
    without_line,
)
from vibsim.physics.rates import motor_columns, source_rates
from vibsim.plots.poincare_sections import TurnExtremes, turn_extremes
from vibsim.plots.portraits import moving
from vibsim.plots.samples import (
    difference,
    last_half,
    mark_frequencies,
    natural_frequencies,
    rows,
    shown,
    window_of,
)
from vibsim.plots.sheet import (
    CM,
    Scale,
    amount,
    legend_above,
    legend_below,
    letter_panels,
    note,
    pixel_columns,
    say_inside,
    scale_for,
    seconds,
    sheet,
    symbol,
    time_axis,
)
from vibsim.plots.style import BLUE, dashed, overlay
from vibsim.plots.subject import PlotError, Span, Subject, View, check_one_unit
from vibsim.plots.time_histories import SPEED, mean_speed
from vibsim.plots.traces import Block, Trace, draw_trace, trace, trust_remark

LOOPS_UP_TO = 40  # turns that are seen as loops; of more, the extremes of each
HERTZ = Scale(1.0, "Hz")
PALE, PALER = "0.86", 0.22  # grey of one run; what is left of the colour of one of several
COLOURS_OF_TIME = "viridis"


@dataclass(frozen=True)
class FrequencyPassage:
    """Displacement of a block of one run against the motor's speed, and the extremes where turns are many."""

    subject: Subject
    loops: Trace
    extremes: TurnExtremes | None
    colour: Any


def displacement_frequency_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Displacements [m] against phidot / 2 pi [Hz]; the whole run unless the view has a window.

    Many turns overlap to an area: it is pale then, and upon it stand the least and the greatest displacement
    of every turn at the mean speed of that turn, coloured by time (by run where they are several).
    """
    columns = moving(subjects)
    figure = sheet(view, 1.4 + 4.4 * len(columns))
    panels = list(figure.subplots(len(columns), 1, squeeze=False, sharex=True)[:, 0])
    shown = displacement_frequency_panels(panels, subjects, view, columns)
    panels[-1].set_xlabel(f"Motor speed {SPEED} (Hz)")
    if shown is not None:
        figure.colorbar(shown, ax=panels, label="Time (s)", pad=0.02, aspect=40)
    spans = [window_of(subject, view.window) for subject in subjects]
    marks = "dots: extremes of each turn" if any(panel.findobj(_is_extremes) for panel in panels) else ""
    remarks = [*dict.fromkeys(map(seconds, spans)), marks, trust_remark(subjects, spans)]
    note(panels[0], "; ".join(filter(None, remarks)))
    if len(subjects) > 1:
        legend_above(panels[0], markerscale=4)
    letter_panels(panels)
    figure.align_ylabels()
    return figure


def _is_extremes(artist: Any) -> bool:
    """Whether an artist is the dots of the extremes."""
    return bool(artist.get_gid() == "extremes")


def displacement_frequency_panels(
    panels: Sequence[Axes], subjects: Sequence[Subject], view: View, columns: Sequence[str]
) -> Any:
    """The displacements `columns`, each in given axes; the artist whose colours tell the time, if any."""
    spans = [window_of(subject, view.window) for subject in subjects]
    drawn = [_passages(subjects, spans, column) for column in columns]
    units = [passages[0].subject.unit("m", column) for column, passages in zip(columns, drawn, strict=True)]
    shown = None
    for axes, column, unit, passages in zip(panels, columns, units, drawn, strict=True):
        alike = [each for each, other in zip(drawn, units, strict=True) if other == unit]
        scale = scale_for(unit, *(passage.loops.y for each in alike for passage in each))
        for passage in passages:
            shown = _draw(axes, passage, column, scale, alone=len(subjects) == 1) or shown
        axes.margins(0.04)
        axes.set_ylabel(scale.label(f"{passages[0].subject.word('m', column).capitalize()} {symbol(column)}"))
    return shown


def _passages(subjects: Sequence[Subject], spans: Sequence[Span], column: str) -> list[FrequencyPassage]:
    def plane(columns: Block) -> tuple[np.ndarray, np.ndarray]:
        return columns["phidot"] / (2 * math.pi), columns[column]

    passages = []
    for i, (subject, span) in enumerate(zip(subjects, spans, strict=True)):
        if column in subject.tables.samples:
            colour = overlay(i)["color"] if len(subjects) > 1 else BLUE
            loops = trace(subject.result, ("phidot", column), plane, span)
            extremes = turn_extremes(subject.result, column, span)
            many = len(extremes.hertz) > LOOPS_UP_TO
            passages.append(FrequencyPassage(subject, loops, extremes if many else None, colour))
    return passages


def _draw(axes: Axes, passage: FrequencyPassage, column: str, scale: Scale, alone: bool) -> Any:
    """One run: loops, and on them the extremes; what tells the time by colours, if anything does."""
    many = passage.extremes is not None
    look: dict[str, Any] = {"color": passage.colour, "linewidth": 0.3, "gid": column}
    if many:
        look["color"] = PALE if alone else tuple(1 - (1 - part) * PALER for part in to_rgb(passage.colour))
    name = passage.subject.name
    draw_trace(axes, passage.loops, (HERTZ, scale), **look, label="" if many else name)
    return _draw_extremes(axes, passage, scale, name, alone) if many else None


def _draw_extremes(axes: Axes, passage: FrequencyPassage, scale: Scale, name: str, alone: bool) -> Any:
    extremes = passage.extremes
    assert extremes is not None
    x = np.concatenate([extremes.hertz, extremes.hertz])
    y = scale(np.concatenate([extremes.least, extremes.greatest]))
    size, rasterized = 1.6, len(x) > 10_000
    if not alone:
        axes.plot(
            x, y, linestyle="none", marker="o", markersize=1.2, markeredgewidth=0, color=passage.colour,
            label=name, gid="extremes", rasterized=rasterized, zorder=2.95,
        )  # fmt: skip
        return None
    times = np.concatenate([extremes.t, extremes.t])
    return axes.scatter(
        x, y, s=size, c=times, cmap=COLOURS_OF_TIME, norm=Normalize(float(times.min()), float(times.max())),
        linewidths=0, gid="extremes", rasterized=rasterized, zorder=2.95,
    )  # fmt: skip


# Amplitude spectra of displacements: of a whole span, or of pieces of it one after another.


NOTHING = "nothing vibrates here"  # what a picture without amplitudes says
FEWEST = 64  # samples of a piece
OVERLAP = 0.75  # of a piece with the next
SHOWN = 6.0  # highest frequency shown, in multiples of the fastest of source and free vibration
PERIODS = 8.0  # of the slowest vibration in a piece
FAINT, BEYOND = 1e-2, 1.5  # of the largest amplitude, and how far beyond the last greater one: where nothing
# has a frequency, the spectrum of impacts falls off for ever
FLOOR = 1e-6  # of the largest amplitude: what lies below is not shown


@dataclass(frozen=True)
class Pieces:
    """Spectra of pieces.

    Attributes
    ----------
    times : middle of each piece (n) [s]
    hz : frequencies (m) [Hz]
    amplitudes : (n, m) [m]; a sine of amplitude A reads A
    length : of a piece [s]
    """

    times: np.ndarray
    hz: np.ndarray
    amplitudes: np.ndarray
    length: float


def spectra(subject: Subject, span: Span, columns: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m) [Hz] and amplitudes (columns, m) [m] of displacements (or relative motions) over a span
    [s], each less its line of least squares; all 0 where only rounding is left of it.

    Raises PlotError where it has too few samples.
    """
    sampled = [_samples(subject, span, column) for column in columns]
    transforms = [_amplitudes(x, every) for x, every in sampled]
    step = transforms[0][1]
    amplitudes = np.array([sizes for sizes, _ in transforms])
    return _shown(subject, np.arange(amplitudes.shape[1]) * step, amplitudes)


def pieces(subject: Subject, span: Span, column: str, count: int = 200) -> Pieces:
    """Spectra of pieces of a span that overlap, at most `count` of them."""
    x, every = _samples(subject, span, column)
    length = min(max(FEWEST, round(PERIODS / slowest(subject, span) / every)), len(x) // 2)
    if length < FEWEST:
        raise PlotError(f"{subject.path}: too few samples for spectra of pieces of the span: {len(x)}")
    hop = max(round(length * (1 - OVERLAP)), -(-(len(x) - length) // (count - 1)), 1)
    begins = range(0, len(x) - length + 1, hop)
    transforms = [_amplitudes(x[i : i + length], every) for i in begins]
    step = transforms[0][1]
    hz, amplitudes = _shown(
        subject, np.arange(len(transforms[0][0])) * step, np.array([sizes for sizes, _ in transforms])
    )
    first = span_begin(subject, span)
    times = first + (np.array(begins) + length / 2) * every
    return Pieces(times, hz, amplitudes, length * every)


def span_begin(subject: Subject, span: Span) -> float:
    """Time of the first sample within a span [s]."""
    return float(subject.result.column("time")[rows(subject.result, span).start])


def slowest(subject: Subject, span: Span) -> float:
    """A low frequency of the motion [Hz]: a quarter of the fastest free vibration."""
    return (fastest(subject.scene, None) or 8 / (span[1] - span[0])) / 4


def first_motion(subject: Subject) -> str:
    """Name of the relative motion that spectra are of, unless another is asked for."""
    return next(iter(motions_of(subject.scene)))


def _samples(subject: Subject, span: Span, column: str) -> tuple[np.ndarray, float]:
    within = rows(subject.result, span)
    if within.stop - within.start < FEWEST:
        raise PlotError(f"{subject.path}: a spectrum needs {FEWEST} samples, and the span holds fewer")
    scene = subject.scene
    return displacement(subject.result, within, column), scene.every_num / scene.every_den


def _amplitudes(x: np.ndarray, every: float) -> tuple[np.ndarray, float]:
    amplitudes, step = spectrum_of(without_line(x), every)
    return (np.zeros_like(amplitudes) if is_still(x) else amplitudes), step


def _shown(subject: Subject, hz: np.ndarray, amplitudes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The part of the spectrum that is drawn: without what samples cannot tell, and where neither a source
    nor a spring has a frequency, without what is faint.
    """
    source = max(source_rates(subject.scene), default=0.0) / (2 * np.pi)
    top = SHOWN * fastest(subject.scene, source) or BEYOND * _last_clear(hz, amplitudes)
    rows = hz <= (top or hz[-1])
    return hz[rows], amplitudes[..., rows]


def _last_clear(hz: np.ndarray, amplitudes: np.ndarray) -> float:
    """The highest frequency (m) [Hz] at which any of the amplitudes (n, m) is not faint; 0 without any."""
    greatest = amplitudes.max(axis=0)
    clear = np.flatnonzero(greatest > FAINT * greatest.max())
    return float(hz[clear[-1]]) if len(clear) else 0.0


def spectrum_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Amplitude against frequency of each body, over the last half of the run unless the view has a window.

    Of several runs that of the first body.
    """
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    alone = len(subjects) == 1
    curves = [
        curve
        for subject, span in zip(subjects, spans, strict=True)
        for curve in _curves(subject, span, alone)
    ]
    units = list(dict.fromkeys(curve.unit for curve in curves))
    if not alone:
        firsts = zip(subjects, curves, strict=True)
        check_one_unit("the first body", [(subject.path, curve.unit) for subject, curve in firsts])
    figure = sheet(view, 7.4 if len(units) == 1 else 4.0 + 3.4 * len(units))
    panels = list(figure.subplots(len(units), 1, squeeze=False, sharex=True)[:, 0])
    looks = [dashed(i) for i in range(len(curves))]
    for axes, unit in zip(panels, units, strict=True):
        _spectra_panel(axes, [each for each in zip(curves, looks, strict=True) if each[0].unit == unit])
    panels[0].set_xlim(0, max(curve.hz[-1] for curve in curves))
    panels[-1].set_xlabel("Frequency (Hz)")
    remarks = [*dict.fromkeys(map(seconds, spans)), trust_remark(subjects, spans)]
    note(panels[0], "; ".join(filter(None, remarks)))
    if alone:
        mark_frequencies(panels, natural_frequencies(subjects[0].scene), (view.width_cm - 1.6) * CM * 72)
        lines = [line for axes in panels for line in axes.get_lines() if line.get_gid() == "spectrum"]
        legend_below(figure, lines, [str(line.get_label()) for line in lines])
    else:
        legend_above(panels[0])
    return figure


@dataclass(frozen=True)
class SpectrumCurve:
    """The spectrum of a body: name, frequencies [Hz] and amplitudes, in `unit`."""

    name: str
    hz: np.ndarray
    amplitudes: np.ndarray
    unit: str


def _curves(subject: Subject, span: Span, alone: bool) -> list[SpectrumCurve]:
    """The spectrum of each body, or of the first one where runs are several."""
    columns = subject.columns_in("m")[: None if alone else 1]
    hz, amplitudes = spectra(subject, span, columns)
    return [
        SpectrumCurve(symbol(column) if alone else subject.name, hz, sizes, subject.unit("m", column))
        for column, sizes in zip(columns, amplitudes, strict=True)
    ]


def _spectra_panel(axes: Axes, drawn: Sequence[tuple[SpectrumCurve, dict[str, Any]]]) -> None:
    """Spectra in one unit, each with its look."""
    scale = scale_for(drawn[0][0].unit, *(curve.amplitudes for curve, _ in drawn))
    for curve, look in drawn:
        axes.plot(curve.hz, scale(curve.amplitudes), label=curve.name, gid="spectrum", **look)
    largest = max(float(scale(curve.amplitudes).max()) for curve, _ in drawn)
    if largest:
        axes.set_yscale("log")
        axes.set_ylim(largest * FLOOR, 2 * largest)
    else:
        axes.set_ylim(0, 1)
        axes.set_yticks([])
        say_inside(axes, NOTHING)
    axes.set_ylabel(scale.label("Amplitude"))


# How the spectrum of a motion changes in time, the speed of the motor and its multiples drawn in.


DECADES = 4  # of amplitude that are told apart


def spectrogram_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Amplitude of the first relative motion over time and frequency."""
    subject = subjects[0]
    span, coordinate = window_of(subject, view.window), _coordinate(subject)
    cut = pieces(subject, span, first_motion(subject), count=600)
    figure = sheet(view, 7.0)
    axes = figure.subplots()
    scale = scale_for(_unit(subject), cut.amplitudes)
    values = scale(cut.amplitudes)
    largest = float(values.max()) or 1.0
    least = largest * 10.0**-DECADES
    picture = axes.pcolormesh(
        _edges(cut.times, span), _edges(cut.hz, (0.0, float(cut.hz[-1]))), np.maximum(values, least).T,
        cmap="magma", shading="flat", norm=LogNorm(least, largest), rasterized=True, gid="spectrogram",
    )  # fmt: skip
    if not values.any():
        axes.text(0.5, 0.5, NOTHING, transform=axes.transAxes, ha="center", va="center", color="white")
    figure.colorbar(picture, ax=axes, label=scale.label(f"Amplitude of {coordinate}"), pad=0.01)
    motor = motor_columns(subject.scene) and _speeds(axes, subject, span)
    axes.set_ylim(0, cut.hz[-1])
    axes.set_ylabel("Frequency (Hz)")
    time_axis(axes, span)
    note(axes, f"pieces of {cut.length:.3g} s" + ("; dashed: motor speed" if motor else ""))
    return figure


def _edges(middles: np.ndarray, span: Span) -> np.ndarray:
    """Edges (n + 1) of the cells of values (n): half-way to the next one, and at the ends of a span.

    The first and the last piece of a run reach that far: nobody else tells of their halves.
    """
    return np.array([span[0], *((middles[1:] + middles[:-1]) / 2), span[1]])


def _speeds(axes: Axes, subject: Subject, span: Span) -> bool:
    """The motor's mean speed over the picture; whether it turned often enough to have one."""
    t, hertz = mean_speed(subject, span, pixel_columns(axes))
    axes.plot(t, hertz, color="white", linewidth=0.7, linestyle=(0, (3, 2)), gid="motor-speed")
    return len(t) > 0


# Spectra one behind the other: of pieces of a run, or of several runs.


MOST = 40  # spectra
HEIGHT = 6.0  # of the largest line, in distances between spectra


@dataclass(frozen=True)
class SpectrumRow:
    """One spectrum: where it stands on the y axis, frequencies [Hz] and amplitudes [m]."""

    place: float
    hz: np.ndarray
    amplitudes: np.ndarray


def waterfall_picture(subjects: Sequence[Subject], view: View) -> Figure:
    """Spectra of the first relative motion, each raised to its time, or of several runs to their number."""
    alone = len(subjects) == 1
    check_one_unit("the first motion", [(subject.path, _unit(subject)) for subject in subjects])
    drawn = _of_pieces(subjects[0], view) if alone else _of_runs(subjects, view)
    largest = max(float(row.amplitudes.max()) for row in drawn)
    apart = (drawn[-1].place - drawn[0].place) / max(len(drawn) - 1, 1) or 1.0
    raised = HEIGHT * apart / (largest or 1.0)
    figure = sheet(view, 9.0)
    axes = figure.subplots()
    for i, row in enumerate(reversed(drawn)):  # the last, which stands highest, is behind
        y = row.place + raised * row.amplitudes
        axes.fill_between(row.hz, y, row.place, facecolor="white", edgecolor="none", zorder=2 + i / MOST)
        axes.plot(row.hz, y, color=BLUE, linewidth=0.5, gid="spectrum", zorder=2 + i / MOST)
    axes.set_xlim(0, max(row.hz[-1] for row in drawn))
    axes.set_xlabel("Frequency (Hz)")
    if alone:
        axes.set_ylabel("Time (s)")
        end = drawn[-1].place + apart  # above it there are lines, and no time
        axes.set_yticks([tick for tick in axes.get_yticks() if axes.get_ylim()[0] <= tick <= end])
    else:
        axes.set_ylabel("Run")
        axes.set_yticks([row.place for row in drawn], [subject.name for subject in subjects])
    if not largest:
        say_inside(axes, NOTHING)
        return figure
    coordinates = dict.fromkeys(_coordinate(subject) for subject in subjects)
    what = f"amplitude of {', '.join(coordinates)}"
    note(axes, f"{what}; largest line {amount(largest, _unit(subjects[0]))}")
    return figure


def _unit(subject: Subject) -> str:
    """Unit of the motion that spectra are of, m or rad."""
    return unit_of_motion(subject.scene, first_motion(subject))


def _coordinate(subject: Subject) -> str:
    """The motion that spectra are of, in symbols."""
    return difference(subject.scene, motions_of(subject.scene)[first_motion(subject)], "x")


def _of_pieces(subject: Subject, view: View) -> list[SpectrumRow]:
    cut = pieces(subject, window_of(subject, view.window), first_motion(subject), count=MOST)
    return [
        SpectrumRow(float(time), cut.hz, sizes) for time, sizes in zip(cut.times, cut.amplitudes, strict=True)
    ]


def _of_runs(subjects: Sequence[Subject], view: View) -> list[SpectrumRow]:
    spans = [shown(subject, view.window, last_half) for subject in subjects]
    drawn = [
        spectra(subject, span, [first_motion(subject)]) for subject, span in zip(subjects, spans, strict=True)
    ]
    return [SpectrumRow(float(i), hz, sizes) for i, (hz, (sizes,)) in enumerate(drawn)]

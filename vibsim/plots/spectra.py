"""Amplitude spectra of displacements: of a whole span, or of pieces of it one after another."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vibsim.analysis.analysis import displacement, fastest, is_still, motions_of, spectrum_of, without_line
from vibsim.cases.ramps import drive_turns
from vibsim.physics.parts import columns_of
from vibsim.physics.rates import common_period, motor_columns, source_rates, turning_columns
from vibsim.plots import traces
from vibsim.plots.samples import PERIODS_AT_MOST, blocks, rows
from vibsim.plots.subject import PlotError, Span, Subject
from vibsim.plots.traces import Block, dense, hermite, root_time, samples_are_sparse

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
        raise PlotError(f"{subject.path}: {len(x)} samples are too few for spectra of pieces of the span")
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

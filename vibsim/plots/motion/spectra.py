"""Amplitude spectra of displacements: of a whole span, or of pieces of it one after another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vibsim.analysis.dominant_frequencies import (
    displacement,
    fastest,
    is_still,
    motions_of,
    spectrum_of,
    without_line,
)
from vibsim.physics.rates import source_rates
from vibsim.plots.errors import PlotError
from vibsim.plots.motion.samples import rows
from vibsim.plots.subject import Subject
from vibsim.plots.view import Span

NOTHING = "nothing vibrates here"  # what a picture without amplitudes says
FEWEST = 64  # samples of a piece
OVERLAP = 0.75  # of a piece with the next
SHOWN = 6.0  # highest frequency shown, in multiples of the fastest of source and free vibration
PERIODS = 8.0  # of the slowest vibration in a piece
FAINT, BEYOND = 1e-2, 1.5  # of the largest amplitude, and how far beyond the last greater one: where nothing
# has a frequency, the spectrum of blows falls off for ever
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

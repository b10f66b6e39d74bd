"""The frequencies that a displacement is made of, strongest first.

Fourier transform of the samples under a window of Blackman and Harris (four terms: side lobes below -92 dB,
main lobe 4/T to each side), zero-padded to four times the length; each maximum is refined by a parabola
through the logarithm of three values. Two frequencies closer than the resolution 4/T are not told apart;
the frequency of a lone line is far better known than that.
"""

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.resonances import resonances
from vibsim.analysis.span import Span, steady_span
from vibsim.physics.scene import Scene
from vibsim.results.result import Result
from vibsim.results.windows import Window, rows_within

OF = ("relative", "x1", "x2")
TERMS = (0.35875, -0.48829, 0.14128, -0.01168)  # of the window (Harris 1978)
PADDING = 4
FLOOR = 0.01  # amplitude of the weakest line, relative to the strongest
ROUNDING = 1e-13  # amplitude, relative to the greatest displacement, below which nothing is a line
PER_PERIOD = 4  # samples to a period of what vibrates fastest, at least: others would stand for it
MOST = 8  # lines
FEWEST, GREATEST = 64, 1 << 20  # samples; of a longer span the last ones, 87 min at 5 ms
DENOMINATORS = 6  # largest n of the fractions m/n of the source frequency that lines are identified with


@dataclass(frozen=True)
class Line:
    """One frequency [Hz] and its amplitude, 0 to peak [m].

    order : frequency over that of the source where that is m/n with n <= 6, such as "3/2"; else None
    """

    hz: float
    amplitude: float
    order: str | None


@dataclass(frozen=True)
class DominantFrequencies:
    """Lines of the spectrum of a displacement.

    Attributes
    ----------
    verdict : "lines", "still" (nothing vibrates) or "undecided"
    reason : in words
    of : "relative" (x1 - x2), "x1" or "x2"
    lines : the strongest first, those of at least 1 % of the strongest
    resolution_hz : least distance of lines that are told apart [Hz]
    source_hz : mean frequency of the source in the span [Hz]; None without one
    """

    verdict: str
    reason: str
    span: Span
    of: str
    lines: tuple[Line, ...] = ()
    resolution_hz: float | None = None
    source_hz: float | None = None


def find_frequencies(
    result: Result, window: Window | None = None, of: str = "relative"
) -> DominantFrequencies:
    """Dominant frequencies within `window` [s], by default the second half of the run.

    Raises ValueError for a window outside the run and an unknown `of`.
    """
    if of not in OF:
        raise ValueError(f"of must be one of {', '.join(OF)}, got {of!r}")
    span = steady_span(result, window)
    rows = rows_within(result.column("time"), span.window)
    if rows.stop - rows.start > GREATEST:
        rows = slice(rows.stop - GREATEST, rows.stop)
        span = replace(span, begin=float(result.column("time")[rows.start]))
    if rows.stop - rows.start < FEWEST:
        reason = f"{rows.stop - rows.start} samples are too few, {FEWEST} are needed"
        return DominantFrequencies("undecided", reason, span, of)
    scene = result.case.scene()
    every = scene.every_num / scene.every_den
    source = source_hz(result, span)
    if every * fastest(scene, source) > 1 / PER_PERIOD:
        reason = f"samples {every:g} s apart miss vibrations at {fastest(scene, source):.3g} Hz"
        return DominantFrequencies("undecided", reason, span, of, source_hz=source)
    lines, resolution = lines_of(displacement(result, rows, of), every, source)
    verdict = "lines" if lines else "still"
    reason = f"{rows.stop - rows.start} samples, resolution {resolution:.2g} Hz"
    return DominantFrequencies(verdict, reason, span, of, lines, resolution, source)


def fastest(scene: Scene, source: float | None) -> float:
    """The higher of the frequencies of the source and of the free vibration [Hz]."""
    return max(source or 0.0, *(one.hz for one in resonances(scene, False)), 0.0)


def lines_of(x: np.ndarray, every: float, source: float | None = None) -> tuple[tuple[Line, ...], float]:
    """Lines of equally spaced displacements x [m] and the resolution [Hz].

    every : [s] between two of them; source : frequency [Hz] that lines are identified with
    """
    from scipy.fft import next_fast_len, rfft

    count = len(x)
    resolution = 4 / (count * every)
    phase = 2 * np.pi * (np.arange(count) + 0.5) / count
    window = np.sum([term * np.cos(i * phase) for i, term in enumerate(TERMS)], axis=0)
    length = next_fast_len(PADDING * count, real=True)
    spectrum = np.abs(rfft(without_line(x) * window, length)) * (2 / window.sum())
    lobe = int(np.ceil(resolution * length * every))
    spectrum[:lobe] = 0.0  # what is left of the line
    step = 1 / (length * every)
    spectrum[spectrum < ROUNDING * np.abs(x).max()] = 0.0
    found = [_refined(spectrum, peak, step, source, resolution) for peak in _peaks(spectrum, lobe)]
    return tuple(found), resolution


def without_line(x: np.ndarray) -> np.ndarray:
    """x less its line of least squares."""
    place = np.linspace(-1.0, 1.0, len(x))
    apart = x - x.mean()
    return apart - place * (float(place @ apart) / float(place @ place))


def _peaks(spectrum: np.ndarray, lobe: int) -> list[int]:
    """Positions of the lines: maxima, the strongest first, none within the main lobe of a stronger one."""
    inner = spectrum[1:-1]
    maxima = np.flatnonzero((inner > spectrum[:-2]) & (inner >= spectrum[2:]) & (inner > 0)) + 1
    strongest = maxima[np.argsort(-spectrum[maxima], kind="stable")]
    found: list[int] = []
    for peak in strongest.tolist():
        if len(found) == MOST or spectrum[peak] < FLOOR * spectrum[strongest[0]]:
            break
        if all(abs(peak - other) > lobe for other in found):
            found.append(peak)
    return found


def _refined(spectrum: np.ndarray, peak: int, step: float, source: float | None, resolution: float) -> Line:
    """The line at a maximum: top of the parabola through the logarithms of three values."""
    tiny = np.finfo(float).tiny
    left, middle, right = np.log(np.maximum(spectrum[peak - 1 : peak + 2], tiny)).tolist()
    curvature = left - 2 * middle + right
    shift = 0.5 * (left - right) / curvature if curvature else 0.0
    hz = (peak + shift) * step
    amplitude = float(np.exp(middle - 0.25 * (left - right) * shift))
    return Line(hz, amplitude, order_of(hz, source, resolution))


def order_of(hz: float, source: float | None, resolution: float) -> str | None:
    """hz / source as m/n where that fits to a quarter of the resolution and neighbours lie outside it."""
    if not source or source / (DENOMINATORS * (DENOMINATORS - 1)) < resolution:
        return None
    order = Fraction(hz / source).limit_denominator(DENOMINATORS)
    return str(order) if abs(float(order) * source - hz) <= resolution / 4 else None


def source_hz(result: Result, span: Span) -> float | None:
    """Mean frequency of the source over the whole cycles of the span [Hz]; None without two cycle ends."""
    ends = cycle_ends(result, span.window)
    return (len(ends) - 1) / float(ends[-1] - ends[0]) if len(ends) > 1 else None


def displacement(result: Result, rows: slice, of: str) -> np.ndarray:
    """x1 - x2, x1 or x2 [m]; a fixed block 2 does not move."""
    names = {"relative": ("x1", "x2"), "x1": ("x1",), "x2": ("x2",)}[of]
    columns = [np.asarray(result.column(name)[rows]) if name in result else 0.0 for name in names]
    x = columns[0] - columns[1] if len(columns) == 2 else columns[0]
    return np.broadcast_to(x, rows.stop - rows.start)

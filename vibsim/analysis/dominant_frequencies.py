"""The frequencies that a displacement is made of, strongest first.

Fourier transform of the samples under a window of Blackman and Harris (four terms: side lobes below -92 dB,
main lobe 4/T to each side), zero-padded to four times the length; each maximum is refined by a parabola
through the logarithm of three values. Two frequencies closer than the resolution 4/T are not told apart, nor
is one below it from a drift; so a line is a vibration of which the span holds four periods. The frequency of
a lone line is far better known than that.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, pi

import numpy as np

from vibsim.analysis.cycles import FrequenciesVerdict, Span, cycle_ends, name_verdict, steady_span
from vibsim.cases.quantities import number
from vibsim.physics import elementary
from vibsim.physics.connections import Pair, pairs_of
from vibsim.physics.elementary import dot, mean, sine_cosine_of_arrays
from vibsim.physics.parts import Scene
from vibsim.physics.rates import natural_rates
from vibsim.results.columns import PairMotion, tables_of
from vibsim.results.result import Result, Window, rows_within

RELATIVE = "relative"  # the first relative motion of a scene, x1 - x2 of two blocks
TERMS = (0.35875, -0.48829, 0.14128, -0.01168)  # of the window (Harris 1978)
PADDING = 4
FLOOR = 0.01  # amplitude of the weakest line, relative to the strongest
LEAK = 1e-3  # the same, relative to all of the motion: side lobes of what is slow and curved reach 1.2e-4
ROUNDING = 1e-13  # amplitude, relative to the greatest displacement, below which nothing vibrates
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
    of : "relative" (x1 - x2 of two blocks), a displacement ("x1"), or a part or body (see `motions_of`)
    lines : the strongest first, those of at least 1 % of the strongest
    resolution_hz : least distance of lines that are told apart [Hz]
    source_hz : mean frequency of the source in the span [Hz]; None without one
    """

    verdict: FrequenciesVerdict | str
    reason: str
    span: Span
    of: str
    lines: tuple[Line, ...] = ()
    resolution_hz: float | None = None
    source_hz: float | None = None

    def __post_init__(self) -> None:
        name_verdict(self, FrequenciesVerdict)


def find_frequencies(
    result: Result, window: Window | None = None, of: str = "relative"
) -> DominantFrequencies:
    """Dominant frequencies within `window` [s], by default the second half of the run.

    of : "relative" for the first of `motions_of`, one of these by its name, or the column of a displacement

    Raises ValueError for a window outside the run and an unknown `of`.
    """
    scene = result.case.scene()
    allowed = (RELATIVE, *tables_of(scene).displacements, *motions_of(scene))
    if of not in allowed:
        raise ValueError(f"of must be one of {', '.join(allowed)}, got {of!r}")
    span = steady_span(result, window)
    rows = rows_within(result.column("time"), span.window)
    if rows.stop - rows.start > GREATEST:
        rows = slice(rows.stop - GREATEST, rows.stop)
        span = replace(span, begin=float(result.column("time")[rows.start]))
    if rows.stop - rows.start < FEWEST:
        reason = f"{rows.stop - rows.start} samples are too few, {FEWEST} are needed"
        return DominantFrequencies("undecided", reason, span, of)
    every = scene.every_num / scene.every_den
    source = source_hz(result, span)
    if every * fastest(scene, source) > 1 / PER_PERIOD:
        reason = f"samples {every:g} s apart miss vibrations at {fastest(scene, source):.3g} Hz"
        return DominantFrequencies("undecided", reason, span, of, source_hz=source)
    x = displacement(result, rows, of)
    lines, resolution = lines_of(x, every, source)
    verdict, reason = "lines", f"{rows.stop - rows.start} samples, resolution {number(resolution, 2)} Hz"
    if not lines and is_still(x):
        verdict = "still"
    elif not lines:
        verdict = "undecided"
        reason = f"no vibration above {resolution:.3g} Hz, of which {span.length:.4g} s hold four periods"
    return DominantFrequencies(verdict, reason, span, of, lines, resolution, source)


def motions_of(scene: Scene) -> dict[str, Pair]:
    """The relative motions of a scene by name: x_P - x_Q of each pair of ends of links and stops, called
    after the first part between them; of bodies without these, that of a friction or of the body itself.
    """
    return {pair.name: pair for pair in pairs_of(scene)}


def fastest(scene: Scene, source: float | None) -> float:
    """The highest of the frequencies of the source and of the free vibrations [Hz]."""
    return max(source or 0.0, *(rate / (2 * pi) for rate in natural_rates(scene)), 0.0)


def lines_of(x: np.ndarray, every: float, source: float | None = None) -> tuple[tuple[Line, ...], float]:
    """Lines of equally spaced displacements x [m] and the resolution [Hz].

    every : [s] between two of them; source : frequency [Hz] that lines are identified with
    """
    resolution = 4 / (len(x) * every)
    apart = without_line(x)
    if is_still(x):
        return (), resolution
    spectrum, step = spectrum_of(apart, every)
    peaks = _peaks(spectrum, resolution / step, LEAK * np.abs(apart).max())
    return tuple(_refined(spectrum, peak, step, source, resolution) for peak in peaks), resolution


def spectrum_of(x: np.ndarray, every: float) -> tuple[np.ndarray, float]:
    """Amplitudes of x [m] at multiples of a frequency step [Hz], and that step."""
    from scipy.fft import next_fast_len, rfft

    count = len(x)
    length = next_fast_len(PADDING * count, real=True)
    transform = rfft(x * _window(count), length)
    sizes = np.sqrt(transform.real * transform.real + transform.imag * transform.imag)
    return sizes * (2 / (count * TERMS[0])), 1 / (length * every)


def _window(count: int) -> np.ndarray:
    """The window of `count` values, whose mean is its first term."""
    cosine = sine_cosine_of_arrays(2 * np.pi * (np.arange(count) + 0.5) / count)[1]
    twice = 2 * cosine * cosine - 1  # cosines of the double and the triple angle
    return np.asarray(TERMS[0] + TERMS[1] * cosine + TERMS[2] * twice + TERMS[3] * cosine * (2 * twice - 1))


def is_still(x: np.ndarray) -> bool:
    """Whether displacements lie on a line but for rounding."""
    return bool(np.abs(without_line(x)).max() <= ROUNDING * np.abs(x).max())


def without_line(x: np.ndarray) -> np.ndarray:
    """x less its line of least squares."""
    place = np.linspace(-1.0, 1.0, len(x))
    apart = x - mean(x)
    return np.asarray(apart - place * (dot(place, apart) / dot(place, place)))


def _peaks(spectrum: np.ndarray, lobe: float, least: float) -> list[int]:
    """Positions of the lines, the strongest first, of amplitudes from `least` [m] on.

    lobe : half width of a main lobe, in positions

    Maxima that no stronger one has in its main lobe, and that lie more than a lobe from both ends of the
    spectrum: nearer to them lie what a drift leaves, and the mirror images of lines.
    """
    from scipy.signal import find_peaks

    maxima, _ = find_peaks(spectrum, distance=ceil(lobe) + 1)
    maxima = maxima[(maxima > lobe) & (maxima < len(spectrum) - 1 - lobe)]
    sizes = spectrum[maxima]
    least = max(least, FLOOR * sizes.max(initial=0.0))
    strongest = maxima[np.argsort(-sizes, kind="stable")]
    return [peak for peak in strongest.tolist() if spectrum[peak] >= least][:MOST]


def _refined(spectrum: np.ndarray, peak: int, step: float, source: float | None, resolution: float) -> Line:
    """The line at a maximum: top of the parabola through the logarithms of three values."""
    left, middle, right = (elementary.log(size) for size in spectrum[peak - 1 : peak + 2].tolist())
    curvature = left - 2 * middle + right
    shift = 0.5 * (left - right) / curvature if curvature else 0.0
    hz = float((peak + shift) * step)
    return Line(hz, elementary.exp(middle - 0.25 * (left - right) * shift), order_of(hz, source, resolution))


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
    """A displacement, or x_P - x_Q of a relative motion [m]."""
    scene = result.case.scene()
    if of in tables_of(scene).displacements:
        return np.asarray(result.column(of)[rows])
    motions = motions_of(scene)
    motion = PairMotion(scene, next(iter(motions.values())) if of == RELATIVE else motions[of])
    columns = {name: np.asarray(result.column(name)[rows]) for name in ("time", *motion.columns)}
    return np.asarray(motion.above_rounding(columns, "time")[1])

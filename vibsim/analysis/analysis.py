"""Everything that a run shows, judged at once; and the frequencies that dominate a displacement."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, pi
from os import PathLike
from typing import TYPE_CHECKING, Any, TypeVar, Union

import numpy as np

from vibsim.analysis.capture import Capture, capture_of_turns, judge_capture
from vibsim.analysis.cycles import (
    FrequenciesVerdict,
    Span,
    cycle_ends,
    later_part,
    name_verdict,
    span_of,
    steady_span,
)
from vibsim.analysis.drift import (
    Drift,
    ImpactsPerCycle,
    count_impacts,
    counted_parts,
    drifting,
    measure_drift,
)
from vibsim.analysis.regime import Regime, decided, judge_regime, largest_exponent
from vibsim.analysis.sections import MOST, Exponent, JudgedPoints, SectionCoordinates, judge_points
from vibsim.cases.case import texts
from vibsim.cases.quantities import number
from vibsim.engine.blocks import Block
from vibsim.engine.columns import OF_IMPACTS
from vibsim.physics import elementary
from vibsim.physics.connections import Pair, pairs_of
from vibsim.physics.elementary import dot, mean, sine_cosine_of_arrays
from vibsim.physics.parts import Scene
from vibsim.physics.rates import natural_rates
from vibsim.results.columns import PairMotion, tables_of
from vibsim.results.labelled import Shown
from vibsim.results.result import Result, Window, read_window, rows_within
from vibsim.results.simulation import as_result

if TYPE_CHECKING:
    from vibsim.cases import Case


T = TypeVar("T")
# a verdict, or those on several bodies or parts by their names
OneOrNamed = Union[T, dict[str, T]]  # noqa: UP007  (mypy knows no alias of T | ... before Python 3.12)

WHAT = ("capture", "drift", "impacts", "regime", "frequencies")


@dataclass(frozen=True, repr=False)
class Analysis(Shown):
    """Verdicts on a run; None where it was not asked for, or the scene lacks the part that it is about.

    Of drift, impacts and frequencies there is one verdict for two blocks, and for every other scene in which
    one thing alone can be meant; where there are several, a dictionary by the names of bodies or parts.

    Attributes
    ----------
    case : name of the case
    span : window that was looked at; capture is judged on all of it
    steady : what is left of it without the transient; the rest is judged on that

    >>> import vibsim
    >>> verdicts = vibsim.analyse("gallery/impact-pair", what=["impacts", "drift"])
    >>> [verdicts.impacts[wall].impacts for wall in ("left", "right")]  # per cycle
    [1.0, 1.0]
    >>> verdicts.capture is None  # it was not asked for
    True
    """

    case: str
    span: Span
    steady: Span
    capture: Capture | None = None
    drift: OneOrNamed[Drift] | None = None
    impacts: OneOrNamed[ImpactsPerCycle] | None = None
    regime: Regime | None = None
    frequencies: OneOrNamed[DominantFrequencies] | None = None

    def heading(self) -> str:
        """Name of the case, and what was looked at."""
        return f"of {self.case}, {_seconds(self.span)}, judged {_seconds(self.steady)}"

    def lines(self) -> list[tuple[str, str]]:
        """Every verdict with its reason; of several bodies or parts each behind its name."""
        return [line for what in WHAT for line in _verdict_lines(what, getattr(self, what))]


def _seconds(span: Span) -> str:
    return f"{span.begin:.5g} to {span.end:.5g} s"


def _verdict_lines(what: str, verdicts: Any) -> Iterator[tuple[str, str]]:
    """Label and text of one verdict, or of those by the names of bodies or parts."""
    if isinstance(verdicts, dict):
        for name, verdict in verdicts.items():
            yield what, f"{name}: {verdict.verdict}, {verdict.reason}"
    elif verdicts is not None:
        yield what, f"{verdicts.verdict}: {verdicts.reason}"


def analyse(
    result: Result | Case | str | PathLike[str],
    overrides: Mapping[str, object] | None = None,
    *,
    window: Window | str | None = None,
    discard: float | str | None = None,
    what: Collection[str] | str = WHAT,
    exponent: bool = True,
) -> Analysis:
    """Judge a run.

    Parameters
    ----------
    result : a Result, its file, or a case, as of `load_case`, which is run first
    overrides : values of the case that are changed; of a result none
    window : span to look at [s], (100, 110) or "100:110"; None: all of the run
    discard : transient at its begin that only the verdict on capture takes in, a time [s] or a text such as
        "100 s" or "50 %"; None: half the run without a window, nothing with one
    what : names out of WHAT, or one of them
    exponent : whether the largest Lyapunov exponent helps to judge a regime that is not periodic; costs one
        more run

    Raises ValueError for other names, a window outside the run, and a transient that leaves nothing.

    >>> import vibsim
    >>> verdicts = vibsim.analyse("gallery/impact-oscillator", what=["impacts", "regime"])
    >>> print(verdicts.regime.verdict, verdicts.regime.period, verdicts.impacts.verdict)
    periodic 2 some cycles
    """
    what = texts("what", what)
    unknown = [name for name in what if name not in WHAT]
    if unknown:
        raise ValueError(f"what must be among {', '.join(WHAT)}, got {unknown[0]!r}")
    result, window = as_result(result, overrides), None if window is None else read_window(window)
    span, steady = span_of(result, window), later_part(result, window, discard)
    scene = result.case.scene()
    verdicts: dict[str, Any] = {}
    if "capture" in what and scene.has_motor:
        verdicts["capture"] = judge_capture(result, span.window)
    if "regime" in what:
        verdicts["regime"] = _regime(result, steady, exponent)
    if "drift" in what and drifting(scene):
        regime = verdicts["regime"] if "regime" in what else judge_regime(result, steady)
        rates = regime.drift_rates
        drifts = {name: measure_drift(result, steady, of, rates) for name, of in drifting(scene).items()}
        verdicts["drift"] = _one_or_named(drifts)
    if "impacts" in what and scene.has_stop:
        of_parts = {name: count_impacts(result, steady, name) for name in counted_parts(scene)}
        verdicts["impacts"] = of_parts or count_impacts(result, steady)
    if "frequencies" in what:
        several = len(motions_of(scene)) > 1
        verdicts["frequencies"] = (
            {name: find_frequencies(result, steady, name) for name in motions_of(scene)}
            if several
            else find_frequencies(result, steady)
        )
    return Analysis(result.attrs["case_name"], span, span_of(result, steady), **verdicts)


def _one_or_named(verdicts: dict[str, T]) -> OneOrNamed[T]:
    """The only verdict, or all of several."""
    return next(iter(verdicts.values())) if len(verdicts) == 1 else verdicts


def _regime(result: Result, steady: Window, exponent: bool) -> Regime:
    """The regime; of a periodic motion without exponent: one return gives it better than any estimate."""
    regime = judge_regime(result, steady)
    if not exponent or regime.verdict in ("periodic", "at rest"):
        return regime
    return judge_regime(result, steady, largest_exponent(result, steady))


# Verdicts on a run while it is computed, for those who keep no trajectory, such as sweeps.


class StreamedVerdicts:
    """Gathers what the verdicts on capture and regime need from the blocks of a run.

    scene : what is run; begin : the regime is judged from then on [s], capture on everything taken

    The blocks carry the stroboscopic section. Memory grows with the cycles and impacts, not with the samples.
    """

    def __init__(self, scene: Scene, begin: float = 0.0):
        self.scene, self.begin = scene, begin
        self._points: list[dict[str, np.ndarray]] = []
        self._impacts: list[np.ndarray] = []
        self._coordinates = SectionCoordinates(scene)
        self._low, self._high = np.inf, -np.inf  # of each coordinate
        self._span = (np.inf, 0.0)

    def update(self, block: Block) -> None:
        """Take the next block."""
        self._points.append(dict(block.section))
        begun = OF_IMPACTS[block.events["kind"]]
        self._impacts.append(block.events["t"][begun])
        later = block.samples["time"] >= self.begin
        values = self._coordinates.of(block.samples)[:, later]
        self._low = np.minimum(self._low, values.min(axis=1, initial=np.inf))
        self._high = np.maximum(self._high, values.max(axis=1, initial=-np.inf))
        first = min([self._span[0], *block.events["t"][:1].tolist(), *block.samples["time"][:1].tolist()])
        self._span = first, block.t_reached

    def capture(self) -> Capture | None:
        """The verdict on a motor; None for another source."""
        if not self.scene.has_motor:
            return None
        return capture_of_turns(
            self._section()["time"], np.concatenate([[], *self._impacts]), self.scene, Span(*self._span)
        )

    def regime(self, exponent: Exponent | None = None) -> JudgedPoints:
        """The verdict on the stroboscopic section from `begin` on, settled by an orbit where one is near."""
        states, judged = self.late_section(), self.judged(exponent)
        if not len(states["time"]):
            return judged
        return decided(judged, self.scene, states, self._coordinates, self._sizes())

    def judged(self, exponent: Exponent | None = None) -> JudgedPoints:
        """The verdict on the points of the section from `begin` on alone, no orbit asked for."""
        states = self.late_section()
        if not len(states["time"]):
            return JudgedPoints("undecided", "no cycle of a source")
        return judge_points(self._coordinates.points(states, self._sizes()), exponent)

    def late_section(self) -> dict[str, np.ndarray]:
        """The points of the section from `begin` on, the last ones: time and states by name, each (n)."""
        section = self._section()
        rows = np.flatnonzero(section["time"] >= self.begin)[-MOST:]
        return {name: column[rows] for name, column in section.items()}

    def _sizes(self) -> np.ndarray:
        return self._coordinates.sizes(np.asarray(self._low), np.asarray(self._high))

    def _section(self) -> dict[str, np.ndarray]:
        """The stroboscopic points so far: time and states by name, each (n)."""
        if not self._points:
            return {"time": np.empty(0)}
        return {name: np.concatenate([part[name] for part in self._points]) for name in self._points[0]}


# The frequencies that a displacement is made of, strongest first.
#
# Fourier transform of the samples under a window of Blackman and Harris (four terms: side lobes below -92 dB,
# main lobe 4/T to each side), zero-padded to four times the length; each maximum is refined by a parabola
# through the logarithm of three values. Two frequencies closer than the resolution 4/T are not told apart,
# nor is one below it from a drift; so a line is a vibration of which the span holds four periods. The
# frequency of a lone line is far better known than that.


RELATIVE = "relative"  # the first relative motion of a scene, x1 - x2 of two blocks
TERMS = (0.35875, -0.48829, 0.14128, -0.01168)  # of the window (Harris 1978)
PADDING = 4
FLOOR = 0.01  # amplitude of the weakest line, relative to the strongest
LEAK = 1e-3  # the same, relative to all of the motion: side lobes of what is slow and curved reach 1.2e-4
ROUNDING = 1e-13  # amplitude, relative to the greatest displacement, below which nothing vibrates
PER_PERIOD = 4  # samples to a period of what vibrates fastest, at least: others would stand for it
MOST_LINES = 8  # lines
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
        reason = f"too few samples: {rows.stop - rows.start}, and {FEWEST} are needed"
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


def unit_of_motion(scene: Scene, of: str) -> str:
    """Unit of a displacement by the name that `find_frequencies` takes, m or rad."""
    pairs = motions_of(scene)
    pair = next(iter(pairs.values())) if of == RELATIVE else pairs.get(of)
    if pair is not None:
        return scene.unit_between(pair.P, pair.Q)
    return tables_of(scene).samples[of].units or ""


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
    return [peak for peak in strongest.tolist() if spectrum[peak] >= least][:MOST_LINES]


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

"""The regime of a motion from its stroboscopic section (recurrence, the 0-1 test, how points follow), and its
Lyapunov exponents.

    spectrum = vibsim.lyapunov(vibsim.load_case("II-B"))
    spectrum.exponents, spectrum.half_widths, spectrum.warnings

A positive exponent means chaos. Two exponents that are 0 by construction are left out: that of a shift of
both blocks, and with an ideal source that of time. A motor has no explicit time: one of its exponents is 0
too, that of the direction of the motion, as is every exponent of a motion that neither settles nor parts;
such ones approach 0 like log(t) / t.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain
from math import hypot, isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.analysis.comparison import average
from vibsim.analysis.cycles import ROWS, RegimeVerdict, Span, name_verdict, steady_span, transient
from vibsim.analysis.drift import happenings
from vibsim.analysis.sections import (
    EXACT,
    MOSTLY,
    NEAR,
    SHRINKS,
    TOLERANCE,
    Exponent,
    JudgedPoints,
    SectionCoordinates,
    judge_points,
    section_of,
)
from vibsim.cases.case import by_key, load_case, whole_number
from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.engine.columns import state_columns
from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.lyapunov import LyapunovExponents, lyapunov_exponents
from vibsim.engine.tangent.tangent_space import dimension
from vibsim.orbits.coordinates import OrbitError
from vibsim.orbits.newton import likely_periods, solve
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.return_map import ReturnMap
from vibsim.orbits.search import least
from vibsim.orbits.stability import exponents_of
from vibsim.physics.connections import drifting_sets
from vibsim.physics.parts import Scene, columns_of
from vibsim.physics.rates import has_section, is_driven
from vibsim.results.labelled import Shown
from vibsim.results.result import Result, Window, pieces, rows_within

if TYPE_CHECKING:
    from vibsim.cases.case import CaseLike


# The regime of a run: periodic, quasi-periodic, chaotic, or something less settled, and what says so.


STILL = 1e-9  # [m], [m/s], [rad], [rad/s]: nothing moves that moves less


@dataclass(frozen=True)
class Regime:
    """Verdict on a motion and its evidence; what was not worked out is None.

    Attributes
    ----------
    verdict : "at rest", "periodic", "transient", "quasi-periodic", "chaotic" or "undecided"
    reason : in words
    span : transient left out
    cycles : points of the stroboscopic section
    period : of a periodic motion, or of the one that a transient approaches, in cycles of the source
    since : from when on it is periodic [s]; None where it is still on its way
    step : distance of points a period apart at the end of the span, relative to the vibration
    chaos_number : K of the 0-1 test, see `zero_one_test`
    prediction : error of predicting points from their neighbours, relative to guessing
    word_period : cycles after which the events repeat themselves, in its later half; None: they do not
    exponent : as it was given
    multipliers : of the periodic orbit that the motion is on or goes to, (real, imaginary) each
    exponents : that follow from them [1/s], the largest first; None where sticking took the direction
    drift_rates : mean velocity of each body on that orbit [m/s], by name
    """

    verdict: RegimeVerdict | str
    reason: str
    span: Span
    cycles: int = 0
    period: int | None = None
    since: float | None = None
    step: float | None = None
    chaos_number: float | None = None
    prediction: float | None = None
    word_period: int | None = None
    exponent: Exponent | None = None
    multipliers: tuple[tuple[float, float], ...] | None = None
    exponents: tuple[float | None, ...] | None = None
    drift_rates: dict[str, float] | None = None

    def __post_init__(self) -> None:
        name_verdict(self, RegimeVerdict)


def judge_regime(result: Result, window: Window | None = None, exponent: Exponent | None = None) -> Regime:
    """The regime within `window` [s], by default the second half of the run.

    exponent : largest Lyapunov exponent of the motion, where it is known

    Raises ValueError for a window outside the run.
    """
    span = steady_span(result, window)
    if is_at_rest(result, span):
        return Regime("at rest", "nothing moves", span, exponent=exponent)
    scene = result.case.scene()
    if not is_driven(scene):
        return Regime("undecided", "no source, so no stroboscopic section", span, exponent=exponent)
    if not has_section(scene):
        reason = "sources without a common period, so no stroboscopic section"
        return Regime("undecided", reason, span, exponent=exponent)
    if result.orbit is not None:
        return _stored_orbit(result, span)
    section = section_of(result, span)
    judged = judge_points(section.points, exponent)
    if section.sizes is not None:
        judged = decided(judged, scene, section.states, SectionCoordinates(scene), section.sizes)
    since, word_period = _since(result, section.times, judged)
    evidence = {name: value for name, value in asdict(judged).items() if name != "onset"}
    return Regime(
        span=span, cycles=len(section), since=since, word_period=word_period, exponent=exponent, **evidence
    )


def _stored_orbit(result: Result, span: Span) -> Regime:
    """The regime of a run that is one period of an orbit."""
    assert result.orbit is not None
    real, imaginary = (result.orbit[f"multiplier_{part}"].tolist() for part in ("real", "imaginary"))
    multipliers = tuple(zip(real, imaginary, strict=True))
    period = result.attrs["orbit_period_s"]
    rates = exponents_of([complex(*pair) for pair in multipliers], period)
    numbers = tuple(rate if isfinite(rate) else None for rate in rates)
    n, kind = result.attrs["orbit_periods"], "a stable" if result.attrs["orbit_stable"] else "an unstable"
    reason = f"the file holds {kind} orbit"
    return Regime(
        "periodic", reason, span, n, n, 0.0, 0.0,
        multipliers=multipliers, exponents=numbers, drift_rates=_shifts(result, period),
    )  # fmt: skip


def _shifts(result: Result, period: float) -> dict[str, float]:
    """By body: how far the `period` [s] moves it, over the period [m/s]; 0 where something holds it."""
    scene = result.case.scene()
    both = result.at(np.array([0.0, period]))
    free = {scene.bodies[body].name for one in drifting_sets(scene) for body in one.bodies}
    ends = {body.name: both[columns_of(body.name)[0]] for body in scene.line}
    return {name: float((x[1] - x[0]) / period) if name in free else 0.0 for name, x in ends.items()}


def _since(result: Result, times: np.ndarray, judged: JudgedPoints) -> tuple[float | None, int | None]:
    """Onset of a periodic motion [s], and the number of cycles after which its events repeat themselves."""
    if judged.onset is None:
        return None, None
    later = times[(judged.onset + len(times)) // 2 :]
    return float(times[judged.onset]), word_period(happenings(result, later))


def word_period(words: Sequence[str | bytes]) -> int | None:
    """Cycles after which the words repeat themselves all along, at least twice; None: they do not."""
    periods = range(1, len(words) // 2 + 1)
    return next((period for period in periods if words[period:] == words[:-period]), None)


def is_at_rest(result: Result, span: Span) -> bool:
    """Whether everything stands still at the samples of the span; not known without two of them."""
    rows = rows_within(result.column("time"), span.window)
    if rows.stop - rows.start < 2:
        return False
    for name in state_columns(result.case.scene()):
        column = result.column(name)
        first = float(column[rows.start])
        if any(np.abs(column[piece] - first).max() > STILL for piece in pieces(rows, ROWS)):
            return False
    return True


# One Newton solve decides: is there a stable orbit where the section ends, and does the run go there?
#
# The section tells a period only where it has been seen often enough. An orbit is there or is not: Newton's
# method finds it from the last point, its multipliers tell whether it attracts, and the distances of the
# points from it whether the run comes nearer. So a motion that is still settling, or was seen for too few
# cycles, is known to be periodic, and its exponents are those of the orbit.


OPEN = (
    "periodic",
    "transient",
    "undecided",
)  # verdicts that an orbit can settle; the others have their evidence
TRIES = 2  # numbers of periods that are tried besides the one that the section tells
FEWEST = 12  # points from which a trend can be told
STEPS = 8  # of Newton's method: an orbit that is near is met in four

States = Mapping[str, np.ndarray]


def decided(
    judged: JudgedPoints, scene: Scene, states: States, coordinates: SectionCoordinates, sizes: np.ndarray
) -> JudgedPoints:
    """The verdict on a section, settled by an orbit where there is one that the run goes to.

    states : the points of the section by name of the column, among them `time` [s], each (n)
    sizes : by which `coordinates` of them are divided
    """
    if judged.verdict not in OPEN or len(states["time"]) < FEWEST:
        return judged
    for orbit in _orbits(judged, scene, states):
        if not orbit.stable:
            continue
        distances = _distances(orbit, states, coordinates, sizes)
        if _is_approached(distances, judged.verdict == "periodic"):
            return _settled(judged, orbit, distances)
    return judged


def _orbits(judged: JudgedPoints, scene: Scene, states: States) -> Iterator[Orbit]:
    """Orbits near the last point; where one is unstable, the doubled one beside it too."""
    try:
        return_map = ReturnMap(scene)
    except OrbitError:
        return
    if return_map.section.turning:
        return
    at, times = return_map.coordinates, states["time"]
    X = at.of(at.gathered(states))
    told = [judged.period] if judged.period else []
    numbers = list(dict.fromkeys([*told, *likely_periods(X)[0][:TRIES]]))
    for n in chain.from_iterable((n, 2 * n) for n in numbers):
        if n >= len(X):
            continue
        over = return_map.of(n)
        T = None if over.section.timed else float(times[-1] - times[-1 - n])
        try:
            yield least(Orbit(over, solve(over, X[-1], T, STEPS)))
        except (OrbitError, EngineError):
            continue


def _distances(
    orbit: Orbit, states: States, coordinates: SectionCoordinates, sizes: np.ndarray
) -> np.ndarray:
    """Distance of each point from the orbit's of its place, relative to the vibration (n)."""
    at, count = orbit.end.coordinates, len(states["time"])
    place = np.arange(1 - count, 1) % orbit.n
    lifted = np.array([at.lifted(point) for point in orbit.points])[place]
    shown = [(i, name) for i, name in enumerate(at.components) if name is not None]
    both = {name: np.concatenate([states[name], lifted[:, i]]) for i, name in shown}
    both["time"] = np.concatenate([states["time"]] * 2)
    points = coordinates.points(both, sizes)
    return np.asarray(np.abs(points[:count] - points[count:]).max(axis=1))


def _is_approached(distances: np.ndarray, repeats: bool) -> bool:
    """Whether points come near and nearer, by their first and last quarter; those that repeat themselves need
    but be near.
    """
    first, last = (float(np.quantile(part, MOSTLY)) for part in np.array_split(distances, 4)[::3])
    near_enough = TOLERANCE if repeats else EXACT
    return last <= near_enough or (last <= NEAR and last <= SHRINKS * first)


def _settled(judged: JudgedPoints, orbit: Orbit, distances: np.ndarray) -> JudgedPoints:
    apart = np.flatnonzero(distances > TOLERANCE)
    onset = int(apart[-1]) + 1 if len(apart) else 0
    known: dict[str, Any] = {
        "multipliers": tuple((mu.real, mu.imag) for mu in orbit.multipliers.tolist()),
        "exponents": tuple(rate if isfinite(rate) else None for rate in orbit.exponents),
        "drift_rates": orbit.drift_rates,
    }
    if judged.verdict == "periodic" and judged.period == orbit.n:
        return replace(judged, **known)
    reason = f"a stable orbit is there, {number(distances[-1], 2)} of the vibration from the last point"
    return replace(
        judged,
        verdict="periodic",
        reason=reason,
        period=orbit.n,
        onset=onset if onset < len(distances) else None,
        step=float(distances[-1]),
        **known,
    )


# The largest Lyapunov exponent of a run: its case run again with a disturbance carried through it.
#
# How fast the disturbance grows is taken over blocks of the span; their scatter tells how well its mean is
# known. With a motor the exponent is at least 0, that of a shift in time; a periodic motion under an ideal
# source has a negative one.


BLOCKS = 10
EPS = 2.0**-52  # the rounding of each value of the growth, relative to what it has grown by
DOUBT = 0.05  # probability that the interval misses the exponent


def largest_exponent(result: Result, window: Window | None = None) -> Exponent | None:
    """The largest Lyapunov exponent within `window` [s], by default the second half of the run.

    None where the span is too short for intervals, where sticking or rest wiped the disturbance out, and
    where the motion has no derivative. Costs one more run on `engine`. Raises ValueError for a window outside
    the run.
    """
    span = steady_span(result, window)
    scene = replace(result.case.scene(), t_end=span.end)
    growth = lyapunov_exponents(scene, 1, span.begin).growth
    return exponent_of(growth[:, 0], growth[:, 1]) if len(growth) else None


def exponent_of(times: np.ndarray, growth: np.ndarray) -> Exponent | None:
    """The exponent from the logarithm of a disturbance's growth (n) at ascending times [s] (n).

    None with fewer than two values to a block, and where the growth is not finite.
    """
    if len(times) < 2 * BLOCKS + 1 or not np.all(np.isfinite(growth)):
        return None
    edges = np.linspace(0, len(times) - 1, BLOCKS + 1).round().astype(int)
    rate = average(np.diff(growth[edges]) / np.diff(times[edges]), DOUBT)
    rounding = len(growth) * EPS * (1 + np.abs(growth).max()) / (times[-1] - times[0])
    return Exponent(rate.mean, max(rate.half_width, float(rounding)))


# Lyapunov exponents of a case: how well they are known, and what speaks against them.


UNIT_ROUNDOFF = 2.0**-53
CLEARLY = 2.0  # blocks of chaotic motion scatter more than ten of them tell
SETTLED = 10.0  # by which the logarithms of the growth in two halves of a span may differ without a trend
PIECE = 400  # what a piece adds to the volume residual at most, in units of the tolerance: 1 to 10 were met


@dataclass(frozen=True, repr=False)
class Lyapunov(Shown):
    """Lyapunov exponents over a span of a motion, the largest first.

    Attributes
    ----------
    exponents : growth rates of small disturbances [1/s] over the span; -inf where sticking or rest took the
        direction, NaN where the motion has no derivative
    half_widths : of their 95 % intervals [1/s], from the scatter of ten blocks of the span; NaN where the
        span is too short for that
    span : begin and end [s]
    times, running : times [s] and the exponents over the span up to each of them, shape (times, exponents)
    finite_time : exponents over the time between each two neighbouring `times`, one row less
    rank_losses : directions that sticking and rest took
    volume_residual : what is missing in the identity of Liouville [-]; NaN without all exponents
    warnings : what speaks against the exponents, in sentences

    >>> import vibsim
    >>> case = vibsim.load_case("gallery/friction-oscillator", {"run.t_end": "100 s"})
    >>> spectrum = vibsim.lyapunov(case)
    >>> spectrum.exponents.round(2), spectrum.span, spectrum.rank_losses
    (array([-0.08, -0.36]), (50.0, 100.0), 0)
    """

    exponents: np.ndarray
    half_widths: np.ndarray
    span: tuple[float, float]
    times: np.ndarray
    running: np.ndarray
    finite_time: np.ndarray
    rank_losses: int
    volume_residual: float
    warnings: tuple[str, ...]

    def heading(self) -> str:
        """The number of exponents, and the span."""
        noun = "exponent" if len(self.exponents) == 1 else "exponents"
        return f"{len(self.exponents)} {noun} over {self.span[0]:.5g} to {self.span[1]:.5g} s"

    def lines(self) -> list[tuple[str, str]]:
        """The exponents with their intervals, and what speaks against them."""
        pairs = zip(self.exponents, self.half_widths, strict=True)
        lines = [
            (
                "exponents",
                ", ".join(f"{number(one, 4)} +- {number(half, 2)}" for one, half in pairs) + " 1/s",
            )
        ]
        if not np.isnan(self.volume_residual):
            lines.append(("volume", f"residual {number(self.volume_residual, 2)}"))
        return [*lines, *(("warning", text) for text in self.warnings)]


def lyapunov(
    case: "CaseLike",
    overrides: Mapping[str, object] | None = None,
    *,
    count: int | str | None = None,
    discard: float | str | None = None,
) -> Lyapunov:
    """The largest `count` Lyapunov exponents of a case, "all" or None: all of them.

    case, overrides : as of `load_case`
    discard : time [s] left out at the start, for the motion to settle, or a text such as "50 %"; None: half

    Raises ValueError for more exponents than the case has and for a transient that leaves nothing,
    EngineError (in `vibsim.engine.errors`) when the run fails.

    Of a damped oscillator x'' + c x' + x = cos(w t) that never meets its stop both are -c/2:

    >>> import vibsim
    >>> changes = {"links.spring.c": "0.2 N s/m", "stops.wall.gap": "50 m", "run.t_end": "200 s"}
    >>> vibsim.lyapunov("gallery/bilinear-oscillator", changes).exponents.round(3)
    array([-0.1, -0.1])
    """

    scene = load_case(case, by_key("overrides", overrides, '{"Omega0": "6.5 Hz"}')).scene()
    number = None if count is None or count == "all" else whole_number("count", count, 0)
    if number is not None and not 1 <= number <= dimension(scene):
        raise ValueError(f"count must be 1 to {dimension(scene)} for this case, got {count}")
    begin = transient(discard, scene.t_end)
    if not 0 <= begin < scene.t_end:
        raise ValueError(f"a transient of {begin:g} s leaves nothing of {scene.t_end:g} s")
    return judged(lyapunov_exponents(scene, number, begin), scene.tol)


def stored_exponents(result: Result) -> Lyapunov | None:
    """The exponents that a run took along (`vibsim run --lyapunov`); None where it took none."""
    attrs = {name.removeprefix("lyapunov_"): value for name, value in result.attrs.items()}
    if "growth" not in attrs:
        return None
    exponents = LyapunovExponents(
        exponents=attrs["exponents"],
        growth=attrs["growth"],
        rank_losses=attrs["rank_losses"],
        volume_residual=attrs.get("volume_residual", nan),
        tangencies=attrs["tangencies"],
        closest_tangency=attrs["closest_tangency"],
        closest_tangency_time=attrs.get("closest_tangency_time", nan),
        tangent_pieces=attrs["pieces"],
        undefined_time=attrs.get("undefined_time", nan),
    )
    return judged(exponents, attrs.get("taylor_tolerance", UNIT_ROUNDOFF))


def judged(lyapunov: LyapunovExponents, tolerance: float) -> Lyapunov:
    """Intervals and warnings for exponents as they come; tolerance: of the Taylor flow."""
    growth = lyapunov.growth
    times, sums = growth[:, 0], growth[:, 1:]
    with np.errstate(invalid="ignore"):  # -inf less -inf, in a direction that sticking took
        finite_time = np.diff(sums, axis=0) / np.diff(times)[:, None]
        finite_time[np.isneginf(sums[1:])] = -np.inf
    return Lyapunov(
        exponents=lyapunov.exponents,
        half_widths=np.array([_half_width(times, column) for column in sums.T]),
        span=lyapunov.span,
        times=times[1:],
        running=sums[1:] / (times[1:] - times[:1])[:, None],
        finite_time=finite_time,
        rank_losses=lyapunov.rank_losses,
        volume_residual=lyapunov.volume_residual,
        warnings=tuple(_warnings(lyapunov, tolerance)),
    )


def _half_width(times: np.ndarray, growth: np.ndarray) -> float:
    known = exponent_of(times, growth)
    return known.half_width if known else float("nan")


def _warnings(lyapunov: LyapunovExponents, tolerance: float) -> Iterator[str]:
    if len(lyapunov.growth) < 2:
        yield "the run ended before the span of the exponents began"
    else:
        yield from _trend(lyapunov.growth[:, 0], lyapunov.growth[:, 1])
    if isfinite(lyapunov.undefined_time):
        yield (
            f"exponents are undefined: at {lyapunov.undefined_time:.6g} s the motion grazes a rigid stop or"
            " strikes several at one instant, or the derivative of a formula is infinite there and has no"
            " integral"
        )
    if lyapunov.tangencies:
        yield (
            f"{counted(lyapunov.tangencies, 'event')} crossed almost tangentially, the closest at"
            f" {lyapunov.closest_tangency_time:.6g} s: first order holds there for tiny disturbances only"
        )
    bound = PIECE * max(tolerance, UNIT_ROUNDOFF) * lyapunov.tangent_pieces
    if abs(lyapunov.volume_residual) > bound:
        yield (
            f"volumes grow by exp({number(lyapunov.volume_residual, 2)}) more than the equations of motion"
            " let them: the exponents are not right"
        )


def _trend(times: np.ndarray, growth: np.ndarray) -> Iterator[str]:
    """A warning where the largest exponent differs clearly between the halves of the span."""
    middle = len(times) // 2
    halves = [exponent_of(times[part], growth[part]) for part in (slice(middle + 1), slice(middle, None))]
    if halves[0] is None or halves[1] is None:
        return
    apart = abs(halves[1].value - halves[0].value)
    by_chance = hypot(halves[0].half_width, halves[1].half_width)
    if apart > max(CLEARLY * by_chance, 2 * SETTLED / (times[-1] - times[0])):
        yield (
            f"the largest exponent is {number(halves[0].value, 3)} 1/s before {times[middle]:.4g} s and"
            f" {number(halves[1].value, 3)} 1/s after it: the motion has not settled"
        )

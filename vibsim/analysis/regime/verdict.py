"""The regime of a run: periodic, quasi-periodic, chaotic, or something less settled, and what says so."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import isfinite

import numpy as np

from vibsim.analysis.cycles import ROWS
from vibsim.analysis.impacts_per_cycle import happenings
from vibsim.analysis.regime.approached_orbit import decided
from vibsim.analysis.regime.points import Exponent, Judged, judge_points
from vibsim.analysis.regime.section import Coordinates, section_of
from vibsim.analysis.span import Span, steady_span
from vibsim.analysis.verdicts import RegimeVerdict, name_verdict
from vibsim.engine.columns import state_columns
from vibsim.engine.section import has_section
from vibsim.orbits.multipliers import exponents_of
from vibsim.physics.body_sets import drifting_sets
from vibsim.physics.parts import columns_of
from vibsim.physics.rates import is_driven
from vibsim.results.result import Result
from vibsim.results.windows import Window, pieces, rows_within

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
        judged = decided(judged, scene, section.states, Coordinates(scene), section.sizes)
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
    ends = {body.name: both[columns_of(body.name)[0]] for body in scene.bodies}
    return {name: float((x[1] - x[0]) / period) if name in free else 0.0 for name, x in ends.items()}


def _since(result: Result, times: np.ndarray, judged: Judged) -> tuple[float | None, int | None]:
    """When a periodic motion began to be so [s], and after how many cycles its events repeat themselves."""
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

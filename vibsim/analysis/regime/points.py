"""The verdict on a stroboscopic section, and the evidence for it.

    periodic         the points repeat themselves, up to the last one
    transient        they come closer to repeating themselves and are not there yet; or disturbances die out
    quasi-periodic   they lie on a curve, never repeat themselves, and the 0-1 test finds them regular
    chaotic          each follows from the one before, and the 0-1 test finds them chaotic
    undecided        with the reason

A largest Lyapunov exponent, where it is given, has its say: a positive one where the 0-1 test finds no chaos
is evidence against evidence, and so is another where it does. What is judged is a deterministic motion: noise
is told apart only where it hides how points follow.
"""

from dataclasses import dataclass
from math import isnan

import numpy as np

from vibsim.analysis.regime.determinism import MOST, prediction_error
from vibsim.analysis.regime.recurrence import (
    EXACT,
    LEAST,
    LONGEST,
    TOLERANCE,
    approached_period,
    find_period,
)
from vibsim.analysis.regime.zero_one_test import zero_one
from vibsim.analysis.verdicts import RegimeVerdict, name_verdict
from vibsim.cases.number import number

REGULAR, CHAOTIC = 0.1, 0.9  # |K| of the 0-1 test below, K above
FEWEST = 200  # points that the 0-1 test needs: with fewer, K of a regular motion strays up to 0.5
FOLLOWS = 0.3  # prediction error of a deterministic motion, at most; that of noise is 1
CURVE = 10.0  # prediction error times number of points on a curve, at most


@dataclass(frozen=True)
class Exponent:
    """Largest Lyapunov exponent of a motion and the half width of its interval [1/s]."""

    value: float
    half_width: float

    @property
    def sign(self) -> int:
        """1 or -1 where the interval leaves no doubt, else 0."""
        return int(np.sign(self.value)) if abs(self.value) > self.half_width else 0


@dataclass(frozen=True)
class Judged:
    """A verdict on points and its evidence; what was not worked out is None.

    Attributes
    ----------
    verdict, reason : see above
    period : after which they repeat themselves, or come closer to doing so
    onset : position of the point from which on they do
    step : distance of points a period apart, at the end, relative to the vibration
    chaos_number : K of the 0-1 test
    prediction : error of predicting points from their neighbours, relative to guessing
    multipliers, exponents : of the orbit that a periodic motion is on, or goes to: (real, imaginary) of each
        Floquet multiplier, and the Lyapunov exponents [1/s] that follow from them, None where sticking took
        the direction
    drift_rates : mean velocity of each body on that orbit [m/s], by name
    """

    verdict: RegimeVerdict | str
    reason: str
    period: int | None = None
    onset: int | None = None
    step: float | None = None
    chaos_number: float | None = None
    prediction: float | None = None
    multipliers: tuple[tuple[float, float], ...] | None = None
    exponents: tuple[float | None, ...] | None = None
    drift_rates: dict[str, float] | None = None

    def __post_init__(self) -> None:
        name_verdict(self, RegimeVerdict)


def judge_points(points: np.ndarray, exponent: Exponent | None = None) -> Judged:
    """The regime of points (n, d), each coordinate scaled to the size of the vibration."""
    if len(points) < LEAST:
        return Judged("undecided", f"{len(points)} cycles are too few, {LEAST} are needed")
    repeated = find_period(points)
    if repeated is not None:
        lasted = len(points) - repeated.onset
        reason = f"the section repeats itself within {number(TOLERANCE, 6)}, over {lasted} cycles"
        return Judged("periodic", reason, repeated.period, repeated.onset, repeated.step)
    near = approached_period(points)
    if near is not None:
        before, now = number(near.step / near.trend, 2), number(near.step, 2)
        reason = f"points a period apart come closer, from {before} to {now}"
        return Judged("transient", reason, near.period, step=near.step)
    if len(points) < FEWEST:
        reason = f"no period up to {min(LONGEST, len(points) // 5)}, and {len(points)} cycles are too few"
        return Judged("undecided", f"{reason} to tell chaos, {FEWEST} are needed")
    return _irregular(points, exponent)


def _irregular(points: np.ndarray, exponent: Exponent | None) -> Judged:
    """The verdict on points that neither repeat themselves nor come closer to it."""
    k = float(np.nanmedian([zero_one(column) for column in points.T if np.ptp(column) > EXACT]))
    prediction = prediction_error(points)
    if isnan(prediction):
        return Judged("undecided", "too many points are the same to tell how they follow", chaos_number=k)
    verdict, reason = _weighed(k, prediction, len(points), exponent.sign if exponent else None)
    return Judged(verdict, reason, chaos_number=k, prediction=prediction)


def _weighed(k: float, prediction: float, count: int, sign: int | None) -> tuple[str, str]:
    """Verdict and reason from K, the prediction error, and the sign of the exponent (None: not known)."""
    test = f"0-1 test K = {k:.2f}"
    known = {None: "", 1: ", exponent positive", 0: ", exponent near 0", -1: ", exponent negative"}[sign]
    if prediction > FOLLOWS:
        return (
            "undecided",
            f"points do not follow from neighbours (error {prediction:.2f}): noise, or too few",
        )
    if k >= CHAOTIC and sign in (1, None):
        return "chaotic", test + known
    if sign == -1 and k < CHAOTIC:
        return "transient", f"exponent negative, so it settles; no period up to {LONGEST} is near yet"
    if abs(k) <= REGULAR and sign != 1:
        if prediction * min(count, MOST) <= CURVE:
            return "quasi-periodic", f"{test}, points on a curve" + known
        return "undecided", f"{test}, but the points lie on no curve"
    if k >= CHAOTIC or (sign == 1 and abs(k) <= REGULAR):
        return "undecided", f"{test}{known}: the one speaks against the other"
    return "undecided", f"{test}{known}: between regular and chaotic"

"""The quantities that statements are about, each measured from a run, a window and an argument.

Times are in s, speeds and frequencies in Hz, lengths in m, velocities in m/s. A quantity that a run has not
got (a release that does not happen, a rate without enough cycles) is NaN. See `observables` for definitions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf, isfinite, isnan
from typing import TYPE_CHECKING

import numpy as np

from vibsim.analysis.analysis import find_frequencies
from vibsim.analysis.capture import FAR, NEAR, all_resonances, judge_capture
from vibsim.analysis.cycles import (
    BAND,
    LEAST_TURNS,
    TURN,
    TURNS,
    Hold,
    cycle_ends,
    events_within,
    holds_of,
    mean_speeds,
    span_of,
    steady_span,
)
from vibsim.analysis.drift import CYCLES, count_impacts, measure_drift
from vibsim.analysis.regime import judge_regime
from vibsim.physics.elementary import mean
from vibsim.physics.parts import Scene
from vibsim.physics.rates import has_section
from vibsim.results.columns import IMPACT_CODES
from vibsim.results.result import Result, Window
from vibsim.sweeps.computations import CAPTURE_VERDICTS as CAPTURES
from vibsim.sweeps.computations import REGIME_VERDICTS as REGIMES

if TYPE_CHECKING:
    from vibsim.cases import Case


NONE = math.nan
FEWEST_SAMPLES = 8  # in a cycle, from which a peak is known to 8 %: 1 - cos(pi/8)
Measure = Callable[[Result, Window | None, float], float]


def capture_code(result: Result, window: Window | None, argument: float) -> float:
    """Code of the verdict on capture."""
    return float(CAPTURES[judge_capture(result).verdict])


def final_speed(result: Result, window: Window | None, argument: float) -> float:
    """Mean speed over the last turns [Hz]."""
    speed = judge_capture(result).final_speed_hz
    return NONE if speed is None else speed


def longest_hold(result: Result) -> Hold | None:
    """The longest stretch within the band that lies well below the no-load speed or near a resonance."""
    scene = result.case.scene()
    assert scene.motor is not None
    times, speeds = _speeds(result)
    holds = [hold for hold in holds_of(times, speeds, scene.motor) if _is_away(hold, scene)]
    return max(holds, key=lambda hold: hold.end - hold.begin, default=None)


def _is_away(hold: Hold, scene: Scene) -> bool:
    near = any(abs(hold.speed_hz / one.hz - 1) <= NEAR for one in all_resonances(scene))
    return hold.below_no_load >= FAR or (near and hold.below_no_load > BAND)


def _speeds(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Mean speeds over TURNS turns [Hz] and their times [s]; empty where there are too few."""
    ends = cycle_ends(result, span_of(result, None).window)
    return mean_speeds(ends) if len(ends) > TURNS else (np.empty(0), np.empty(0))


def of_hold(part: Callable[[Hold], float]) -> Measure:
    """Something of the longest hold; NaN without one."""

    def measure(result: Result, window: Window | None, argument: float) -> float:
        hold = longest_hold(result)
        return NONE if hold is None else part(hold)

    return measure


def passage(result: Result, window: Window | None, argument: float) -> float:
    """Time [s] at which the mean speed last rose through `argument` [Hz]; NaN if it ends or stays below."""
    times, speeds = _speeds(result)
    times, speeds = np.append(result.time[0], times), np.append(result["phidot"][0] / TURN, speeds)
    below = np.flatnonzero(speeds < argument)
    if not len(below) or below[-1] + 1 == len(speeds):
        return NONE
    rise = slice(below[-1], below[-1] + 2)
    return float(np.interp(argument, speeds[rise], times[rise]))


def mean_speed(result: Result, window: Window | None, argument: float) -> float:
    """Whole cycles over their time [Hz]."""
    ends = cycle_ends(result, steady_span(result, window).window)
    return (len(ends) - 1) / float(ends[-1] - ends[0]) if len(ends) > 1 else NONE


def drift_rate(result: Result, window: Window | None, argument: float) -> float:
    """Of block 2 [m/s]."""
    rate = measure_drift(result, window).rate
    return NONE if rate is None else rate


def per_cycle(name: str) -> Measure:
    """Mean number of something per cycle: impacts or stick phases."""

    def measure(result: Result, window: Window | None, argument: float) -> float:
        count = getattr(count_impacts(result, window), name)
        return NONE if count is None else count

    return measure


def mean_impact_velocity(result: Result, window: Window | None, argument: float) -> float:
    """Mean closing velocity [m/s]."""
    velocity = count_impacts(result, window).velocity
    return NONE if velocity is None else velocity.mean


def impact_count(result: Result, window: Window | None, argument: float) -> float:
    """Beginnings of contact, and impacts at rigid stops."""
    events = events_within(result, span_of(result, window).window, "t", "kind")
    return float(np.count_nonzero(np.isin(events["kind"], IMPACT_CODES)))


def regime_code(result: Result, window: Window | None, argument: float) -> float:
    """Code of the verdict on the regime."""
    return float(REGIMES[judge_regime(result, window).verdict])


def period_of_motion(result: Result, window: Window | None, argument: float) -> float:
    """Cycles after which the motion repeats itself."""
    period = judge_regime(result, window).period
    return NONE if period is None else float(period)


def strongest_frequency(result: Result, window: Window | None, argument: float) -> float:
    """Of the strongest line of x1 - x2 [Hz]."""
    lines = find_frequencies(result, window).lines
    return lines[0].hz if lines else NONE


def vibration(name: str) -> Measure:
    """Half the peak-to-peak of a displacement in one cycle, mean over the cycles [m]."""

    def measure(result: Result, window: Window | None, argument: float) -> float:
        ends = cycle_ends(result, steady_span(result, window).window)
        rows = np.searchsorted(result.time, ends)
        if len(rows) < 2 or np.diff(rows).min() < FEWEST_SAMPLES:
            return NONE
        x, starts = _displacement(result, name)[: rows[-1]], rows[:-1]
        return float(mean(np.maximum.reduceat(x, starts) - np.minimum.reduceat(x, starts))) / 2

    return measure


def _displacement(result: Result, name: str) -> np.ndarray:
    """Of one column, or of the difference of two; a fixed block 2 has none, and stays at 0."""
    one, minus, other = name.partition(" - ")
    return result[one] - result[other] if minus and other in result else result[one]


def of_course(part: Callable[[np.ndarray, np.ndarray], float]) -> Measure:
    """Something of the times [s] and values [m] of `averaged`; NaN without them."""

    def measure(result: Result, window: Window | None, argument: float) -> float:
        times, x2 = averaged(result)
        return part(times, x2) if len(x2) else NONE

    return measure


def averaged(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """x2 averaged over CYCLES cycles of the source [m], and the middles of these spans [s]."""
    ends = cycle_ends(result, span_of(result, None).window)
    if len(ends) <= CYCLES:
        return np.empty(0), np.empty(0)
    time = result.time
    width = max(1, round(CYCLES * (ends[-1] - ends[0]) / (len(ends) - 1) / (time[1] - time[0])))
    if width >= len(time):
        return np.empty(0), np.empty(0)
    total = np.concatenate([[0.0], np.cumsum(result["x2"])])
    return (time[width - 1 :] + time[: len(time) - width + 1]) / 2, (total[width:] - total[:-width]) / width


def fall(times: np.ndarray, x2: np.ndarray) -> float:
    """Fall from the greatest value to the last, as a share of the greatest; NaN where none is above 0."""
    highest = float(x2.max())
    return 1 - float(x2[-1]) / highest if highest > 0 else NONE


def rest_distance(result: Result, window: Window | None, argument: float) -> float:
    """Distance needed at rest [m]."""
    return float(result.attrs.get("rest_distance_needed", NONE))


# What a statement can be about: quantities of a run, each with its unit and its definition.


@dataclass(frozen=True)
class Observable:
    """A quantity of a run.

    Attributes
    ----------
    definition : in words, for the documentation and every file
    dimension : of `cases/quantities.py`; "share" for a number that may be in percent; "" for a verdict
    measure : from the run, the window [s] (None: that of the definition) and the argument
    needs : what the scene must have, of "motor", "source", "stop", "friction"; "blocks" and
        "block2" are those of a case in the short form
    windowed : whether a statement may name a span of time
    argument : dimension of a further quantity in its phrase, such as the speed that is passed; or ""
    words : what each verdict is called -> its code
    instant : whether the value is itself the time at which it is decided
    """

    definition: str
    dimension: str
    measure: Measure
    needs: tuple[str, ...] = ()
    windowed: bool = False
    argument: str = ""
    words: Mapping[str, int] | None = None
    instant: bool = False


_HOLD = (
    f"the longest stretch, of at least {LEAST_TURNS} turns, in which the mean speed over {TURNS} turns stays "
    f"within {BAND:.0%} of its middle, {FAR:.0%} or more below the no-load speed or within {NEAR:.0%} of a "
    "resonance"
)
_LATE = "in the second half unless a span is named"
_MEAN_X2 = f"x2, averaged over {CYCLES} cycles,"
_MOTOR, _SOURCE, _STOP, _DRIVEN = ("motor",), ("source",), ("stop",), ("block2", "source")
_BLOCKS = ("blocks", "source")
VIBRATION = "vibration of "  # before displacements


def _vibration_of(name: str, needs: tuple[str, ...], dimension: str = "length") -> Observable:
    definition = f"half the peak-to-peak of {name} in one cycle, mean over the cycles {_LATE}"
    return Observable(definition, dimension, vibration(name), needs, True)


OBSERVABLES: dict[str, Observable] = {
    "capture": Observable(
        "verdict on capture, as `vibsim analyse` gives it", "", capture_code, _MOTOR, words=CAPTURES
    ),
    "final speed": Observable(
        f"mean speed over the last {TURNS} turns", "angular rate", final_speed, _MOTOR
    ),
    "mean speed": Observable(
        f"whole cycles over their time, {_LATE}", "angular rate", mean_speed, _SOURCE, True
    ),
    "released": Observable(
        f"end of {_HOLD}; none where it lasts to the end", "time",
        of_hold(lambda hold: NONE if hold.at_end else hold.end), _MOTOR, instant=True,
    ),
    "held from": Observable(f"begin of {_HOLD}", "time", of_hold(lambda hold: hold.begin), _MOTOR),
    "held for": Observable(
        f"length of {_HOLD}", "time", of_hold(lambda hold: hold.end - hold.begin), _MOTOR
    ),
    "held at": Observable(
        f"mean speed in {_HOLD}", "angular rate", of_hold(lambda hold: hold.speed_hz), _MOTOR
    ),
    "passes": Observable(
        f"when the mean speed over {TURNS} turns last rose through the speed named", "time", passage,
        _MOTOR, argument="angular rate", instant=True,
    ),
    "drift rate": Observable(
        f"of block 2, {_LATE}, as `vibsim analyse` gives it", "velocity", drift_rate, ("block2",), True
    ),
    "impacts": Observable("number of impacts", "number", impact_count, _STOP, True),
    "impacts per cycle": Observable(
        f"mean number, {_LATE}", "number", per_cycle("impacts"), ("stop", "source"), True
    ),
    "sticks per cycle": Observable(
        f"mean number, {_LATE}", "number", per_cycle("sticks"), ("friction", "source"), True
    ),
    "impact velocity": Observable(
        f"mean closing velocity, {_LATE}", "velocity", mean_impact_velocity, _STOP, True
    ),
    "regime": Observable(
        f"verdict on the regime, {_LATE}, as `vibsim analyse` gives it", "", regime_code, _SOURCE, True,
        words=REGIMES,
    ),
    "period": Observable(
        f"cycles after which a periodic motion repeats itself, {_LATE}", "number", period_of_motion,
        _SOURCE, True,
    ),
    "frequency": Observable(
        f"strongest line of x1 - x2, {_LATE}", "angular rate", strongest_frequency, _BLOCKS, True
    ),
    **{
        VIBRATION + name: _vibration_of(name, needs)
        for name, needs in (("x1", _BLOCKS), ("x2", _DRIVEN), ("x1 - x2", _BLOCKS))
    },
    "x2 peaks": Observable(
        f"when {_MEAN_X2} is greatest", "time",
        of_course(lambda times, mean: float(times[np.argmax(mean)])), _DRIVEN,
    ),
    "x2 falls": Observable(
        f"how much lower {_MEAN_X2} is at the end than at its greatest, as a share of that", "share",
        of_course(fall), _DRIVEN,
    ),
    "x2 ends": Observable(
        f"{_MEAN_X2} at the end", "length", of_course(lambda times, mean: float(mean[-1])), _DRIVEN
    ),
    "rest distance": Observable(
        "rest distance needed, max(x1 - x2)", "length", rest_distance, ("block2",)
    ),
}  # fmt: skip


def observable_of(name: str, dimension: str = "length") -> Observable:
    """The observable of that name: of OBSERVABLES, or the vibration of displacements of named bodies.

    Those are in the unit of a `dimension`: "length", or "angle" of bodies that turn.
    """
    known = OBSERVABLES.get(name)
    return known or _vibration_of(name.removeprefix(VIBRATION), _SOURCE, dimension)


def missing_of(observable: Observable, case: Case) -> list[str]:
    """Parts that an observable needs and the case does not have, in words.

    Statements on x1 and x2 are of the two blocks of the short form; a scene of named parts has none.
    """
    scene = case.scene()
    names = {
        "motor": ("a motor", scene.has_motor),
        "source": ("a source", has_section(scene)),
        "blocks": ("blocks 1 and 2 (the short form of a case)", not case.is_long),
        "block2": ("a moving block 2", not case.is_long and len(scene.bodies) > 1),
        "friction": ("friction", bool(scene.frictions) or (not case.is_long and len(scene.bodies) > 1)),
        "stop": ("a stop", scene.has_stop),
    }
    return [words for words, is_there in (names[need] for need in observable.needs) if not is_there]


# The range that a quantity should be in, and how far it is from it.


@dataclass(frozen=True)
class Bounds:
    """From `low` to `high`, both allowed; either may be infinite."""

    low: float = -inf
    high: float = inf

    def contain(self, value: float) -> bool:
        """Whether a value is in the range; NaN, where a run has no such quantity, is not."""
        return self.low <= value <= self.high

    def shortfall(self, value: float) -> float:
        """0 in the range, growing with the distance from it; 1 from one `scale` away on, and for NaN."""
        if self.contain(value):
            return 0.0
        if isnan(value):
            return 1.0
        distance = self.low - value if value < self.low else value - self.high
        return min(1.0, distance / self.scale) if self.scale else 1.0

    @property
    def scale(self) -> float:
        """Width of the range; of an open one the magnitude of its end. 0: nothing counts as near."""
        if isfinite(self.low) and isfinite(self.high):
            return self.high - self.low
        return abs(self.low if isfinite(self.low) else self.high)


# What can be wrong with the wishes for a fit.


class FitError(ValueError):
    """Statements, ranges or settings that cannot be used; the message says which, and what is allowed.

    >>> import vibsim
    >>> try:
    ...     vibsim.fit("II-B", {"c": "0.05:0 N s/m"}, ["mean_speed > 4 Hz"])
    ... except vibsim.FitError as error:
    ...     print(error)
    c=0.05:0 N s/m: a range must rise, got 0.05 to 0
    """


class FitInterrupted(Exception):
    """The user has asked to stop; what was finished is on file."""

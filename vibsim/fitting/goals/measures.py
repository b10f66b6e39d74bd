"""How the quantities that statements are about are measured, each from a run, a window and an argument.

Times are in s, speeds and frequencies in Hz, lengths in m, velocities in m/s. A quantity that a run has not
got (a release that does not happen, a rate without enough cycles) is NaN. See `observables` for definitions.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from vibsim.analysis.capture import FAR, NEAR, all_resonances, judge_capture
from vibsim.analysis.cycles import TURN, cycle_ends
from vibsim.analysis.dominant_frequencies import find_frequencies
from vibsim.analysis.drift import CYCLES, measure_drift
from vibsim.analysis.event_rows import events_within
from vibsim.analysis.holds import BAND, TURNS, Hold, holds_of, mean_speeds
from vibsim.analysis.impacts_per_cycle import count_impacts
from vibsim.analysis.regime.verdict import judge_regime
from vibsim.analysis.span import span_of, steady_span
from vibsim.physics.arithmetic.sums import mean
from vibsim.physics.parts import Scene
from vibsim.results.motion.closing_velocity import IMPACT_CODES
from vibsim.results.result import Result
from vibsim.results.windows import Window
from vibsim.sweeps.computations.capture_verdict import VERDICTS as CAPTURES
from vibsim.sweeps.computations.regime_label import VERDICTS as REGIMES

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
    """When the mean speed last rose through `argument` [Hz]; NaN where it ends below, or was never below."""
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
    """Mean number of something per cycle: impacts or sticks."""

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
    if name == "x1 - x2":
        return result["x1"] - result["x2"] if "x2" in result else result["x1"]
    return result[name]


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
    """How much lower the last value is than the greatest, as a share of that; NaN where none is above 0."""
    highest = float(x2.max())
    return 1 - float(x2[-1]) / highest if highest > 0 else NONE


def rest_distance(result: Result, window: Window | None, argument: float) -> float:
    """Distance needed at rest [m]."""
    return float(result.attrs.get("rest_distance_needed", NONE))

"""What is measured of a run: a table of plain numbers that JSON can hold, and the claims are judged by."""

from __future__ import annotations

import math
from dataclasses import asdict, is_dataclass, replace
from typing import Any

import numpy as np

from vibsim.analysis import Capture, count_impacts, find_frequencies, judge_capture, measure_drift
from vibsim.analysis.drift import STILL
from vibsim.physics.arithmetic.sums import mean
from vibsim.results import Result
from vibsim.results.windows import Window, rows_within

Numbers = dict[str, Any]

SMOOTHED = 5.0  # [s] many periods of every source: what a displacement is averaged over to find its peak
STATES = ("x1", "x2", "v1", "v2")


def measure_run(result: Result) -> Numbers:
    """All that the report needs to know of one run; lengths in m, times in s, frequencies in Hz."""
    scene, attrs = result.case.two_blocks(), result.attrs
    facts: Numbers = {
        "case_sha256": attrs["case_sha256"],
        "title": result.case.title,
        "t_end": result.t_reached,
        "trust_horizon": result.trust_horizon,
        "impacts": attrs["impacts"],
        "sticks": attrs["sticks"],
        "energy_residual_relative": attrs.get("energy_residual_relative"),
        "how": attrs.get("comment", ""),
        "rest_distance_needed": attrs.get("rest_distance_needed"),
        "greatest": {name: greatest(result[name]) for name in STATES},
        "steady": steady_amplitudes(result),
        "drift": plain(measure_drift(result)),
        "overall": overall_rate(result),
        "cycles": plain(count_impacts(result)),
        "frequencies": plain(find_frequencies(result)),
        "peak": displacement_peak(result.time, result["x2"]),
    }
    if scene.has_motor:
        capture = capture_of(result)
        facts["capture"] = plain(capture)
        if capture.since is not None:
            held = (capture.since, capture.until or result.t_reached)
            facts["held"] = {**plain(find_frequencies(result, held)), "reach": reach_at_end(result, held)}
    return facts


def capture_of(result: Result) -> Capture:
    """The verdict on capture, with the longest hold where none counts because the end is undecided.

    A motor that was let go was so whether or not its speed has settled by the end.
    """
    capture = judge_capture(result)
    if capture.verdict == "undecided" and capture.since is None and capture.holds:
        hold = max(capture.holds, key=lambda one: one.delay)
        return replace(capture, since=hold.begin, until=hold.end, speed_hz=hold.speed_hz)
    return capture


def greatest(values: np.ndarray) -> float:
    """Largest magnitude."""
    return float(np.abs(values).max())


def steady_amplitudes(result: Result) -> Numbers:
    """Greatest |v1|, |v2| and |x1 - x2| less its mean, over the second half of a run: drift left out."""
    rows = rows_within(result.time, (result.t_reached / 2, result.t_reached))
    y = result["x1"][rows] - result["x2"][rows]
    return {
        "relative": greatest(y - mean(y)),
        "v1": greatest(result["v1"][rows]),
        "v2": greatest(result["v2"][rows]),
    }


def overall_rate(result: Result) -> float:
    """Displacement of block 2 at the end over the whole time [m/s], start included."""
    return float(result["x2"][-1] - result["x2"][0]) / result.t_reached


def drifts(drift: Numbers) -> bool:
    """Whether a measured drift can be told from nothing."""
    return drift["rate"] is not None and bool(abs(drift["rate"]) > max(drift["half_width"], STILL))


def reach_at_end(result: Result, hold: Window) -> Numbers:
    """Greatest x1 - x2 [m] in the last 5 s of a hold, and in the 5 s that end 50 s before its end."""
    begin, end = hold
    last, before = (end - SMOOTHED, end), (end - 50.0 - SMOOTHED, end - 50.0)
    reach: Numbers = {"last": None, "before": None}
    for key, window in (("last", last), ("before", before)):
        rows = rows_within(result.time, window)
        if window[0] >= begin and rows.stop > rows.start:
            reach[key] = float((result["x1"][rows] - result["x2"][rows]).max())
    return reach


def displacement_peak(time: np.ndarray, x: np.ndarray) -> Numbers:
    """When x [m], averaged over SMOOTHED, is greatest; how high it is then, and at the end."""
    width = max(1, round(SMOOTHED / float(time[1] - time[0])))
    sums = np.cumsum(np.concatenate([[0.0], x]))  # one after the other, whatever the processor
    smooth = (sums[width:] - sums[:-width]) / width
    at = int(np.argmax(smooth))
    middle = float(mean(time[at : at + width]))
    return {"time": middle, "height": float(smooth[at]), "end": float(smooth[-1])}


def plain(value: Any) -> Any:
    """A verdict as JSON has it: dataclasses and mappings as objects, tuples as lists, numbers as such."""
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, dict):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value

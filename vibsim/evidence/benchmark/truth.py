"""The truth that a bench judges by: the case run once with digits to spare, kept as the nearest doubles."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from vibsim.engine.errors import EngineError
from vibsim.engine.tangent.error_growth import error_growth
from vibsim.evidence.benchmark.plan import Plan
from vibsim.results.many_digits.right_digits import DigitsPlan
from vibsim.results.many_digits.truth import TruthMemory, TruthRecording

RIGHT = 20  # digits at the end: the error of a double has 16, and two of it are to be told
FEWEST = 30
GUESS = 16.0  # digits lost over a run that fails in doubles


@dataclass(frozen=True)
class Truth:
    """States at the instants of a plan, and events.

    Attributes
    ----------
    fingerprint : of the plan that it was computed for
    samples : columns time [s], x1, v1 (, x2, v2, phi, phidot) (n)
    events : columns t [s] and kind
    attrs : digits carried and right, library, time it took [s]
    """

    fingerprint: str
    samples: Mapping[str, np.ndarray]
    events: Mapping[str, np.ndarray]
    attrs: Mapping[str, Any]


def compute_truth(plan: Plan, watch: Callable[[float], bool] | None = None) -> Truth | None:
    """The truth of a plan; None where `watch`, given the time reached [s], says False.

    Raises EngineError when the run fails, MultiprecisionMissing where no library for it is installed.
    """
    began = time.perf_counter()
    digits = max(FEWEST, ceil(_lost(plan)) + RIGHT + 2)
    while True:
        recording = TruthRecording(plan.case, digits)
        sink = TruthMemory(recording)
        recording.into(sink, watch)
        if not recording.complete:
            return None
        verdict = DigitsPlan(plan.case, digits).verdict(recording.end_state, recording.events())
        right = verdict.get("digits_right", 0)
        if right >= RIGHT:
            break
        digits += RIGHT - right + 2
    samples, events = sink.tables()
    attrs = {
        "truth_digits": digits,
        "truth_digits_right": right,
        "truth_library": recording.start["number_library"],
        "truth_wall_time_s": time.perf_counter() - began,
    }
    columns = {name: column for name, column in samples.items() if column.dtype == "f8"}
    return Truth(plan.fingerprint, columns, {name: events[name] for name in ("t", "kind")}, attrs)


def _lost(plan: Plan) -> float:
    """Digits lost over the span, about."""
    try:
        return error_growth(plan.case.scene())
    except EngineError:
        return GUESS

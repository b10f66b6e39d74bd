"""Many short looks at motor runs: what each comes to, without files and without a trust horizon.

For ensembles of starts and for searches over parameters, where hundreds of runs are needed and of each only
the verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Any

from vibsim.analysis import judge_capture, measure_drift
from vibsim.engine.errors import EngineError
from vibsim.evidence.reports.measurements import Numbers, displacement_peak
from vibsim.evidence.reports.paper_runs import Interrupted
from vibsim.results import Result, simulate
from vibsim.sweeps.schedule.workers import available_cores

if TYPE_CHECKING:
    from vibsim.cases import Case

EVERY = "100 ms"  # half a turn of the motor: its mean speed over 12 turns is known to 1 %
Advance = Callable[[int, int], bool]  # given how many are done, and of how many; False to stop


def outcomes_of(cases: Sequence[Case], advance: Advance) -> list[Numbers]:
    """The outcome of each case. Raises Interrupted when `advance` returns False."""
    return run_all([partial(outcome, case) for case in cases], advance)


def run_all(jobs: Sequence[Callable[[], Numbers]], advance: Advance) -> list[Numbers]:
    """What each job returns, all cores at work: the C engine lets go of the interpreter while it computes.

    Raises Interrupted when `advance` returns False.
    """
    found = []
    with ThreadPoolExecutor(available_cores()) as pool:
        waiting = [pool.submit(job) for job in jobs]
        for future in waiting:
            found.append(future.result())
            if not advance(len(found), len(jobs)):
                pool.shutdown(wait=False, cancel_futures=True)
                raise Interrupted
    return found


def outcome(case: Case) -> Numbers:
    """What a motor run comes to; {"failed": why} where it cannot be run."""
    try:
        return outcome_of(simulate(case.with_values({"run.every": EVERY}), trust=False))
    except EngineError as error:
        return {"failed": str(error)}


def outcome_of(result: Result) -> Numbers:
    """Capture verdict with its hold and the final speed [Hz], drift rate [m/s], and peak of x2."""
    capture, drift = judge_capture(result), measure_drift(result)
    found: dict[str, Any] = {
        "verdict": capture.verdict,
        "since": capture.since,
        "until": capture.until,
        "speed_hz": capture.speed_hz,
        "final_hz": capture.final_speed_hz,
        "drift": drift.rate,
        "peak": displacement_peak(result.time, result["x2"]),
    }
    return found

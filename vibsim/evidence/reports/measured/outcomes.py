"""Many short looks at motor runs: what each comes to, without files and without a trust horizon.

For ensembles of starts and for searches over parameters, where hundreds of runs are needed and of each only
the verdict.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future, wait
from threading import Thread
from typing import Any

from vibsim.analysis import measure_drift
from vibsim.evidence.reports.measured.measurements import Numbers, capture_of, displacement_peak
from vibsim.evidence.reports.measured.paper_runs import Interrupted
from vibsim.results import Result
from vibsim.results.cores import available_cores

PATIENCE = 0.1  # [s] until an interruption is noticed
Advance = Callable[[int, int], bool]  # given how many are done, and of how many; False to stop


def run_all(jobs: Sequence[Callable[[], Numbers]], advance: Advance) -> list[Numbers]:
    """What each job returns, all cores at work: the C engine lets go of the interpreter while it computes.

    Raises Interrupted when `advance` returns False. Nobody waits then for the jobs under way, which may take
    seconds, but the process at its end: a daemon thread, which Python ends wherever it is, may hold the lock
    of h5py, for which the end of the process would wait for ever.
    """
    results: list[Future[Numbers]] = [Future() for _ in jobs]
    waiting = deque(zip(jobs, results, strict=True))
    for _ in range(available_cores()):
        Thread(target=_work_off, args=(waiting,)).start()
    try:
        while pending := wait(results, PATIENCE).not_done:
            if not advance(len(jobs) - len(pending), len(jobs)):
                raise Interrupted
    finally:
        waiting.clear()
    advance(len(jobs), len(jobs))
    return [result.result() for result in results]


def _work_off(waiting: deque[tuple[Callable[[], Numbers], Future[Numbers]]]) -> None:
    """In a thread: take job after job, until none waits."""
    while waiting:
        try:
            job, result = waiting.popleft()
        except IndexError:  # another thread was faster
            return
        try:
            result.set_result(job())
        except BaseException as error:
            result.set_exception(error)


def outcome_of(result: Result) -> Numbers:
    """Capture verdict with its hold and the final speed [Hz], drift rate [m/s], and peak of x2."""
    capture, drift = capture_of(result), measure_drift(result)
    outcome: dict[str, Any] = {
        "verdict": capture.verdict,
        "since": capture.since,
        "until": capture.until,
        "speed_hz": capture.speed_hz,
        "final_hz": capture.final_speed_hz,
        "drift": drift.rate,
        "peak": displacement_peak(result.time, result["x2"]),
    }
    return outcome

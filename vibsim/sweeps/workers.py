"""Who computes the points: threads over the C engine, which lets go of the GIL, else processes."""

import multiprocessing
import os
import signal
import threading
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from types import TracebackType
from typing import Any

from vibsim.kernel import engine_name
from vibsim.sweeps.plan import Index, Plan, Start
from vibsim.sweeps.point import Point, compute_point


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Workers:
    """A pool of `jobs` workers for one plan, a context manager; what is unfinished at its end is given up."""

    def __init__(self, plan: Plan, jobs: int, engine: str = "auto"):
        self.plan, self.jobs, self.engine = plan, jobs, engine_name(engine)
        self._stop: Any
        self._pool: Executor
        if self.engine == "c":
            self._stop = threading.Event()
            self._pool = ThreadPoolExecutor(jobs)
        else:
            spawning = multiprocessing.get_context("spawn")
            self._stop = spawning.Event()
            self._pool = ProcessPoolExecutor(
                jobs, spawning, initializer=_prepare_process, initargs=(self._stop,)
            )

    def submit(self, index: Index, start: Start | None) -> "Future[Point | None]":
        """The point at `index`, some time; None when it was given up."""
        if isinstance(self._pool, ThreadPoolExecutor):
            return self._pool.submit(compute_point, self.plan, index, start, self.engine, self._going_on)
        return self._pool.submit(_compute_in_process, self.plan, index, start, self.engine)

    def _going_on(self) -> bool:
        return not self._stop.is_set()

    def stop(self) -> None:
        """Give up what is being computed, within milliseconds."""
        self._stop.set()

    def __enter__(self) -> "Workers":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.stop()
        self._pool.shutdown(wait=True, cancel_futures=True)


_told_to_stop: Any = None  # in a worker process: the parent's event


def _prepare_process(stop: Any) -> None:
    """A worker process hears of an interruption from its parent, not from the terminal."""
    global _told_to_stop
    _told_to_stop = stop
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _compute_in_process(plan: Plan, index: Index, start: Start | None, engine: str) -> Point | None:
    return compute_point(plan, index, start, engine, lambda: not _told_to_stop.is_set())

"""Who computes the points: threads over the C engine, which lets go of the GIL, else processes.

`vibsim.sweeps.schedule.cluster` has workers of the same kind on other machines.
"""

import signal
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from functools import partial
from types import TracebackType
from typing import Any, Protocol

from vibsim.engine.choice import engine_name
from vibsim.sweeps.points.batch import Pieces, compute_batch
from vibsim.sweeps.points.point import Point


class Workers(Protocol):
    """Takes batches of points and gives futures of their results; a context manager.

    count : batches that are computed at the same time
    batch_seconds : computing time that a batch should take [s]
    """

    batch_seconds: float

    @property
    def count(self) -> int: ...

    def submit(self, pieces: Pieces) -> "Future[list[Point]]":
        """The points of a batch, some time; fewer when it was given up."""

    def result(self, future: "Future[list[Point]]") -> list[Point]:
        """The points of a future that is done."""

    def stop(self) -> None:
        """Give up what is being computed."""

    def __enter__(self) -> "Workers": ...

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None: ...


class LocalWorkers:
    """A pool of `jobs` workers on this machine; what is unfinished at its end is given up.

    recipe : what all points have in common; compute : computes a batch of pieces by it, in a worker
    """

    batch_seconds = 0.1  # handing a batch out takes less than 1 ms; and as much may be lost to a kill

    def __init__(
        self,
        recipe: Any,
        jobs: int,
        engine: str = "auto",
        compute: Callable[..., list[Point]] = compute_batch,
    ):
        self.recipe, self.count, self.engine = recipe, jobs, engine_name(engine)
        self._stop: Any
        self._pool: Executor
        self._compute: Callable[..., list[Point]]
        if self.engine == "c":
            self._stop = threading.Event()
            self._pool = ThreadPoolExecutor(jobs)
            self._compute = partial(compute, go_on=self._going_on)
        else:
            import multiprocessing
            from concurrent.futures import ProcessPoolExecutor

            spawning = multiprocessing.get_context("spawn")
            self._stop = spawning.Event()
            self._pool = ProcessPoolExecutor(
                jobs, spawning, initializer=_prepare_process, initargs=(self._stop,)
            )
            self._compute = partial(_compute_in_process, compute)

    def submit(self, pieces: Any) -> "Future[list[Point]]":
        """The points of a batch, some time; fewer when it was given up."""
        return self._pool.submit(self._compute, self.recipe, pieces, self.engine)

    def result(self, future: "Future[list[Point]]") -> list[Point]:
        """The points of a future that is done."""
        return future.result()

    def _going_on(self) -> bool:
        return not self._stop.is_set()

    def stop(self) -> None:
        """Give up what is being computed, within milliseconds."""
        self._stop.set()

    def __enter__(self) -> "LocalWorkers":
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


def _compute_in_process(
    compute: Callable[..., list[Point]], recipe: Any, pieces: Any, engine: str
) -> list[Point]:
    return compute(recipe, pieces, engine, lambda: not _told_to_stop.is_set())

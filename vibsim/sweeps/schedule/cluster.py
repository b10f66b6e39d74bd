"""Workers on other machines: the threads of a dask.distributed cluster, given batches as those here are.

The scheduler gives a batch of a worker that dies to another one. dask is imported when it is asked for.
"""

import logging
import math
import os
import socket
import time
from concurrent.futures import CancelledError, Future
from types import TracebackType
from typing import Any

from vibsim import __version__
from vibsim.engine.choice import engine_name
from vibsim.sweeps.plan.recipe import Recipe
from vibsim.sweeps.points.batch import Pieces, compute_batch
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.schedule.signature import signature
from vibsim.sweeps.statistics.columns import FAILED

TIMEOUT = 5.0  # to reach the scheduler [s]
PATIENCE = 30.0  # for the first worker, and for another one when the last is gone [s]
COUNT_EVERY = 2.0  # the cluster's threads are counted [s]
LOGS = ("distributed.client", "tornado.application")  # which tell a lost scheduler with all tracebacks
DIED = "the workers that computed it died again and again"


class ClusterError(Exception):
    """A cluster that cannot be used; the message says why, and what to do."""


class WorkerMismatch(Exception):
    """A worker that would compute other bits; the message says in what it differs."""


class ClusterWorkers:
    """The workers of the scheduler at `address`, a context manager.

    Raises ClusterError when the scheduler cannot be reached, has no workers or is lost, and when a worker
    would not compute the same bits.
    """

    batch_seconds = 1.0  # handing a batch out takes 12 ms of client, scheduler and worker together

    def __init__(self, recipe: Recipe, address: str, engine: str = "auto"):
        self.recipe, self.address, self.engine = recipe, address, engine_name(engine)
        self._signature = signature(self.engine, recipe.compute)
        self._handed: dict[Future[list[Point]], Pieces] = {}
        self._threads = 1
        self._counted = self._deserted = -math.inf  # when; and when there last was a worker

    def __enter__(self) -> "ClusterWorkers":
        self._client = _connected(self.address)
        self._levels = {name: logging.getLogger(name).level for name in LOGS}
        for name in LOGS:
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            self._check_workers()
        except BaseException as error:
            self.__exit__(type(error), error, None)
            raise
        self._executor = self._client.get_executor(pure=False)
        return self

    def _check_workers(self) -> None:
        """Refuse a cluster one of whose workers would not compute the same bits."""
        checked = self._client.run(
            differing, self.engine, self.recipe.compute, self._signature, on_error="return"
        )
        for worker, difference in checked.items():
            if isinstance(difference, Exception):
                raise ClusterError(f"worker {worker} cannot run vibsim: {difference}")
            if difference:
                raise ClusterError(f"worker {worker} {difference}")

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for future in self._handed:
            future.cancel()
        self._client.close(timeout=TIMEOUT)
        for name, level in self._levels.items():
            logging.getLogger(name).setLevel(level)

    @property
    def count(self) -> int:
        """Threads that the cluster has just now; the last known number while it has none."""
        if self._client.status != "running":
            raise self._lost()
        now = time.monotonic()
        if now - self._counted >= COUNT_EVERY:
            self._counted, threads = now, self._count_threads()
            if threads:
                self._threads, self._deserted = threads, now
            elif now - self._deserted > PATIENCE:
                raise ClusterError(f"{self.address} has no workers left; their logs may say why")
        return self._threads

    def _count_threads(self) -> int:
        try:
            return sum(self._client.nthreads().values())
        except OSError:
            raise self._lost() from None

    def _lost(self) -> ClusterError:
        return ClusterError(f"the scheduler at {self.address} was lost")

    def submit(self, pieces: Pieces) -> "Future[list[Point]]":
        """The points of a batch, some time."""
        future: Future[list[Point]] = self._executor.submit(
            compute_there, self.recipe, pieces, self.engine, self._signature
        )
        self._handed[future] = pieces
        return future

    def result(self, future: "Future[list[Point]]") -> list[Point]:
        """The points of a batch that has come back; failed ones where it killed every worker that had it."""
        from distributed.scheduler import KilledWorker

        pieces = self._handed.pop(future)
        try:
            return future.result()
        except KilledWorker:
            return [Point(index, FAILED, "", DIED) for piece in pieces for index, _ in piece.points]
        except WorkerMismatch as error:
            raise ClusterError(str(error)) from None
        except CancelledError:
            raise self._lost() from None
        except (ModuleNotFoundError, RuntimeError) as error:
            missing = _missing_module(error)
            if missing is None:
                raise
            raise ClusterError(f"the cluster at {self.address} lacks vibsim: {missing}") from None

    def stop(self) -> None:
        """Nothing: batches that wait are cancelled one by one, those that run end within a second or so."""


def compute_there(recipe: Recipe, pieces: Pieces, engine: str, expected: dict[str, str]) -> list[Point]:
    """On a worker: the points of a batch. Raises WorkerMismatch where they would have other bits."""
    difference = differing(engine, recipe.compute, expected)
    if difference:
        raise WorkerMismatch(f"worker {socket.gethostname()}, process {os.getpid()}, {difference}")
    return compute_batch(recipe, pieces, engine)


def differing(engine: str, compute: tuple[str, ...], expected: dict[str, str]) -> str:
    """In what a worker's installation differs from the one that asks; empty where it does not."""
    if __version__ != expected["vibsim"]:
        return f"has vibsim {__version__}, and {expected['vibsim']} asks"
    try:
        ours = signature(engine, compute)
    except RuntimeError as error:
        return f"has another engine: {error}"
    if ours["statistics"] != expected["statistics"]:
        return f"has version {ours['statistics']} of the statistics, and {expected['statistics']} asks"
    if ours["bits"] != expected["bits"]:
        return "computes other last digits than this machine: another processor, numpy or C library"
    return ""


def _missing_module(error: BaseException | None) -> ModuleNotFoundError | None:
    """What worker or scheduler could not import, where that is the cause of an error."""
    while error is not None and not isinstance(error, ModuleNotFoundError):
        error = error.__cause__
    return error


def _connected(address: str) -> Any:
    """A client of the scheduler at `address` that has at least one worker."""
    try:
        from distributed import Client
    except ImportError:
        raise ClusterError("a cluster needs dask.distributed: pip install 'vibsim[cluster]'") from None
    try:
        client = Client(address, timeout=TIMEOUT, set_as_default=False, name="vibsim")
    except (OSError, ValueError) as error:
        raise ClusterError(f"no scheduler at {address}: {str(error).splitlines()[0]}") from None
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError:
        client.close()
        message = f"the scheduler at {address} has no workers; start some: dask worker {address}"
        raise ClusterError(message) from None
    return client

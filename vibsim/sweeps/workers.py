"""Who computes the points: threads over the C engine, which lets go of the GIL.

`vibsim.sweeps.workers` has workers of the same kind on other machines.
"""

import hashlib
import json
import logging
import math
import os
import platform
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from functools import cache, partial
from itertools import takewhile
from math import ceil
from types import TracebackType
from typing import Any, Protocol

from vibsim import __version__
from vibsim.analysis.cycles import HALF
from vibsim.cases import load_case
from vibsim.engine.trajectory import suits_lanes
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.sweeps.computations import fitting
from vibsim.sweeps.points import (
    SIDE_BY_SIDE,
    BatchPiece,
    Pieces,
    SweepPoint,
    Table,
    compute_batch,
    compute_point,
)
from vibsim.sweeps.quantities import DONE, FAILED, MISSING, NOT_REPRODUCIBLE, quantities_of
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import STATISTICS, Index, PointSettings, Start, SweepPlan


class Workers(Protocol):
    """Takes batches of points and gives futures of their results; a context manager.

    count : batches that are computed at the same time
    batch_seconds : computing time that a batch should take [s]
    """

    batch_seconds: float

    @property
    def count(self) -> int: ...

    def submit(self, pieces: Pieces) -> "Future[list[SweepPoint]]":
        """The points of a batch, some time; fewer when it was given up."""

    def result(self, future: "Future[list[SweepPoint]]") -> list[SweepPoint]:
        """The points of a future that is done."""

    def stop(self) -> None:
        """Give up what is being computed."""

    def __enter__(self) -> "Workers": ...

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None: ...


class LocalWorkers:
    """A pool of `jobs` workers on this machine; what is unfinished at its end is given up.

    settings : what all points have in common; compute : computes a batch of pieces by it, in a worker
    """

    batch_seconds = 0.1  # handing a batch out takes less than 1 ms; and as much may be lost to a kill

    def __init__(
        self,
        settings: Any,
        jobs: int,
        compute: Callable[..., list[SweepPoint]] = compute_batch,
    ):
        self.point_settings, self.count = settings, jobs
        self._stop = threading.Event()
        self._pool = ThreadPoolExecutor(jobs)
        self._compute = partial(compute, go_on=self._going_on)

    def submit(self, pieces: Any) -> "Future[list[SweepPoint]]":
        """The points of a batch, some time; fewer when it was given up."""
        return self._pool.submit(self._compute, self.point_settings, pieces)

    def result(self, future: "Future[list[SweepPoint]]") -> list[SweepPoint]:
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


# One chain of a sweep: the points that are computed one after another, as far as they are still to do.
#
# A stored point counts when it is done and, where a state is carried, when it began from this very start: its
# fingerprint says so. So a chain goes on from its longest valid prefix, and a failed point is tried again.
# The point after a failed one begins where the failed one began.


class Chain:
    """Hands out what is missing, in pieces; the points of one come back before the next is asked for."""

    def __init__(self, plan: SweepPlan, table: Table, indices: list[Index]):
        self._plan, self._table, self._indices = plan, table, indices
        self._at = 0
        self._start: Start | None = None

    def piece(self, most: int) -> BatchPiece | None:
        """The next points to be computed, at most so many; None at the end of the chain."""
        while self._at < len(self._indices):
            stored = self._stored(self._indices[self._at])
            if stored is None:
                return self._missing(most)
            self._pass(stored)
        return None

    def take(self, points: list[SweepPoint]) -> None:
        """Pass over the points of the last piece."""
        for point in points:
            self._pass(point)

    @property
    def ended(self) -> bool:
        """Whether all its points were passed."""
        return self._at == len(self._indices)

    def _pass(self, point: SweepPoint) -> None:
        self._at += 1
        if self._plan.carry and point.done:
            self._start = self._plan.point_settings.start_after(point.values)

    def _missing(self, most: int) -> BatchPiece:
        """From here up to the next stored point: whether that counts, only what comes before it can tell."""
        ahead = self._indices[self._at : self._at + most]
        missing = takewhile(lambda index: self._table.status[index] != DONE, ahead)
        return BatchPiece(tuple((index, self._plan.changes(index)) for index in missing), self._start)

    def _stored(self, index: Index) -> SweepPoint | None:
        table = self._table
        if table.status[index] != DONE:
            return None
        if self._plan.carry and table.sha256[index] != self._plan.point_case(index, self._start).sha256:
            table.status[index] = MISSING
            return None
        return table.point(index)


# What a sweep has still to compute, handed out in batches of a length that suits workers and end.


ROUNDS = 4  # what is left is shared out in at least so many rounds, so that no worker idles at the end
LARGEST = 1000  # points in a batch
LONGER = 8  # how many times longer a batch may take, so that its runs fill the lanes

Handed = list[tuple[Chain, BatchPiece]]


class Backlog:
    """Points to compute, in memory that does not grow with their number.

    seconds : computing time that a batch should take, so that handing it out costs little beside it
    """

    def __init__(self, plan: SweepPlan, table: Table, seconds: float):
        self._chains = (Chain(plan, table, indices) for indices in plan.chains())
        self._begun: deque[Chain] = deque()  # chains whose last piece has come back
        self._left = plan.count - table.count(DONE)
        lanes = suits_lanes(plan.case.scene()) and not plan.carry
        self._abreast = SIDE_BY_SIDE if lanes else 1
        self._seconds = seconds
        self._pace = 0.0  # computing time of a point [s], of the last ones more than of the first; 0: unknown

    def batch(self, workers: int) -> Handed:
        """The next batch, for one of so many workers; empty where there is nothing to do at the moment."""
        handed: Handed = []
        room = self._batch_size(workers)
        while room > 0 and (chain := self._next_chain()) is not None:
            piece = chain.piece(room)
            if piece is not None:
                handed.append((chain, piece))
                room -= len(piece)
                self._left -= len(piece)
        return handed

    def take(self, handed: Handed, points: list[SweepPoint]) -> None:
        """A batch has come back whole: its chains can go on, and its points tell the pace."""
        at = 0
        for chain, piece in handed:
            chain.take(points[at : at + len(piece)])
            at += len(piece)
            if not chain.ended:
                self._begun.append(chain)
        self._note(points)

    def _batch_size(self, workers: int) -> int:
        left = max(self._left, 1)
        share = max(ceil(left / (ROUNDS * workers)), min(self._abreast, ceil(left / workers)))
        if not self._pace:
            return 1
        fitting = self._seconds / self._pace
        fitting = max(fitting, min(self._abreast, LONGER * fitting))
        return max(1, min(share, int(fitting), LARGEST))

    def _next_chain(self) -> Chain | None:
        return self._begun.popleft() if self._begun else next(self._chains, None)

    def _note(self, points: Iterable[SweepPoint]) -> None:
        times = list(_times(points))
        if times:
            mean = sum(times) / len(times)
            self._pace = (self._pace + mean) / 2 if self._pace else mean


def _times(points: Iterable[SweepPoint]) -> Iterator[float]:
    return (point.values["wall_time"] for point in points if "wall_time" in point.values)


# Run a sweep: batches handed to workers and kept as they come, in any order, with the same outcome.


RUNNER_PATIENCE = 0.1  # seconds until an interruption is noticed
AHEAD = 2  # batches per worker: one that it computes, one that waits for it; bounds all memory in between

Watch = Callable[[Table], bool]  # shown the table now and then; False ends the sweep there
Active = dict["Future[list[SweepPoint]]", Handed]


def run(store: SweepStore, workers: Workers, watch: Watch | None = None) -> bool:
    """Compute the points that `store` lacks; whether all of them were reached.

    A point never depends on when, where or beside which others it is computed, so neither does the result.
    """
    backlog = Backlog(store.plan, store.table, workers.batch_seconds)
    active: Active = {}
    try:
        return _complete(store, workers, backlog, active, watch)
    except ResultFileError:  # of what is being computed nothing may be lost
        _keep_finished(store, workers, active)
        raise


def _complete(
    store: SweepStore, workers: Workers, backlog: Backlog, active: Active, watch: Watch | None
) -> bool:
    while True:
        _hand_out(store, backlog, workers, active)
        if watch is not None and not watch(store.table):
            _keep_finished(store, workers, active)
            return False
        if not active:
            return True
        for future in wait(active, RUNNER_PATIENCE, FIRST_COMPLETED).done:
            points, handed = workers.result(future), active.pop(future)
            store.add(points)
            backlog.take(handed, points)


def _hand_out(store: SweepStore, backlog: Backlog, workers: Workers, active: Active) -> None:
    count = workers.count
    while len(active) < AHEAD * count and (handed := backlog.batch(count)):
        store.make_room(sum(len(piece) for each in [handed, *active.values()] for _, piece in each))
        active[workers.submit(tuple(piece for _, piece in handed))] = handed


def _keep_finished(store: SweepStore, workers: Workers, active: Iterable["Future[list[SweepPoint]]"]) -> None:
    """Stop the workers and keep what they had finished, of batches that they had begun too."""
    workers.stop()
    running = [future for future in active if not future.cancel()]
    for future in wait(running).done:
        store.add(workers.result(future))


# What tells whether two installations compute the same bits: versions, engine, bits of two short runs.
#
# Versions alone do not: a compiler may fuse products and sums.


RUNS = ("II-B", "I-B")  # one by Taylor series, one by the closed form
LENGTH = "2 s"  # with impacts, in a few milliseconds


@cache
def signature(compute: tuple[str, ...]) -> dict[str, str]:
    """Versions and settings that must be equal here and there, name -> text, for sweeps with these
    computations.
    """
    return {
        "vibsim": __version__,
        "statistics": str(STATISTICS),
        "bits": hashlib.sha256("".join(_bits(name, compute) for name in RUNS).encode()).hexdigest()[:16],
    }


def _bits(name: str, compute: tuple[str, ...]) -> str:
    """All numbers of a short run of a shipped case."""
    case = load_case(name, {"run.t_end": LENGTH})
    settings = PointSettings(case, False, HALF, 10, None, fitting(compute, quantities_of(case)))
    point = compute_point(settings, (), {}, None)
    assert point is not None  # nobody gave it up
    values = {key: value for key, value in point.values.items() if key not in NOT_REPRODUCIBLE}
    arrays = {name: array.tolist() for name, array in point.arrays.items()}
    return json.dumps([point.error, sorted(values.items()), sorted(arrays.items())])


# Workers on other machines: the threads of a dask.distributed cluster, given batches as those here are.
#
# The scheduler gives a batch of a worker that dies to another one. dask is imported when it is asked for.


TIMEOUT = 5.0  # to reach the scheduler [s]
CLUSTER_PATIENCE = 30.0  # for the first worker, and for another one when the last is gone [s]
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

    def __init__(self, settings: PointSettings, address: str):
        self.point_settings, self.address = settings, address
        self._signature = signature(settings.compute)
        self._handed: dict[Future[list[SweepPoint]], Pieces] = {}
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
        checked = self._client.run(differing, self.point_settings.compute, self._signature, on_error="return")
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
            elif now - self._deserted > CLUSTER_PATIENCE:
                raise ClusterError(f"{self.address} has no workers left; their logs may say why")
        return self._threads

    def _count_threads(self) -> int:
        try:
            return sum(self._client.nthreads().values())
        except OSError:
            raise self._lost() from None

    def _lost(self) -> ClusterError:
        return ClusterError(f"the scheduler at {self.address} was lost")

    def submit(self, pieces: Pieces) -> "Future[list[SweepPoint]]":
        """The points of a batch, some time."""
        future: Future[list[SweepPoint]] = self._executor.submit(
            compute_there, self.point_settings, pieces, self._signature
        )
        self._handed[future] = pieces
        return future

    def result(self, future: "Future[list[SweepPoint]]") -> list[SweepPoint]:
        """The points of a batch that has come back; failed ones where it killed every worker that had it."""
        from distributed.scheduler import KilledWorker

        pieces = self._handed.pop(future)
        try:
            return future.result()
        except KilledWorker:
            return [SweepPoint(index, FAILED, "", DIED) for piece in pieces for index, _ in piece.points]
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


def compute_there(settings: PointSettings, pieces: Pieces, expected: dict[str, str]) -> list[SweepPoint]:
    """On a worker: the points of a batch. Raises WorkerMismatch where they would have other bits."""
    difference = differing(settings.compute, expected)
    if difference:
        raise WorkerMismatch(f"worker {platform.node()}, process {os.getpid()}, {difference}")
    return compute_batch(settings, pieces)


def differing(compute: tuple[str, ...], expected: dict[str, str]) -> str:
    """In what a worker's installation differs from the one that asks; empty where it does not."""
    if __version__ != expected["vibsim"]:
        return f"has vibsim {__version__}, and {expected['vibsim']} asks"
    ours = signature(compute)
    if ours["statistics"] != expected["statistics"]:
        return f"has version {ours['statistics']} of the statistics, and {expected['statistics']} asks"
    if ours["bits"] != expected["bits"]:
        return "computes other last digits than this machine: another processor, numpy or C library"
    return ""


def _missing_module(error: BaseException | None) -> ModuleNotFoundError | None:
    """Module that worker or scheduler could not import, where that is the cause of an error."""
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
        client.wait_for_workers(1, timeout=CLUSTER_PATIENCE)
    except TimeoutError:
        client.close()
        message = f"the scheduler at {address} has no workers; start some: dask worker {address}"
        raise ClusterError(message) from None
    return client

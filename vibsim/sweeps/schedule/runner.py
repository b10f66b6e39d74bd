"""Run a sweep: batches handed to workers and kept as they come, in any order, with the same outcome."""

from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, wait

from vibsim.files.errors import ResultFileError
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.schedule.backlog import Backlog, Handed
from vibsim.sweeps.schedule.workers import Workers
from vibsim.sweeps.store.point_store import Store

PATIENCE = 0.1  # seconds until an interruption is noticed
AHEAD = 2  # batches per worker: one that it computes, one that waits for it; bounds all memory in between

Watch = Callable[[Table], bool]  # shown the table now and then; False ends the sweep there
Active = dict["Future[list[Point]]", Handed]


def run(store: Store, workers: Workers, watch: Watch | None = None) -> bool:
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


def _complete(store: Store, workers: Workers, backlog: Backlog, active: Active, watch: Watch | None) -> bool:
    while True:
        _hand_out(store, backlog, workers, active)
        if watch is not None and not watch(store.table):
            _keep_finished(store, workers, active)
            return False
        if not active:
            return True
        for future in wait(active, PATIENCE, FIRST_COMPLETED).done:
            points, handed = workers.result(future), active.pop(future)
            store.add(points)
            backlog.take(handed, points)


def _hand_out(store: Store, backlog: Backlog, workers: Workers, active: Active) -> None:
    count = workers.count
    while len(active) < AHEAD * count and (handed := backlog.batch(count)):
        store.make_room(sum(len(piece) for each in [handed, *active.values()] for _, piece in each))
        active[workers.submit(tuple(piece for _, piece in handed))] = handed


def _keep_finished(store: Store, workers: Workers, active: Iterable["Future[list[Point]]"]) -> None:
    """Stop the workers and keep what they had finished, of batches that they had begun too."""
    workers.stop()
    running = [future for future in active if not future.cancel()]
    for future in wait(running).done:
        store.add(workers.result(future))

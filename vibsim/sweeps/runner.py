"""Run a sweep: points handed to workers and kept as they come, in any order, with the same outcome."""

from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from itertools import islice

from vibsim.sweeps.columns import DONE, MISSING
from vibsim.sweeps.plan import Index, Plan, Start
from vibsim.sweeps.point import Point
from vibsim.sweeps.store import Store
from vibsim.sweeps.table import Table
from vibsim.sweeps.workers import Workers

PATIENCE = 0.1  # seconds until an interruption is noticed

Watch = Callable[[Table], bool]  # shown the table now and then; False ends the sweep there
Chain = Generator[tuple[Index, Start | None], Point, None]


def run(store: Store, workers: Workers, watch: Watch | None = None) -> bool:
    """Compute the points that `store` has not got; whether all of them were reached.

    A point never depends on when, where or beside which others it is computed, so neither does the result.
    """
    waiting = _begun_chains(store.plan, store.table)
    active: dict[Future, Chain] = {}
    while True:
        for chain, (index, start) in islice(waiting, 2 * workers.jobs - len(active)):
            active[workers.submit(index, start)] = chain
        if watch is not None and not watch(store.table):
            _keep_finished(store, workers, active)
            return False
        if not active:
            return True
        for future in wait(active, PATIENCE, FIRST_COMPLETED).done:
            point, chain = future.result(), active.pop(future)
            store.add(point)
            _resubmit(chain, point, workers, active)


def _keep_finished(store: Store, workers: Workers, active: Iterable[Future]) -> None:
    """Stop the workers and keep what they had finished."""
    workers.stop()
    running = [future for future in active if not future.cancel()]
    for future in wait(running).done:
        point = future.result()
        if point is not None:
            store.add(point)


def _resubmit(chain: Chain, point: Point, workers: Workers, active: dict[Future, Chain]) -> None:
    """The next point of a chain, if it has one."""
    try:
        index, start = chain.send(point)
    except StopIteration:
        return
    active[workers.submit(index, start)] = chain


def _begun_chains(plan: Plan, table: Table) -> Iterator[tuple[Chain, tuple[Index, Start | None]]]:
    """Each chain that lacks a point, with the first one that it lacks."""
    for indices in plan.chains():
        chain = _missing_points(plan, table, indices)
        first = next(chain, None)
        if first is not None:
            yield chain, first


def _missing_points(plan: Plan, table: Table, indices: list[Index]) -> Chain:
    """Yield the points of a chain that are to be computed, with their starts; takes each result by `send`.

    A stored point counts when it is done and, where a state is carried, when it began from this very start:
    its fingerprint says so. So a chain goes on from its longest valid prefix, and a failed point is tried
    again. The point after a failed one begins where the failed one began.
    """
    start: Start | None = None
    for index in indices:
        stored = _stored(plan, table, index, start)
        point = (yield index, start) if stored is None else stored
        if plan.carry and point.done:
            start = point.end


def _stored(plan: Plan, table: Table, index: Index, start: Start | None) -> Point | None:
    if table.status[index] != DONE:
        return None
    if plan.carry and table.sha256[index] != plan.point_case(index, start).sha256:
        table.status[index] = MISSING
        return None
    return table.point(index)

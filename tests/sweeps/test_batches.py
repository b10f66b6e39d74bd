"""How points are cut into batches: none twice, none left out, few in flight, short ones at the end."""

from concurrent.futures import Future
from dataclasses import replace

import pytest

from tests.sweeps.made import OMEGA0, assert_same_points, short_case, short_plan
from vibsim.sweeps.points import SweepPoint, compute_batch
from vibsim.sweeps.quantities import DONE, FAILED
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.workers import ROUNDS, Backlog, Chain, run

CARRIED = {"carry_state": True, "direction": "both"}


class ImmediateWorkers:
    """Workers that say a point took `seconds`; they note the batches and how many are in flight."""

    batch_seconds = 1.0

    def __init__(self, plan, seconds, count=2):
        self.point_settings, self.seconds, self.count = plan.point_settings, seconds, count
        self.lengths, self.most_in_flight, self.waiting = [], 0, []

    def submit(self, pieces):
        self.lengths.append(sum(map(len, pieces)))
        future = Future()
        self.waiting.append((future, pieces))
        self.most_in_flight = max(self.most_in_flight, len(self.waiting))
        return future

    def result(self, future):
        return future.result()

    def compute_one(self):
        future, pieces = self.waiting.pop()  # the last first: the order of completion must not matter
        points = [invented(index, self.seconds) for piece in pieces for index, _ in piece.points]
        future.set_result(points)


def invented(index, seconds):
    """A point that was not computed; its end is the start of the next."""
    end = {f"end_{name}": float(sum(index)) for name in ("x1", "v1", "x2", "v2", "phi", "phidot")}
    return SweepPoint(index, DONE, "f" * 64, "", {"wall_time": seconds, **end})


def run_through(plan, workers):
    """Run a plan on such workers; the indices in the order in which they came back."""
    store, came = SweepStore(plan), []
    add = store.add
    store.add = lambda points: (came.extend(point.index for point in points), add(points))
    assert run(store, workers, lambda table: (workers.waiting and workers.compute_one()) or True)
    return came


@pytest.mark.parametrize("settings", [{}, CARRIED], ids=["fresh", "carried"])
@pytest.mark.parametrize("seconds", [1e-3, 0.05, 3.0])
def test_every_point_comes_once(settings, seconds):
    plan = short_plan({OMEGA0: "3:5:0.1 Hz", "c": "0:0.1/5"}, **settings)
    workers = ImmediateWorkers(plan, seconds)
    came = run_through(plan, workers)
    assert sorted(came) == sorted(index for chain in plan.chains() for index in chain)
    assert workers.most_in_flight <= 2 * workers.count
    for chain in plan.chains():
        assert [index for index in came if index in chain] == chain  # in the order of the chain


def test_a_batch_takes_its_time_and_the_last_are_short():
    plan = short_plan({OMEGA0: "3:5:0.001 Hz"})  # 2001 points of 50 ms: 20 fill a batch of 1 s
    workers = ImmediateWorkers(plan, 0.05)
    run_through(plan, workers)
    assert max(workers.lengths) == 20
    assert workers.lengths[-1] == 1
    # as many as fill a second each; before the pace is known and towards the end, fewer
    assert len(workers.lengths) <= 2001 / 20 + 2 * workers.count + 6 * ROUNDS * workers.count


def test_the_pace_follows_the_points():
    plan = short_plan({OMEGA0: "3:5:0.001 Hz"})
    backlog = Backlog(plan, SweepStore(plan).table, seconds=1.0)
    lengths = []
    for seconds in (0.1, 0.1, 0.1, 0.5, 0.5, 0.5, 0.5, 0.5):
        handed = backlog.batch(1)
        points = [invented(index, seconds) for _, piece in handed for index, _ in piece.points]
        lengths.append(len(points))
        backlog.take(handed, points)
    assert lengths[:3] == [1, 10, 10] and lengths[-1] == 2


def test_a_carried_batch_is_the_points_one_by_one():
    plan = short_plan(case=short_case(t_end="2 s"), carry_state=True)
    indices = next(plan.chains())
    one_by_one = SweepStore(plan)
    backlog = Backlog(plan, one_by_one.table, seconds=0.0)
    while handed := backlog.batch(1):
        (_, piece), *_ = handed
        assert len(piece) == 1
        points = compute_batch(plan.point_settings, (piece,), "c")
        one_by_one.add(points)
        backlog.take(handed, points)
    together = SweepStore(plan)
    piece = Chain(plan, together.table, indices).piece(len(indices))
    assert len(piece) == len(indices)
    together.add(compute_batch(plan.point_settings, (piece,), "c"))
    assert_same_points(together.table, one_by_one.table)


def test_a_failed_point_is_retried_alone_when_those_behind_it_hold():
    """Behind a failed point a chain begins where that one began: if it fails again, all behind it count."""
    plan = short_plan(case=short_case(t_end="2 s"), carry_state=True)
    store, indices = SweepStore(plan), next(plan.chains())
    for index in indices:
        piece = Chain(plan, store.table, indices).piece(1)
        (point,) = compute_batch(plan.point_settings, (piece,), "c")
        failing = replace(point, status=FAILED, error="so it is", values={}, arrays={})
        store.add([failing if index == (1, 0) else point])
        if index == (1, 0):
            break
    retried = Chain(plan, store.table, indices)
    assert [index for index, _ in retried.piece(10).points] == indices[1:]
    retried.take([store.table.point((1, 0))])  # it failed again
    rest = retried.piece(10)
    store.add(compute_batch(plan.point_settings, (rest,), "c"))
    again = Chain(plan, store.table, indices)
    assert [index for index, _ in again.piece(10).points] == [(1, 0)]
    again.take([store.table.point((1, 0))])
    assert again.piece(10) is None

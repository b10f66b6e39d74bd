"""How points are cut into batches: none twice, none left out, few in flight, short ones at the end."""

import os
import subprocess
import sys
from concurrent.futures import Future
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import vibsim
from tests.sweeps.made import (
    OMEGA0,
    assert_same_points,
    complete,
    in_memory,
    run_stored,
    short_case,
    short_plan,
)
from vibsim.engine.errors import EngineError, State
from vibsim.engine.trajectory import open_trajectory
from vibsim.results.simulation import open_result
from vibsim.sweeps import statistics
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
        points = compute_batch(plan.point_settings, (piece,))
        one_by_one.add(points)
        backlog.take(handed, points)
    together = SweepStore(plan)
    piece = Chain(plan, together.table, indices).piece(len(indices))
    assert len(piece) == len(indices)
    together.add(compute_batch(plan.point_settings, (piece,)))
    assert_same_points(together.table, one_by_one.table)


def test_a_failed_point_is_retried_alone_when_those_behind_it_hold():
    """Behind a failed point a chain begins where that one began: if it fails again, all behind it count."""
    plan = short_plan(case=short_case(t_end="2 s"), carry_state=True)
    store, indices = SweepStore(plan), next(plan.chains())
    for index in indices:
        piece = Chain(plan, store.table, indices).piece(1)
        (point,) = compute_batch(plan.point_settings, (piece,))
        failing = replace(point, status=FAILED, error="so it is", values={}, arrays={})
        store.add([failing if index == (1, 0) else point])
        if index == (1, 0):
            break
    retried = Chain(plan, store.table, indices)
    assert [index for index, _ in retried.piece(10).points] == indices[1:]
    retried.take([store.table.point((1, 0))])  # it failed again
    rest = retried.piece(10)
    store.add(compute_batch(plan.point_settings, (rest,)))
    again = Chain(plan, store.table, indices)
    assert [index for index, _ in again.piece(10).points] == [(1, 0)]
    again.take([store.table.point((1, 0))])
    assert again.piece(10) is None


# A point does not depend on when, where and beside which others it is computed.


SETTINGS = {
    "fresh": {},
    "carried up and down": {"carry_state": True, "direction": "both"},
    "carried down": {"carry_state": True, "direction": "down"},
}


def table(plan, jobs):
    result, finished = run_stored(SweepStore(plan), jobs)
    assert finished and result.complete
    return result.table


@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
@pytest.mark.parametrize("case", ["II-B", "I-B"])
def test_any_number_of_jobs_gives_the_same_bits(settings, case):
    axis = {OMEGA0 if case == "II-B" else "omega": "3:5:0.5 Hz", "c": "0.001, 0.03"}
    plan = short_plan(axis, short_case(case), **settings)
    one = table(plan, 1)
    assert one.count(DONE) == plan.count == 5 * 2 * len(plan.directions)
    for jobs in (2, 5):
        assert_same_points(table(plan, jobs), one)


def test_a_carried_point_begins_where_the_one_before_ended():
    plan = short_plan({OMEGA0: "3, 4 Hz"}, carry_state=True, direction="both")
    result, _ = run_stored(SweepStore(plan), 1)
    order = [(0, 0), (1, 0), (1, 1), (0, 1)]  # up, then back down
    assert result.case_at(order[0]).number("initial.x1") == 0.0
    for before, after in pairwise(order):
        case = result.case_at(after)
        for name in ("x1", "v1", "x2", "v2", "phi", "phidot"):
            assert case.number(f"initial.{name}") == result[f"end_{name}"][before]
        assert case.sha256 == result["sha256"][after]


def test_a_carried_harmonic_force_has_no_jump():
    """4 s at 3.3 Hz end in a period; the state carried on is that at its last whole one, 13/3.3 s."""
    plan = short_plan({"omega": "3.3, 3.4 Hz"}, short_case("I-B"), carry_state=True)
    result, _ = run_stored(SweepStore(plan), 1)
    state = vibsim.simulate(result.case_at((0, 0))).at(13 / 3.3)
    for name in ("x1", "v1", "x2", "v2"):
        # an instant is rounded to 1e-16 of 4 s, and the state changes at up to 100 units per second
        assert result[f"end_{name}"][0, 0] == pytest.approx(float(state[name]), rel=1e-9, abs=1e-13)


def test_fresh_points_do_not_depend_on_the_direction():
    result, _ = run_stored(SweepStore(short_plan(direction="both")), 2)
    for name in ("mean_speed", "amplitude_x1", "end_x2"):
        assert (result[name][:, 0] == result[name][:, 1]).all()


# Points that fail: kept with their reason, tried again, and no harm to the others.


def test_a_failed_point_is_kept_with_its_reason_and_tried_again(tmp_path, monkeypatch):
    def failing(scene, *arguments, **options):
        if abs(scene.motor.Omega0 / 2 / np.pi - 4) < 1e-9:
            raise EngineError("diverged", State(1.5, [1.5], [1.5], 1.5, 1.5, 1.5))
        return open_trajectory(scene, *arguments, **options)

    plan, path = short_plan({OMEGA0: "3, 4, 5 Hz"}, carry_state=True), tmp_path / "sweep.h5"
    monkeypatch.setattr(statistics, "open_trajectory", failing)
    result, _ = complete(plan, path)
    assert result["status"].ravel().tolist() == [DONE, FAILED, DONE]
    assert "t = 1.5 s: the state is no longer finite" in result["error"][1, 0]
    assert np.isnan(result["mean_speed"][1, 0]) and result.complete
    assert result.case_at((2, 0)).number("initial.x1") == result["end_x1"][0, 0]  # passes over the failed one
    monkeypatch.undo()
    again, _ = complete(plan, path)
    assert_same_points(again.table, in_memory(plan))


def test_a_point_whose_case_is_not_allowed_fails_alone():
    """Each value alone is allowed; together t_end and every make too many samples."""
    plan = short_plan({"t_end": "1, 100 s", "every": "1e-9, 1 s"}, short_case(run__every="1 s"))
    result, _ = run_stored(SweepStore(plan), 1)
    assert result["status"][:, :, 0].tolist() == [[DONE, DONE], [FAILED, DONE]]
    assert "samples" in result["error"][1, 0, 0]


def test_a_bug_at_one_point_does_not_stop_the_others(monkeypatch):
    from vibsim.sweeps import points

    class Faulty(points.Statistics):
        def update(self, block):
            if abs(self.scene.motor.Omega0 / 2 / np.pi - 4) < 1e-9:
                raise ZeroDivisionError("by nothing")
            super().update(block)

    monkeypatch.setattr(points, "Statistics", Faulty)
    result, _ = run_stored(SweepStore(short_plan({OMEGA0: "3, 4, 5 Hz"})), 2)
    assert result["status"].ravel().tolist() == [DONE, FAILED, DONE]
    assert result["error"][1, 0].startswith(
        "a bug in vibsim, please report it: ZeroDivisionError: by nothing (test_"
    )


def test_a_motion_too_fast_to_take_statistics_of_fails_alone():
    """10^300 turns a second over 2 s are no 10^10 samples; nor are 2 s in steps of 10^-30 s."""
    result, _ = run_stored(SweepStore(short_plan({OMEGA0: "1e300, 4 Hz"})), 1)
    assert result["status"].ravel().tolist() == [FAILED, DONE]
    assert "more than 1e10 samples" in result["error"][0, 0]
    result, _ = run_stored(SweepStore(short_plan({OMEGA0: "4 Hz"}, every="1e-30 s")), 1)
    assert "more than 1e10 samples" in result["error"][0, 0]


# A disk that fills up during a sweep: a clear message, and no point that was computed is lost.


SWEEP = """
import os, resource, sys
from vibsim.command_line.main import main
limit, section = int(sys.argv[1]), sys.argv[2]
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))  # no file grows beyond that
sys.argv[1:] = "sweep II-B --omega0 3:5:0.1 --t-end 2s -j 2 -o s.h5 --section".split() + [section]
main()
"""
AXES = {"excitation.Omega0": "3:5:0.1 Hz"}


def size_without_points(plan, path):
    with SweepStore(plan, path):
        size = os.path.getsize(path)
    path.unlink()
    return size


@pytest.mark.skipif(sys.platform == "win32", reason="needs limits of a process")
@pytest.mark.parametrize(
    ("section", "further", "left"),
    [
        (100, 500, ["s.h5", "s.h5.journal"]),  # room for the journal, none for the file that takes it up
        (1500, 600_000, ["s.h5"]),  # room for the file, none for the journal of all points
    ],
)
def test_nothing_computed_is_lost(tmp_path, section, further, left):
    plan, path = short_plan(AXES, short_case(t_end="2 s"), section=section), tmp_path / "s.h5"
    limit = size_without_points(plan, path) + further
    command = [sys.executable, "-c", SWEEP, str(limit), str(section)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 6
    assert "disk full; " in done.stderr and "and the same command resumes it" in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted(os.listdir(tmp_path)) == left
    open_result(path)
    store = SweepStore(plan, path)
    kept = store.table.count(DONE)
    store._journal.close(remove=False)
    assert kept > 0
    result, computed = complete(plan, path)
    assert len(computed) == plan.count - kept
    assert_same_points(result.table, in_memory(plan))
    assert os.listdir(tmp_path) == ["s.h5"]

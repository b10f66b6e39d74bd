"""Sweeps on a cluster of real processes: the same bits, workers killed or foreign, no scheduler."""

import os
import signal
import socket
import time
from contextlib import contextmanager

import pytest

from tests.command_line.made import begun, call
from tests.sweeps.clusters import loopback_cluster
from tests.sweeps.made import (
    OMEGA0,
    assert_same_points,
    batches_of_one,
    in_memory,
    short_case,
    short_plan,
    swept,
    until,
)
from vibsim.results.simulation import open_result
from vibsim.sweeps.quantities import FAILED
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import STATISTICS
from vibsim.sweeps.sweeping import complete
from vibsim.sweeps.workers import DIED, ClusterError, ClusterWorkers

pytest.importorskip("distributed")
CARRIED = {"carry_state": True, "direction": "both"}


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with loopback_cluster(tmp_path_factory.mktemp("cluster")) as running:
        yield running


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """A machine that does much else takes its time to answer."""
    for name in ("TIMEOUT", "CLUSTER_PATIENCE"):
        monkeypatch.setattr(f"vibsim.sweeps.workers.{name}", 100.0)


def on(cluster, store, watch=None, **options):
    with ClusterWorkers(store.plan.point_settings, cluster.address, **options) as workers:
        return complete(store, workers, watch)


@pytest.mark.parametrize("settings", [{}, CARRIED], ids=["fresh", "carried"])
def test_a_cluster_gives_the_same_bits(cluster, settings):
    plan = short_plan({OMEGA0: "3:5:0.25 Hz", "c": "0.001, 0.03"}, compute=["all"], **settings)
    result, finished = on(cluster, SweepStore(plan))
    assert finished and result.table.done
    assert_same_points(result.table, in_memory(plan))


def test_an_interrupted_cluster_sweep_goes_on_here(cluster, tmp_path):
    plan, path = short_plan({OMEGA0: "3:5:0.05 Hz"}, short_case(t_end="20 s")), tmp_path / "s.h5"
    with batches_of_one():
        _, finished = on(cluster, SweepStore(plan, path), until(4))
    left = open_result(path)
    assert not finished and 4 <= left.table.count(1) < plan.count
    result = swept(plan, path)
    assert_same_points(result.table, in_memory(plan))


def test_batches_in_flight_are_bounded(cluster):
    plan = short_plan({OMEGA0: "3:5:0.005 Hz"}, short_case(t_end="1 s"))
    store, most = SweepStore(plan), 0
    with ClusterWorkers(plan.point_settings, cluster.address) as workers:

        def watch(table):
            nonlocal most
            most = max(most, len(workers._handed))
            return True

        assert complete(store, workers, watch)[1]
    assert 2 <= most <= 4 and not workers._handed


def test_a_worker_that_computes_other_bits_is_refused(cluster, monkeypatch):
    plan = short_plan({OMEGA0: "3, 4 Hz"})
    for key, value, message in [
        ("vibsim", "9.9", "has vibsim .*, and 9.9 asks"),
        ("statistics", "99", f"has version {STATISTICS} of the statistics, and 99 asks"),
        ("bits", "0", "computes other last digits than this machine"),
    ]:
        workers = ClusterWorkers(plan.point_settings, cluster.address)
        workers._signature = {**workers._signature, key: value}
        with pytest.raises(ClusterError, match=f"worker tcp://.* {message}"), workers:
            pass
        workers = ClusterWorkers(plan.point_settings, cluster.address)
        with pytest.raises(ClusterError, match=rf"worker .*, process \d+, {message}"), workers:
            workers._signature = {**workers._signature, key: value}  # as a worker finds it that joins later
            complete(SweepStore(plan), workers)


@pytest.mark.slow
@pytest.mark.parametrize("who", ["scheduler", "worker"])
def test_a_cluster_without_vibsim_is_refused(tmp_path, who):
    (tmp_path / "no").mkdir()
    (tmp_path / "no" / "vibsim.py").write_text("raise ModuleNotFoundError(\"No module named 'vibsim'\")")
    lacking = {"PYTHONPATH": str(tmp_path / "no")}
    with loopback_cluster(tmp_path, 0, **(lacking if who == "scheduler" else {})) as cluster:
        cluster.add_worker(**(lacking if who == "worker" else {}))
        plan = short_plan({OMEGA0: "3, 4 Hz"})
        with pytest.raises(ClusterError, match=r"vibsim: .*No module named 'vibsim'"):
            on(cluster, SweepStore(plan))


def test_points_that_kill_every_worker_fail_and_the_others_do_not(cluster, monkeypatch):
    from distributed.scheduler import KilledWorker

    plan = short_plan({OMEGA0: "3, 4 Hz"}, short_case(t_end="1 s"))
    with ClusterWorkers(plan.point_settings, cluster.address) as workers:
        result = workers.result

        def deadly(future):
            if any(index == (1, 0) for piece in workers._handed[future] for index, _ in piece.points):
                future.result()
                future._result, future._exception = None, KilledWorker("compute", None, 3)
            return result(future)

        monkeypatch.setattr(workers, "result", deadly)
        table = complete(SweepStore(plan), workers)[0].table
    assert table.status[:, 0].tolist() == [1, FAILED] and table.error[1, 0] == DIED


@contextmanager
def long_sweep(folder, cluster):
    """A sweep by a cluster as a process of its own, once some points are done."""
    words = ["--omega0", "3:7:0.01", "--t-end", "60s", "--scheduler", cluster.address, "-o", "s.h5"]
    with begun("sweep", "II-B", *words, cwd=folder) as process:
        journal = folder / "s.h5.journal"
        while not (journal.exists() and journal.read_text().count("\n") > 3):
            assert process.poll() is None
            time.sleep(0.01)
        yield process


def test_nobody_there(here, monkeypatch):
    monkeypatch.setattr("vibsim.sweeps.workers.TIMEOUT", 0.5)
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{unused.getsockname()[1]}"
        done = call("sweep", "II-B", "--omega0", "3,4", "--scheduler", address)
    assert done.exit_code == 4
    assert done.stderr.startswith(f"Error: no scheduler at {address}: ")
    assert list(here.iterdir()) == []


def test_jobs_do_not_go_with_a_scheduler():
    done = call("sweep", "II-B", "--omega0", "3,4", "--scheduler", "tcp://127.0.0.1:1", "-j", 2)
    assert done.exit_code == 2 and "jobs are the workers of this machine" in done.stderr


def test_interrupting_the_command_keeps_what_is_finished(cluster, tmp_path):
    with long_sweep(tmp_path, cluster) as process:
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=100)
    assert process.returncode == 130 and "interrupted: s.h5 holds what was done" in said
    left = open_result(tmp_path / "s.h5")
    assert not left.complete and left.attrs["points_done"] >= 3


def test_a_killed_worker_costs_nothing_but_time(cluster, tmp_path):
    """SIGKILL to one of three workers in the middle of the sweep; the others compute its batches again."""
    plan = short_plan({OMEGA0: "3:5:0.05 Hz"}, short_case(t_end="20 s"))
    killed = []

    def watch(table):
        if table.count(1) >= 5 and not killed:
            killed.append(cluster.workers.pop())
            os.kill(killed[0].pid, signal.SIGKILL)
        return True

    cluster.add_worker()
    cluster.await_workers(3)
    with ClusterWorkers(plan.point_settings, cluster.address) as workers:
        assert workers.count == 3
        result, finished = complete(SweepStore(plan, tmp_path / "s.h5"), workers, watch)
        assert killed[0].wait() == -signal.SIGKILL
        assert finished and result.table.done
    assert_same_points(open_result(tmp_path / "s.h5").table, in_memory(plan))


@pytest.mark.slow
def test_a_scheduler_that_dies_ends_the_sweep_and_keeps_what_is_finished(tmp_path):
    with loopback_cluster(tmp_path) as cluster, long_sweep(tmp_path, cluster) as process:
        cluster.scheduler.kill()
        _, said = process.communicate(timeout=100)
    assert process.returncode == 4, said
    assert f"Error: the scheduler at {cluster.address} was lost" in said and "Traceback" not in said
    assert open_result(tmp_path / "s.h5").attrs["points_done"] >= 3

"""What handing points to a dask cluster costs: CPU time of client, scheduler and workers per batch and point.

    python tests/budgets/cluster_overhead.py [--no-profile]

Two workers on this machine, whose points sleep for 50 ms instead of computing: all CPU time is overhead.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests.sweeps.clusters import ROOT, loopback_cluster
from vibsim.cases import load_case
from vibsim.sweeps import workers as sweep_workers
from vibsim.sweeps.points import SweepPoint
from vibsim.sweeps.quantities import DONE
from vibsim.sweeps.sweep_file import SweepStore
from vibsim.sweeps.sweep_plan import SweepPlan
from vibsim.sweeps.sweeping import complete, make_plan

POINT = 0.05  # seconds
# dask samples what its workers do a hundred times a second unless it is told not to
PROFILE = {"DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"} if "--no-profile" in sys.argv else {}
TICK = os.sysconf("SC_CLK_TCK")


def sleep_there(settings, pieces, expected):
    """In place of `compute_there`: points as large as real ones that take their time without computing."""
    found = []
    for piece in pieces:
        for index, _ in piece.points:
            time.sleep(POINT)
            values = {f"value{i}": float(i) for i in range(34)} | {"wall_time": POINT}
            arrays = {f"section{i}": np.random.random(100) for i in range(3)}
            found.append(SweepPoint(index, DONE, "0" * 64, "", values, arrays))
    return found


def cpu_seconds(pid):
    """User and system time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICK


class CountedWorkers(sweep_workers.ClusterWorkers):
    """Workers that count the batches that they are handed."""

    handed = 0

    def submit(self, pieces):
        self.handed += 1
        return super().submit(pieces)


def measured(running, plan: SweepPlan, folder: Path, batch_seconds: float):
    """Run a plan; CPU times of client, scheduler and workers [s], batches and wall time."""
    sweep_workers.ClusterWorkers.batch_seconds = batch_seconds
    with CountedWorkers(plan.point_settings, running.address) as workers:
        pids = [running.scheduler.pid, *(worker.pid for worker in running.workers)]
        before, began, own = [cpu_seconds(pid) for pid in pids], time.perf_counter(), time.process_time()
        complete(SweepStore(plan, folder / f"{plan.count}-{batch_seconds}.h5"), workers)
        wall, own = time.perf_counter() - began, time.process_time() - own
        after = [cpu_seconds(pid) for pid in pids]
    scheduler, *others = (b - a for a, b in zip(before, after, strict=True))
    return own, scheduler, sum(others), workers.handed, wall


def main():
    sweep_workers.compute_there = sleep_there
    case = load_case("II-B", {"run.t_end": "1 s"})
    with tempfile.TemporaryDirectory() as name, loopback_cluster(Path(name), 0) as running:
        for _ in range(2):
            running.add_worker(PYTHONPATH=str(ROOT), **PROFILE)
        warm = False
        for count, seconds in ((200, 1.0), (200, 0.0), (1000, 0.25), (1000, 1.0), (1000, 2.0)):
            plan = make_plan(case, [("excitation.Omega0", f"3:7/{count} Hz", "")])
            own, scheduler, workers, batches, wall = measured(running, plan, Path(name), seconds)
            if not warm:
                warm = True
                continue
            total = own + scheduler + workers
            print(
                f"batches of {seconds:4.2f} s: {batches:4d} of {count / batches:5.1f} points; per batch "
                f"{total / batches * 1e3:5.2f} ms (client {own / batches * 1e3:.2f}, scheduler "
                f"{scheduler / batches * 1e3:.2f}, workers {workers / batches * 1e3:.2f}); per point "
                f"{total / count * 1e3:.2f} ms, {total / count / POINT * 100:.1f} % of 50 ms; "
                f"wall {wall:.1f} s, {wall / (count * POINT / 2) * 100 - 100:+.0f} % over two workers' time"
            )


if __name__ == "__main__":
    main()

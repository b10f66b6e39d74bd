"""What a point of a sweep costs beside its run, in CPU time, memory and bytes.

    python tests/budgets/sweep_costs.py

CPU time does not count waiting, so it may be taken while other programs run.
"""

import json
import pickle
import resource
import tempfile
import time
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path

import numpy as np

from vibsim.cases import load_case
from vibsim.results.store import from_plain
from vibsim.sweeps.computations import COMPUTATIONS, fitting
from vibsim.sweeps.points import BatchPiece, SweepPoint, Table, compute_batch, compute_point
from vibsim.sweeps.quantities import DONE, quantities_of
from vibsim.sweeps.statistics import MeasuredRun, sampled_for_statistics
from vibsim.sweeps.sweep_file import SweepStore, write_sweep
from vibsim.sweeps.sweep_plan import SweepPlan
from vibsim.sweeps.sweeping import make_plan
from vibsim.sweeps.workers import Backlog, run

OMEGA0 = "excitation.Omega0"
MICRO = 1e6


def cpu(action, repetitions=1):
    """CPU time [s] of one call, user and system of all threads; the least of three rounds."""
    return min(_cpu(action, repetitions) for _ in range(3))


def _cpu(action, repetitions):
    began = time.process_time()
    for _ in range(repetitions):
        action()
    return (time.process_time() - began) / repetitions


def grid(points, t_end="300 s", **settings):
    """A plan of so many points of II-B over two axes."""
    axes = [(OMEGA0, "3:7/100 Hz", ""), ("c", f"0.001:0.05/{points // 100}", "")]
    return make_plan(load_case("II-B", {"run.t_end": t_end}), axes, **settings)


def computing():
    """CPU time of points of 300 s: engine alone, the whole point, many at once, and with each computation."""
    plan = grid(200)
    indices = [(i, 0, 0) for i in range(0, 100, 10)]

    def engine():
        for index in indices:
            scene = sampled_for_statistics(plan.point_case(index).scene())
            for _ in MeasuredRun(scene, plan.point_settings.of, scene.t_end / 2).blocks():
                pass

    def points(names):
        settings = grid(200, compute=names).point_settings
        return lambda: [compute_point(settings, i, plan.changes(i), None) for i in indices]

    together = [(i, 0, 0) for i in range(0, 100, 3)]
    piece = BatchPiece(tuple((i, plan.changes(i)) for i in together), None)
    batch = cpu(lambda: compute_batch(plan.point_settings, (piece,))) / len(together)
    alone = cpu(engine) / len(indices)
    whole = cpu(points([])) / len(indices)
    case = cpu(lambda: [plan.point_case(i).sha256 for i in indices]) / len(indices)
    print(f"engine, a point of 300 s       {alone * 1e3:8.2f} ms")
    print(f"  + case, statistics, section  {whole * 1e3:8.2f} ms  (+{(whole / alone - 1) * 100:.0f} %)")
    print(f"    of which its case          {case * 1e3:8.2f} ms")
    print(f"a point in a batch             {batch * 1e3:8.2f} ms")
    for name in fitting(COMPUTATIONS, quantities_of(plan.case)):
        print(f"  + {name:<26s} {(cpu(points([name])) / len(indices) - whole) * 1e3:8.2f} ms")


def unlike(plan: SweepPlan, made: SweepPoint, points: int):
    """So many points, as incompressible as real ones: no two numbers alike."""
    draw = np.random.default_rng(1)
    for i in range(points):
        factors = iter((1 + draw.random(len(made.values))).tolist())
        values = {name: value * next(factors) for name, value in made.values.items()}
        arrays = {name: array * (1 + draw.random(len(array))) for name, array in made.arrays.items()}
        yield SweepPoint((i % 100, i // 100, 0), DONE, draw.bytes(32).hex(), "", values, arrays)


def a_point(plan: SweepPlan, index) -> SweepPoint:
    return compute_point(plan.point_settings, index, plan.changes(index), None)


def keeping(points: int, section: int):
    """Client and file, per point: handing out, sending, keeping in table and journal, writing, reading."""
    plan = grid(points, t_end="100 s", section=section)
    moved = list(unlike(plan, a_point(plan, (40, 0, 0)), points))
    backlog = Backlog(plan, Table(plan), seconds=1.0)
    backlog._pace = 0.05

    def hand_out():
        while backlog.batch(2):
            pass

    handing = _cpu(hand_out, 1) / points
    sent = pickle.dumps(moved[:20])
    sending = cpu(lambda: pickle.loads(pickle.dumps(moved[:20])), 20) / 20
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "s.h5"
        with SweepStore(plan, path) as store:
            table = store.table
            store._next = float("inf")
            keeping = _cpu(lambda: [store.add(moved[i : i + 20]) for i in range(0, points, 20)], 1) / points
            journal = store._journal.path.stat().st_size / points

            def read():
                for each in store._journal.read(plan.fingerprint):
                    table.put(from_plain(SweepPoint, each))

            reading = _cpu(read, 1) / points
        writing = _cpu(lambda: write_sweep(path, plan, table, store.all_attrs), 1) / points
        size = path.stat().st_size / points
    held = sum(array.nbytes for array in table.numbers.values()) / points
    held += (table.status.nbytes + table.sha256.nbytes + table.error.nbytes) / points
    print(f"{points} points, section of {section}, per point:")
    print(f"  handing out                  {handing * MICRO:8.1f} us")
    print(f"  packing and unpacking        {sending * MICRO:8.1f} us, {len(sent) / 20:.0f} bytes on the wire")
    print(f"  table and journal            {keeping * MICRO:8.1f} us, {journal:.0f} bytes in the journal")
    print(f"  reading the journal          {reading * MICRO:8.1f} us")
    print(f"  writing the file             {writing * MICRO:8.1f} us, {size:.0f} bytes")
    print(f"  memory of the table                    {held:.0f} bytes")


class Inventing:
    """Workers that take no time: every point is the same one."""

    batch_seconds, count = 1.0, 2

    def __init__(self, made: SweepPoint):
        self.made = made

    def submit(self, pieces):
        future = Future()
        points = [replace(self.made, index=index) for piece in pieces for index, _ in piece.points]
        future.set_result(points)
        return future

    def result(self, future):
        return future.result()


def large(points: int, section: int):
    """A whole sweep of so many points without their computing: CPU time and peak memory of the client."""
    plan = grid(points, t_end="100 s", section=section)
    made = a_point(plan, (40, 0, 0))
    made.values["wall_time"] = 0.05
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with tempfile.TemporaryDirectory() as folder:

        def go():
            with SweepStore(plan, Path(folder) / "s.h5") as store:
                run(store, Inventing(made))

        took = _cpu(go, 1)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    print(f"{points} points, section of {section}, the whole client, per point:")
    print(f"  CPU time {took / points * MICRO:.1f} us, peak memory {grown / points:.0f} bytes")


def sending_the_recipe():
    """What goes along with every batch."""
    settings = grid(1000).point_settings
    packed = pickle.dumps(settings)
    took = cpu(lambda: pickle.loads(pickle.dumps(settings)), 100)
    print(f"settings, once per batch         {took * MICRO:8.1f} us, {len(packed)} bytes")
    print(f"settings in the file           {len(json.dumps(grid(1000).settings))} bytes for 1000 points")


if __name__ == "__main__":
    large(100_000, 0)  # first, so that the peak of memory is theirs
    large(1_000_000, 0)
    keeping(10_000, 100)
    keeping(100_000, 0)
    sending_the_recipe()
    computing()

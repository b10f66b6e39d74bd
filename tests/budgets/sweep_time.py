"""Budget: a sweep takes its engine time shared among the cores, and 1.5 s."""

import tempfile
from pathlib import Path
from statistics import median

from tests.budgets.engine_clock import EngineClock
from tests.budgets.processes import VIBSIM, seconds
from tests.budgets.row import Row
from vibsim.cases import load_case
from vibsim.engine.blocks_ahead import available_cores
from vibsim.sweeps.quantities import quantities_of
from vibsim.sweeps.statistics import MeasuredRun, sampled_for_statistics

POINTS, OVERHEAD = 81, 1.5
REPETITIONS = 3


def rows():
    engine = median(engine_seconds(5.5) for _ in range(7))
    cores = available_cores()
    limit = POINTS * engine / cores + OVERHEAD
    every_point = sum(engine_seconds(3 + i / 20) for i in range(POINTS))
    notes = [
        f"limit: 81 x {engine * 1e3:.1f} ms (300 s of II-B as the sweep runs it) / {cores} cores + 1.5 s",
        f"its 81 points take {every_point:.2f} s in the engine: limit {every_point / cores + OVERHEAD:.2f} s",
    ]
    yield Row(
        "vibsim sweep --omega0 3:7:0.05, process",
        "s",
        limit,
        [sweep_seconds() for _ in range(REPETITIONS)],
        notes,
    )


def engine_seconds(frequency):
    """Time in C [s] of II-B with the motor constant `frequency` [Hz], as a point of a sweep."""
    case = load_case("II-B", {"excitation.Omega0": f"{frequency} Hz"})
    scene = sampled_for_statistics(case.scene())
    with EngineClock() as clock:
        for _ in MeasuredRun(scene, quantities_of(case), scene.t_end / 2).blocks():
            pass
    return clock.seconds


def sweep_seconds():
    with tempfile.TemporaryDirectory() as folder:
        return seconds([VIBSIM, "sweep", "--omega0", "3:7:0.05", "-o", Path(folder) / "sweep.h5"])

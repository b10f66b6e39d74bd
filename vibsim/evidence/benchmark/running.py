"""Run a bench: the truth, then row after row, each kept on file as it comes."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.engine.errors import EngineError
from vibsim.evidence.benchmark.bench_result import DONE, FAILED, SLOWER, BenchResult, BenchRow, write_bench
from vibsim.evidence.benchmark.plan import BenchPlan, SolverFamily
from vibsim.evidence.benchmark.scoring import BenchTruth, compute_truth, origin, score
from vibsim.evidence.peers.solvers import TimeLimit
from vibsim.physics.parts import Scene
from vibsim.results.output_files import check_result_output

Watch = Callable[[str, float], bool]  # given what is done and how far it is [0 to 1]; False stops the bench


def run_bench(
    plan: BenchPlan,
    path: str | Path | None = None,
    truth: BenchTruth | None = None,
    force: bool = False,
    watch: Watch = lambda what, share: True,
) -> BenchResult | None:
    """Run a bench, into a file where `path` is given; None where `watch` stopped it before its truth.

    Parameters
    ----------
    truth : what an earlier bench of the same fingerprint knows; computed when None
    force : replace an existing file

    When `watch` says False the row under way is given up and the bench ends with those before it, its
    attribute `complete` 0. Raises EngineError when the truth cannot be computed, MultiprecisionMissing
    without a library for it, ResultFileError when the file cannot be written.
    """
    target = None if path is None else check_result_output(path, force)
    if truth is None:
        truth = compute_truth(plan, lambda t: watch("truth", t / plan.times[-1]))
    if truth is None:
        return None
    attrs: dict[str, Any] = {**origin(plan), "complete": 0}
    rows: list[BenchRow] = []

    def keep() -> None:
        if target is not None:
            write_bench(target, attrs, plan.case.scene(), truth, rows)

    keep()
    scene, entries = plan.case.scene(), list(plan.rows())
    for i, (family, setting) in enumerate(entries):
        at = f"{family.name}, {setting}", i / len(entries)
        if not watch(*at):
            break
        row = measure(family, setting, scene, truth, plan.limit, lambda at=at: watch(*at))  # type: ignore[misc]
        if not watch(*at):
            break
        rows.append(row)
        keep()
    else:
        attrs["complete"] = 1
        keep()
    return BenchResult({**attrs, **truth.attrs}, truth, rows)


# Run a method at a setting, several times where it is fast, and note what it takes.


ENOUGH = 0.5  # s of runs of which the least is taken
MOST_RUNS = 25


def measure(
    family: SolverFamily,
    setting: str,
    scene: Scene,
    truth: BenchTruth,
    limit: float,
    going_on: Callable[[], bool],
) -> BenchRow:
    """The row of `family` at `setting`: timed, counted and judged by the truth.

    A run is stopped after `limit` seconds, or when going_on() says False. Whatever a method fails with
    becomes the row's problem.
    """
    times = truth.samples["time"]
    clocks: list[tuple[float, float]] = []
    try:
        setup, peer = _timed(family.opener(scene, setting))
        while True:
            clock, attempt = _timed(lambda: peer.run(times, TimeLimit(limit, going_on)))
            clocks.append(clock)
            if attempt.stopped or sum(wall for wall, _ in clocks) > ENOUGH or len(clocks) == MOST_RUNS:
                break
    except (ArithmeticError, ValueError, EngineError) as error:
        return BenchRow(family.name, setting, FAILED, _sentence(error), error=np.full(len(times), np.nan))
    judged = score(attempt, truth, scene)
    return BenchRow(
        family.name,
        setting,
        SLOWER if attempt.stopped else DONE,
        wall_time=min(wall for wall, _ in clocks),
        cpu_time=min(cpu for _, cpu in clocks),
        setup_time=setup[0],
        runs=len(clocks),
        steps=attempt.steps,
        evaluations=-1 if attempt.evaluations is None else attempt.evaluations,
        t_reached=float(attempt.t_reached),
        faithful_time=judged.faithful_time,
        error=judged.error,
        events=judged.events,
    )


def _timed(call: Callable[[], Any]) -> tuple[tuple[float, float], Any]:
    """(wall time, CPU time) [s] of call(), and what it returns."""
    wall, cpu = time.perf_counter(), time.process_time()
    answer = call()
    return (time.perf_counter() - wall, time.process_time() - cpu), answer


def _sentence(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__

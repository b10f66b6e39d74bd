"""Run a method at a setting, several times where it is fast, and note what it takes."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from vibsim.engine.errors import EngineError
from vibsim.evidence.benchmark.families import Family
from vibsim.evidence.benchmark.row import DONE, FAILED, SLOWER, Row
from vibsim.evidence.benchmark.scoring import score
from vibsim.evidence.benchmark.truth import Truth
from vibsim.evidence.peers.time_limit import TimeLimit
from vibsim.physics.parts import Scene

ENOUGH = 0.5  # s of runs of which the least is taken
MOST_RUNS = 25


def measure(
    family: Family, setting: str, scene: Scene, truth: Truth, limit: float, going_on: Callable[[], bool]
) -> Row:
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
        return Row(family.name, setting, FAILED, _sentence(error), error=np.full(len(times), np.nan))
    judged = score(attempt, truth, scene)
    return Row(
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

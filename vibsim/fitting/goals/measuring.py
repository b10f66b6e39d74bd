"""One run of a fit: simulated in whatever thread or process it falls to, and measured as asked."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vibsim.cases import CaseError
from vibsim.engine.errors import EngineError
from vibsim.fitting.goals.statement import Asked
from vibsim.results.recording.recording import MemorySink, Recording
from vibsim.results.result import Result
from vibsim.sweeps.points.point import Point, described_bug
from vibsim.sweeps.statistics.columns import DONE, FAILED

if TYPE_CHECKING:
    from vibsim.cases import Case

Index = tuple[int, int, int]  # number of the candidate, position of the case, of the start
HORIZON = "horizon"
TRUST = -1  # in place of a start: the case's own, with its trust horizon


@dataclass(frozen=True)
class Task:
    """One run: where its outcome belongs, its case, its changes, whether to tell its trust horizon."""

    index: Index
    case: int
    changes: dict[str, str]
    trust: bool = False


@dataclass(frozen=True)
class Work:
    """What all runs have in common: the cases, and what is measured of each."""

    cases: tuple[Case, ...]
    asked: tuple[tuple[Asked, ...], ...]


def measure_all(
    work: Work, tasks: tuple[Task, ...], engine: str, go_on: Callable[[], bool] | None = None
) -> list[Point]:
    """The outcomes of the tasks in their order; those that were done before `go_on` said False.

    Values are by the position of what was asked, as text; a run that fails is a point that says why.
    """
    points = []
    for task in tasks:
        point = _measured(work, task, engine, go_on)
        if point is None:
            break
        points.append(point)
    return points


def _measured(work: Work, task: Task, engine: str, go_on: Callable[[], bool] | None) -> Point | None:
    began, sha256 = time.perf_counter(), ""
    try:
        case = work.cases[task.case].with_values(task.changes)
        sha256 = case.sha256
        result = run(case, engine, go_on, task.trust)
        if result is None:
            return None
        if result.trust_horizon is not None:
            return Point(task.index, DONE, sha256, "", {HORIZON: result.trust_horizon})
        values = measure(result, work.asked[task.case])
    except (CaseError, EngineError) as error:
        return Point(task.index, FAILED, sha256, str(error))
    except Exception as error:  # a bug that shows at one run must not cost all the others
        return Point(task.index, FAILED, sha256, described_bug(error))
    values["wall_time"] = time.perf_counter() - began
    return Point(task.index, DONE, sha256, "", values)


def run(case: Case, engine: str, go_on: Callable[[], bool] | None, trust: bool = False) -> Result | None:
    """The run; None where it was given up."""
    recording = Recording(case, engine, trust)
    sink = MemorySink(recording.tables)
    recording.into(sink, None if go_on is None else lambda t_reached: go_on())
    if not recording.complete:
        return None
    samples, events = sink.tables()
    return Result({**recording.start, **recording.end()}, samples, events, case=case)


def measure(result: Result, asked: tuple[Asked, ...]) -> dict[str, float]:
    """What is asked of a run, by position as text; NaN where the run has no such quantity."""
    return {
        str(i): each.observable.measure(result, each.window_in(result.t_reached), each.argument)
        for i, each in enumerate(asked)
    }

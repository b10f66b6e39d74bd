"""Plan of a fit: cases, free parameters, readings, statements, starts, and how it searches."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import comb
from typing import TYPE_CHECKING, Any

import scipy

from vibsim.cases import CaseError
from vibsim.engine.errors import EngineError
from vibsim.fitting.measures import FitError
from vibsim.fitting.statements import PRINTED, Asked, Candidate, FreeParameter, Statement
from vibsim.results.recording import MemorySink, Recording
from vibsim.results.result import Result
from vibsim.results.store import BESIDE, plain_data, stored
from vibsim.sweeps.axes import Members
from vibsim.sweeps.points import SweepPoint, described_bug
from vibsim.sweeps.quantities import DONE, FAILED

if TYPE_CHECKING:
    from vibsim.cases import Case


QUASI_RANDOM, EVOLUTION = "quasi-random", "evolution"
METHODS = (QUASI_RANDOM, EVOLUTION)
MOST_SETS = 10_000  # of parameters that are changed together
FITTING = 1  # raised when a measure or the search is computed differently: runs of two versions do not mix


@dataclass(frozen=True)
class Search:
    """How a fit searches.

    Attributes
    ----------
    method : QUASI_RANDOM (Sobol points) or EVOLUTION (differential evolution)
    candidates : how many are tried, over all subsets together
    seed : of everything that is drawn
    at_most : free parameters changed at a time; None: all together
    screen : starts that a quasi-random candidate is judged from at first; the best quarter is from all
    confirm : best candidates that are judged again from starts that the search has not seen
    fresh : number of these starts
    """

    method: str = QUASI_RANDOM
    candidates: int = 256
    seed: int = 0
    at_most: int | None = None
    screen: int = 2
    confirm: int = 3
    fresh: int = 24


@dataclass(frozen=True)
class FitPlan:
    """A fit.

    Attributes
    ----------
    cases : that share the changed values; names differ
    free : parameters that the search changes; none: only the readings are judged
    readings : changes of each, dotted key -> text
    statements : what the runs should do
    members : starts of the search, drawn; each case's own start comes before them. None: that alone
    """

    cases: tuple[Case, ...] = field(metadata=BESIDE)
    free: tuple[FreeParameter, ...]
    readings: tuple[dict[str, str], ...]
    statements: tuple[Statement, ...] = field(metadata=stored("statements", list))  # see `settings`
    members: Members | None = field(metadata=stored("starts"))
    search: Search

    @property
    def starts(self) -> int:
        """Starts that the search judges from: the case's own, and the drawn ones."""
        return 1 + (len(self.members) if self.members else 0)

    @property
    def all_starts(self) -> int:
        """With those that only the best candidates are run from."""
        return self.starts + (self.search.fresh if self.members and self.free else 0)

    @property
    def fresh_starts(self) -> range:
        """Positions of the starts that the search does not see."""
        return range(self.starts, self.all_starts)

    @cached_property
    def drawn(self) -> Members | None:
        """All drawn starts: those of the search, then the fresh ones."""
        old = self.members
        return old and replace(old, count=len(old) + self.search.fresh)

    def start(self, position: int) -> dict[str, str]:
        """Changes of a case by a start; the first one has none."""
        return self.drawn.changes(position - 1) if position and self.drawn else {}

    def statements_on(self, case: int) -> list[Statement]:
        """The statements on one case."""
        return [statement for statement in self.statements if statement.case == case]

    @cached_property
    def asked(self) -> tuple[tuple[Asked, ...], ...]:
        """Observables of each case, each once."""
        return tuple(
            tuple(dict.fromkeys(each.asked for each in self.statements_on(case)))
            for case in range(len(self.cases))
        )

    @cached_property
    def work(self) -> Work:
        """Data that workers need besides their tasks."""
        return Work(self.cases, self.asked)

    def task(self, candidate: Candidate, case: int, start: int) -> FitTask:
        """The run of a candidate of one case from one start."""
        return FitTask((candidate.number, case, start), case, {**candidate.changes, **self.start(start)})

    def check(self) -> None:
        """Raises FitError for wishes that do not go together."""
        if not self.statements:
            raise FitError(
                "say what the runs should do: give at least one statement, such as 'captured until the end'; "
                "vibsim fit --list shows all"
            )
        names = [case.name for case in self.cases]
        if len(set(names)) < len(names):
            raise FitError(f"two cases are called {next(n for n in names if names.count(n) > 1)}")
        silent = [name for i, name in enumerate(names) if not self.statements_on(i)]
        if silent:
            raise FitError(f"no statement is on {' and '.join(silent)}; leave it out")
        if not self.free and not self.readings:
            raise FitError("nothing to judge: give free parameters, readings, or both")
        at_most = min(self.search.at_most or 0, len(self.free))
        sets = sum(comb(len(self.free), size) for size in range(1, at_most + 1))
        if sets > MOST_SETS:
            raise FitError(
                f"at most {at_most} of {len(self.free)} parameters changed at a time makes {sets} sets of "
                f"them, of which {MOST_SETS} can be searched: choose fewer, or let all change together"
            )
        self._check_keys()

    def _check_keys(self) -> None:
        keys = [each.key for each in self.free]
        if len(set(keys)) < len(keys):
            raise FitError(f"{next(key for key in keys if keys.count(key) > 1)} is free twice")
        changed = {*keys, *(key for reading in self.readings for key in reading)}
        both = changed.intersection(self.members.keys if self.members else ())
        if both:
            raise FitError(f"{min(both)} is both changed and spread over the starts; choose one")

    @cached_property
    def settings(self) -> dict[str, Any]:
        """Everything but the cases, as plain data for JSON."""
        return {
            **plain_data(self),
            "statements": [f"{self.cases[each.case].name}: {each.text}" for each in self.statements],
            "scipy": scipy.__version__ if self.free else "",  # its Sobol points and evolution are not ours
            "fitting": FITTING,
        }

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of what the numbers depend on."""
        return fingerprint_of(self.cases, self.settings)


def fingerprint_of(cases: Sequence[Case], settings: Mapping[str, Any]) -> str:
    """SHA-256 of cases and settings."""
    text = json.dumps([[case.sha256 for case in cases], settings], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


__all__ = ["EVOLUTION", "METHODS", "PRINTED", "QUASI_RANDOM", "FitPlan", "Search"]


# One run of a fit: simulated in whatever thread or process it falls to, and measured as asked.


Index = tuple[int, int, int]  # number of the candidate, position of the case, of the start
HORIZON = "horizon"
TRUST = -1  # in place of a start: the case's own, with its trust horizon


@dataclass(frozen=True)
class FitTask:
    """One run: where its outcome belongs, its case, its changes, whether to tell its trust horizon."""

    index: Index
    case: int
    changes: dict[str, str]
    trust: bool = False


@dataclass(frozen=True)
class Work:
    """Data common to all runs: the cases, and the observables of each."""

    cases: tuple[Case, ...]
    asked: tuple[tuple[Asked, ...], ...]


def measure_all(
    work: Work, tasks: tuple[FitTask, ...], engine: str, go_on: Callable[[], bool] | None = None
) -> list[SweepPoint]:
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


def _measured(work: Work, task: FitTask, engine: str, go_on: Callable[[], bool] | None) -> SweepPoint | None:
    began, sha256 = time.perf_counter(), ""
    try:
        case = work.cases[task.case].with_values(task.changes)
        sha256 = case.sha256
        result = run(case, engine, go_on, task.trust)
        if result is None:
            return None
        if result.trust_horizon is not None:
            return SweepPoint(task.index, DONE, sha256, "", {HORIZON: result.trust_horizon})
        values = measure(result, work.asked[task.case])
    except (CaseError, EngineError) as error:
        return SweepPoint(task.index, FAILED, sha256, str(error))
    except Exception as error:  # a bug that shows at one run must not cost all the others
        return SweepPoint(task.index, FAILED, sha256, described_bug(error))
    values["wall_time"] = time.perf_counter() - began
    return SweepPoint(task.index, DONE, sha256, "", values)


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
    """Observables of a run, by position as text; NaN where the run has no such quantity."""
    return {
        str(i): each.observable.measure(result, each.window_in(result.t_reached), each.argument)
        for i, each in enumerate(asked)
    }

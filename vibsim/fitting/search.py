"""The search: the printed values, the readings, then candidates over the ranges of the free parameters.

Quasi-random: Sobol points, scrambled. All are judged from a few starts first; the best quarter from all.
Evolution: scipy's differential evolution, begun from Sobol points, every candidate judged from all starts.
The best are judged again, from starts that the search has not seen: what was chosen because it did well
from some starts does less well from others.

Nothing depends on how many workers there are, nor on when they are done.
"""

from __future__ import annotations

import time
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations
from math import ceil
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from vibsim.cases import CaseError
from vibsim.engine.errors import EngineError
from vibsim.fitting.measures import FitInterrupted
from vibsim.fitting.plan import EVOLUTION, HORIZON, TRUST, FitPlan, FitTask, Index, Work
from vibsim.fitting.statements import (
    PRINTED,
    READING,
    SEARCHED,
    Asked,
    Candidate,
    FreeParameter,
    Statement,
    leaving_price,
)
from vibsim.physics.elementary import dot, mean, total
from vibsim.results.recording import MemorySink, Recording
from vibsim.results.result import Result
from vibsim.sweeps.points import SweepPoint, described_bug
from vibsim.sweeps.points import share as share_of
from vibsim.sweeps.quantities import DONE, FAILED
from vibsim.sweeps.workers import AHEAD, RUNNER_PATIENCE, LocalWorkers

if TYPE_CHECKING:
    from vibsim.cases import Case

GOES_ON = 4  # one of so many screened candidates is judged from all starts
FEWEST = 5  # members of a population, the least that scipy takes
PER_PARAMETER = 8  # members of a population for each free parameter

Subset = tuple[FreeParameter, ...]


def search(evaluation: Evaluation) -> None:
    """Make and judge all candidates of the plan. Raises Interrupted."""
    plan = evaluation.plan
    candidates = _fixed_candidates(evaluation)
    ranked = evaluation.judge(candidates, range(plan.starts), "judging the readings")
    for number, subset in enumerate(subsets(plan)):
        explore = _evolution if plan.search.method == EVOLUTION else _quasi_random
        ranked = [*ranked, *explore(evaluation, subset, number)]
    best = best_of(ranked, plan.search.confirm)
    chosen = list({one.number: one for one in [*candidates, *(each.candidate for each in best)]}.values())
    if plan.fresh_starts:
        evaluation.judge(chosen, plan.fresh_starts, "judging the best again")
    evaluation.tell_horizons(chosen, "telling trust horizons")


def candidates_within(plan: FitPlan, runs: Runs) -> list[Candidate]:
    """The candidates that a search has made which came as far as these runs: it goes that way once more."""
    evaluation = Evaluation(plan, dict(runs), [])
    with suppress(FitInterrupted):
        search(evaluation)
    return evaluation.candidates


def best_of(judged: Sequence[Judgement], count: int) -> list[Judgement]:
    """The cheapest, each set of changes once."""
    ranked = sorted(judged, key=lambda each: (each.price, each.candidate.number))
    different = {tuple(each.candidate.changes.items()): each for each in reversed(ranked)}
    return sorted(different.values(), key=lambda each: (each.price, each.candidate.number))[:count]


def subsets(plan: FitPlan) -> list[Subset]:
    """The sets of parameters that are changed together: all of them, or each of at most so many."""
    if not plan.free or not plan.search.candidates:
        return []
    if plan.search.at_most is None:
        return [plan.free]
    sizes = range(1, min(plan.search.at_most, len(plan.free)) + 1)
    return [subset for size in sizes for subset in combinations(plan.free, size)]


def _fixed_candidates(evaluation: Evaluation) -> list[Candidate]:
    """The printed values and the readings."""
    plan = evaluation.plan
    candidates = [evaluation.make(PRINTED, {}, 0.0)]
    for changes in plan.readings:
        price = leaving_price(list(plan.cases), changes, plan.free)
        candidates.append(evaluation.make(READING, changes, price))
    return candidates


def _candidate(evaluation: Evaluation, subset: Subset, place: Sequence[float]) -> Candidate:
    """The candidate at a place of the unit cube of a subset."""
    values = [each.value(float(part)) for each, part in zip(subset, place, strict=True)]
    changes = {each.key: each.text(value) for each, value in zip(subset, values, strict=True)}
    leaving = sum(each.price(value) for each, value in zip(subset, values, strict=True))
    return evaluation.make(SEARCHED, changes, leaving)


def _budget(plan: FitPlan) -> int:
    """Candidates for each subset."""
    return max(1, plan.search.candidates // len(subsets(plan)))


def _quasi_random(evaluation: Evaluation, subset: Subset, number: int) -> list[Judgement]:
    plan = evaluation.plan
    places = sobol(len(subset), _budget(plan), [plan.search.seed, number])
    candidates = [_candidate(evaluation, subset, place) for place in places]
    first = range(min(plan.search.screen, plan.starts))
    screened = evaluation.judge(candidates, first, "screening")
    if len(first) == plan.starts:
        return screened
    ranked = sorted(screened, key=lambda each: (each.price, each.candidate.number))
    going_on = [each.candidate for each in ranked[: ceil(len(ranked) / GOES_ON)]]
    return evaluation.judge(going_on, range(plan.starts), "judging from all starts")


def _evolution(evaluation: Evaluation, subset: Subset, number: int) -> list[Judgement]:
    from scipy.optimize import differential_evolution

    plan, judged = evaluation.plan, list[Judgement]()
    budget = _budget(plan)
    size = max(FEWEST, min(PER_PARAMETER * len(subset), budget // 4))

    def prices(places: np.ndarray) -> np.ndarray:
        candidates = [_candidate(evaluation, subset, place) for place in places.T]
        judgements = evaluation.judge(candidates, range(plan.starts), "evolving")
        judged.extend(judgements)
        return np.array([each.price for each in judgements])

    differential_evolution(
        prices,
        [(0.0, 1.0)] * len(subset),
        init=sobol(len(subset), size, [plan.search.seed, number]),
        maxiter=max(1, budget // size - 1),
        tol=0.0,
        atol=-1.0,  # a population whose members are all as bad as each other has not arrived
        polish=False,
        vectorized=True,
        updating="deferred",
        seed=np.random.default_rng([plan.search.seed, number, 1]),
    )
    return judged


def sobol(dimension: int, count: int, seed: Sequence[int]) -> np.ndarray:
    """Scrambled Sobol points in the unit cube (count, dimension)."""
    from scipy.stats import qmc

    engine = qmc.Sobol(dimension, scramble=True, seed=np.random.default_rng(list(seed)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # balanced or not: each point stands for itself
        return np.asarray(engine.random(count))


# Runs that the search needs: those that are not there yet are handed to workers, and kept as they come.


Runs = dict[Index, SweepPoint]
Watch = Callable[[str, int, int], bool]  # what is done, how many runs of it, of how many; False to stop


class Evaluation:
    """Knowledge of the candidates of a plan, and the means to know more."""

    def __init__(
        self,
        plan: FitPlan,
        runs: Runs,
        candidates: list[Candidate],
        workers: LocalWorkers | None = None,
        keep: Callable[[list[SweepPoint]], None] | None = None,
        watch: Watch | None = None,
    ):
        """workers : None where nothing is to be run; what is missing is then Interrupted
        keep : puts runs that have come among `runs`
        """
        self.plan, self.runs, self.candidates, self._workers = plan, runs, candidates, workers
        self._keep = keep or (lambda points: None)
        self._watch = watch or (lambda *_: True)

    def make(self, origin: str, changes: dict[str, str], leaving: float) -> Candidate:
        """A new candidate, the next in number."""
        candidate = Candidate(len(self.candidates), origin, changes, leaving)
        self.candidates.append(candidate)
        return candidate

    def judge(self, candidates: Sequence[Candidate], starts: Sequence[int], step: str) -> list[Judgement]:
        """The candidates judged from these starts, run as far as they are not yet. Raises Interrupted."""
        self._complete(
            [
                self.plan.task(one, case, start)
                for one in candidates
                for start in starts
                for case in self._cases
            ],
            step,
        )
        return [judge(self.plan, one, self.runs, starts) for one in candidates]

    def tell_horizons(self, candidates: Iterable[Candidate], step: str) -> None:
        """Run candidates from the cases' own start with their trust horizons."""
        self._complete(
            [
                FitTask((one.number, case, TRUST), case, one.changes, True)
                for one in candidates
                for case in self._cases
            ],
            step,
        )

    @property
    def _cases(self) -> range:
        return range(len(self.plan.cases))

    def _complete(self, tasks: Sequence[FitTask], step: str) -> None:
        waiting = deque(task for task in tasks if task.index not in self.runs)
        if self._workers is None:
            if waiting:
                raise FitInterrupted
            return
        active: dict[Future[list[SweepPoint]], Index] = {}
        while True:
            while waiting and len(active) < AHEAD * self._workers.count:
                task = waiting.popleft()
                active[self._workers.submit((task,))] = task.index
            if not self._watch(step, len(tasks) - len(waiting) - len(active), len(tasks)):
                self._give_up(self._workers, active)
                raise FitInterrupted
            if not active:
                return
            for future in wait(active, RUNNER_PATIENCE, FIRST_COMPLETED).done:
                del active[future]
                self._keep(self._workers.result(future))

    def _give_up(self, workers: LocalWorkers, active: Iterable[Future[list[SweepPoint]]]) -> None:
        workers.stop()
        running = [future for future in active if not future.cancel()]
        for future in wait(running).done:
            self._keep(workers.result(future))


# What a candidate comes to: from which share of the starts each statement holds, and its penalty (`price`).
#
# The penalty is the mean shortfall of the statements over the starts, each statement by its weight, and what
# leaving the printed values costs.


@dataclass(frozen=True)
class StatementResult:
    """Number of starts from which one statement holds.

    Attributes
    ----------
    count : starts from which it holds; of : from how many it was judged
    share, low, high : the share, with its interval of 95 %
    shortfall : mean, from 0 (fulfilled from every start) to 1
    median : of the values that were measured; NaN without any
    """

    statement: Statement
    count: int
    of: int
    share: float
    low: float
    high: float
    shortfall: float
    median: float

    @property
    def holds(self) -> bool:
        """Whether it holds from the share of the starts that it asks for."""
        return self.share >= self.statement.share


@dataclass(frozen=True)
class Judgement:
    """A candidate judged from some starts; `failed` of its runs failed, and count as far off."""

    candidate: Candidate
    starts: tuple[int, ...]
    results: tuple[StatementResult, ...]
    price: float
    failed: int

    @property
    def explained(self) -> int:
        """Number of statements that hold."""
        return sum(each.holds for each in self.results)


def judge(
    plan: FitPlan, candidate: Candidate, runs: Mapping[Index, SweepPoint], starts: Sequence[int]
) -> Judgement:
    """The candidate judged from these starts, all of which were run."""
    results = tuple(
        _result_of(each, values_of(plan, each, candidate.number, runs, starts)) for each in plan.statements
    )
    weights = np.array([each.weight for each in plan.statements])
    missed = float(dot(weights, np.array([each.shortfall for each in results])) / total(weights))
    failed = sum(
        not runs[candidate.number, case, start].done for case in range(len(plan.cases)) for start in starts
    )
    return Judgement(candidate, tuple(starts), results, missed + candidate.leaving, failed)


def values_of(
    plan: FitPlan, statement: Statement, number: int, runs: Mapping[Index, SweepPoint], starts: Sequence[int]
) -> np.ndarray:
    """Values measured for a statement from each start (n); NaN where the run failed or does not have it."""
    position = str(plan.asked[statement.case].index(statement.asked))
    return np.array([runs[number, statement.case, start].values.get(position, np.nan) for start in starts])


def _result_of(statement: Statement, values: np.ndarray) -> StatementResult:
    holds = np.array([statement.bounds.contain(value) for value in values])
    share = share_of(holds, np.ones(len(values), bool), 0)
    known = sorted(values[~np.isnan(values)].tolist())
    return StatementResult(
        statement,
        int(np.count_nonzero(holds)),
        len(values),
        float(share.estimate),
        float(share.low),
        float(share.high),
        float(mean(np.array([statement.shortfall(value) for value in values]))),
        median(known) if known else np.nan,
    )


def measure_all(
    work: Work, tasks: tuple[FitTask, ...], go_on: Callable[[], bool] | None = None
) -> list[SweepPoint]:
    """The outcomes of the tasks in their order; those that were done before `go_on` said False.

    Values are by the position of what was asked, as text; a run that fails is a point that says why.
    """
    points = []
    for task in tasks:
        point = _measured(work, task, go_on)
        if point is None:
            break
        points.append(point)
    return points


def _measured(work: Work, task: FitTask, go_on: Callable[[], bool] | None) -> SweepPoint | None:
    began, sha256 = time.perf_counter(), ""
    try:
        case = work.cases[task.case].with_values(task.changes)
        sha256 = case.sha256
        result = run(case, go_on, task.trust)
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


def run(case: Case, go_on: Callable[[], bool] | None, trust: bool = False) -> Result | None:
    """The run; None where it was given up."""
    recording = Recording(case, trust)
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

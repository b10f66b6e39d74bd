"""What a candidate comes to: from which share of the starts each statement holds, and its price.

The price is the mean shortfall of the statements over the starts, each statement by its weight, and what
leaving the printed values costs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from vibsim.fitting.goals.measuring import Index
from vibsim.fitting.goals.plan import FitPlan
from vibsim.fitting.goals.reading import Candidate
from vibsim.fitting.goals.statement import Statement
from vibsim.physics.arithmetic.sums import dot, mean, total
from vibsim.sweeps.ensemble import share as share_of
from vibsim.sweeps.points.point import Point


@dataclass(frozen=True)
class StatementResult:
    """How many of the starts one statement holds from.

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
    plan: FitPlan, candidate: Candidate, runs: Mapping[Index, Point], starts: Sequence[int]
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
    plan: FitPlan, statement: Statement, number: int, runs: Mapping[Index, Point], starts: Sequence[int]
) -> np.ndarray:
    """What was measured for a statement from each start (n); NaN where the run failed or does not have it."""
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

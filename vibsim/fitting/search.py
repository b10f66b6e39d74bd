"""The search: the printed values, the readings, then candidates over the ranges of the free parameters.

Quasi-random: Sobol points, scrambled. All are judged from a few starts first; the best quarter from all.
Evolution: scipy's differential evolution, begun from Sobol points, every candidate judged from all starts.
The best are judged again, from starts that the search has not seen: what was chosen because it did well
from some starts does less well from others.

Nothing depends on how many workers there are, nor on when they are done.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from contextlib import suppress
from itertools import combinations
from math import ceil

import numpy as np

from vibsim.fitting.errors import Interrupted
from vibsim.fitting.evaluation import Evaluation
from vibsim.fitting.goals.free_parameter import FreeParameter
from vibsim.fitting.goals.plan import EVOLUTION, FitPlan
from vibsim.fitting.goals.reading import PRINTED, READING, SEARCHED, Candidate, leaving_price
from vibsim.fitting.judgement import Judgement
from vibsim.fitting.store.run_store import Runs, RunStore

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
    store = RunStore()
    store.runs = dict(runs)
    evaluation = Evaluation(plan, store, None)
    with suppress(Interrupted):
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

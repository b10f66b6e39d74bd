"""A fit as users meet it: candidates ranked by price, what became of each statement, trust horizons."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases import Case
from vibsim.files.journal import Waiting
from vibsim.files.output_file import check_result_output
from vibsim.fitting.goals.measuring import HORIZON, TRUST, Index
from vibsim.fitting.goals.plan import FitPlan
from vibsim.fitting.goals.reading import Candidate
from vibsim.fitting.goals.statement import Statement
from vibsim.fitting.judgement import Judgement, judge, values_of
from vibsim.fitting.store.fit_file import file_values, write_fit
from vibsim.fitting.store.fit_structure import CANDIDATE, datasets_of
from vibsim.fitting.store.stored_fit import read_fit
from vibsim.labelled.arrays import Arrays
from vibsim.labelled.labelled import Labelled
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.store.journal import point_from


class FitResult(Labelled):
    """A fit, in memory or from a file.

    `fit.ranking` are the candidates that were judged from all starts, the cheapest first, those that were
    judged again from fresh starts before the others; `fit.best` is the first. `fit.attrs` says where it
    comes from.

    >>> import vibsim
    >>> statement = "impacts per cycle between 0.9 and 1.1"
    >>> result = vibsim.fit(
    ...     "gallery/impact-oscillator-coco",
    ...     {},
    ...     [statement],
    ...     readings=["wall.e=0.7"],
    ...     confirm=0,
    ...     ensemble=0,
    ...     jobs=1,
    ... )
    >>> [each.candidate.changes for each in result.ranking], result.best.price, result.complete
    ([{}, {'stops.wall.e': '0.7'}], 0.0, True)
    """

    def __init__(
        self,
        attrs: Mapping[str, Any],
        plan: FitPlan,
        candidates: list[Candidate],
        runs: Mapping[Index, Point],
    ):
        self.attrs, self.plan, self.candidates, self.runs = dict(attrs), plan, candidates, runs

    @property
    def complete(self) -> bool:
        """Whether the search reached its end."""
        return bool(self.attrs["complete"])

    @property
    def statements(self) -> tuple[Statement, ...]:
        """The statements, in the order given."""
        return self.plan.statements

    @cached_property
    def ranking(self) -> list[Judgement]:
        """The candidates judged from all starts; of several with the same changes the first."""
        judged = [self.judged(one) for one in self.candidates if self._is_run(one, range(self.plan.starts))]
        ranked = sorted(
            judged, key=lambda each: (not self.is_confirmed(each), each.price, each.candidate.number)
        )
        different: dict[tuple[tuple[str, str], ...], Judgement] = {}
        for each in ranked:
            different.setdefault(tuple(each.candidate.changes.items()), each)
        return list(different.values())

    @property
    def best(self) -> Judgement:
        """The first of the ranking. Raises IndexError where none was judged yet."""
        return self.ranking[0]

    def judged(self, candidate: Candidate) -> Judgement:
        """A candidate judged from the fresh starts if it was run from them, else from those of the search."""
        fresh = self.plan.fresh_starts
        starts = fresh if fresh and self._is_run(candidate, fresh) else range(self.plan.starts)
        return judge(self.plan, candidate, self.runs, starts)

    def is_confirmed(self, judged: Judgement) -> bool:
        """Whether it was judged from other starts than those by which it was chosen, or was not chosen."""
        fresh = self.plan.fresh_starts
        return not self.plan.free or not fresh or judged.starts == tuple(fresh)

    def _is_run(self, candidate: Candidate, starts: range) -> bool:
        return all(
            (candidate.number, case, start) in self.runs
            for case in range(len(self.plan.cases))
            for start in starts
        )

    def horizon(self, candidate: Candidate, case: int) -> float:
        """Trust horizon [s] of a candidate's run from the case's own start; NaN where it was not told."""
        point = self.runs.get((candidate.number, case, TRUST))
        return np.nan if point is None else point.values.get(HORIZON, np.nan)

    def own_value(self, candidate: Candidate, statement: Statement) -> float:
        """What was measured for a statement from the case's own start; NaN where it has it not."""
        return float(values_of(self.plan, statement, candidate.number, self.runs, [0])[0])

    def within_horizon(self, candidate: Candidate, statement: Statement) -> bool | None:
        """Whether what decides a statement, from the case's own start, lies within the trust horizon."""
        horizon = self.horizon(candidate, statement.case)
        if np.isnan(horizon):
            return None
        t_end = self.plan.cases[statement.case].number("run.t_end")
        return statement.decided_at(self.own_value(candidate, statement), t_end) <= horizon

    def values(self, statement: Statement, candidate: Candidate) -> np.ndarray:
        """What was measured for a statement from every start (n), fresh ones last; NaN: not run or none."""
        position = str(self.plan.asked[statement.case].index(statement.asked))
        points = [
            self.runs.get((candidate.number, statement.case, start)) for start in range(self.plan.all_starts)
        ]
        return np.array([np.nan if point is None else point.values.get(position, np.nan) for point in points])

    def case_of(self, candidate: Candidate, case: int = 0) -> Case:
        """One of the cases with the candidate's values."""
        return self.plan.cases[case].with_values(candidate.changes)

    @property
    def case(self) -> Case:
        """The first case, as given."""
        return self.plan.cases[0]

    def save(self, path: str | Path, force: bool = False) -> Path:
        """Write the fit to an HDF5 file; its absolute path. Raises ResultFileError."""
        target = check_result_output(path, force)
        write_fit(target, self)
        return target

    def arrays(self) -> Arrays:
        """What its file holds: a row per candidate; by case, statement and start what was measured."""
        shown = (*[f"value_{each.name}" for each in self.plan.free][:1], "price", "share")
        return Arrays.of_values(datasets_of(self.plan), file_values(self), (CANDIDATE,), self.attrs, shown)

    def heading(self) -> str:
        """Cases, how many candidates and runs, and the best."""
        names = ", ".join(case.name for case in self.plan.cases)
        best = f"; best {self.best.candidate}, price {self.best.price:.3f}" if self.ranking else ""
        return f"{names}: {len(self.candidates)} candidates, {len(self.runs)} runs{best}"

    def lines(self) -> list[tuple[str, str]]:
        """The statements, the ranges of the free parameters, and whether the search reached its end."""
        statements = [("statement", each.text) for each in self.statements]
        free = ", ".join(f"{each.key}" for each in self.plan.free) or "none"
        return [*statements, ("free", free), ("search", "at its end" if self.complete else "interrupted")]


def open_fit(path: str | Path) -> FitResult:
    """The FitResult in an HDF5 file, with the runs that wait in its journal.

    Raises ResultFileError where it holds none.
    """
    waiting = Waiting(path)
    attrs, plan, candidates, points = read_fit(Path(path))
    more = list(map(point_from, waiting.records(attrs["fit_sha256"])))
    runs: dict[Index, Point] = {point.index: point for point in [*points, *more]}  # type: ignore[misc]
    if more and plan.fingerprint == attrs["fit_sha256"]:
        from vibsim.fitting.search import candidates_within

        return FitResult({**attrs, "runs": len(runs)}, plan, candidates_within(plan, runs), runs)
    return FitResult(attrs, plan, candidates, {point.index: point for point in points})  # type: ignore[misc]

"""A fit as users meet it: the call, candidates ranked by penalty, what became of each statement, horizons."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from math import isnan
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases import Case
from vibsim.cases.case import CaseLike, by_key, load_case, texts
from vibsim.cases.problems import counted
from vibsim.engine.blocks_ahead import available_cores
from vibsim.fitting.measures import FitError, FitInterrupted
from vibsim.fitting.plan import (
    CANDIDATE,
    HORIZON,
    TRUST,
    FitPlan,
    Index,
    Search,
    datasets_of,
    file_values,
    make_plan,
    origin,
    read_fit,
    write_fit,
)
from vibsim.fitting.search import (
    Evaluation,
    Judgement,
    Runs,
    StatementResult,
    Watch,
    candidates_within,
    judge,
    measure_all,
    search,
    values_of,
)
from vibsim.fitting.statements import Candidate, Statement
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.labelled import Arrays, Labelled
from vibsim.results.output_files import check_result_output
from vibsim.results.store import Store, Waiting
from vibsim.sweeps.points import SweepPoint
from vibsim.sweeps.workers import LocalWorkers


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
        runs: Mapping[Index, SweepPoint],
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
        """Value measured for a statement from the case's own start; NaN where it has it not."""
        return float(values_of(self.plan, statement, candidate.number, self.runs, [0])[0])

    def within_horizon(self, candidate: Candidate, statement: Statement) -> bool | None:
        """Whether what decides a statement, from the case's own start, lies within the trust horizon."""
        horizon = self.horizon(candidate, statement.case)
        if np.isnan(horizon):
            return None
        t_end = self.plan.cases[statement.case].number("run.t_end")
        return statement.decided_at(self.own_value(candidate, statement), t_end) <= horizon

    def values(self, statement: Statement, candidate: Candidate) -> np.ndarray:
        """Values measured for a statement from every start (n), fresh ones last; NaN: not run or none."""
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
        """Arrays of its file: a row per candidate; by case, statement and start what was measured."""
        shown = (*[f"value_{each.name}" for each in self.plan.free][:1], "price", "share")
        return Arrays.of_values(datasets_of(self.plan), file_values(self), (CANDIDATE,), self.attrs, shown)

    def heading(self) -> str:
        """Cases, how many candidates and runs, and the best."""
        names = ", ".join(case.name for case in self.plan.cases)
        best = f"; best {self.best.candidate}, penalty {self.best.price:.3f}" if self.ranking else ""
        return (
            f"{names}: {counted(len(self.candidates), 'candidate')}, {counted(len(self.runs), 'run')}{best}"
        )

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
    more = waiting.records(attrs["fit_sha256"], SweepPoint)
    runs: dict[Index, SweepPoint] = {point.index: point for point in [*points, *more]}  # type: ignore[misc]
    if more and plan.fingerprint == attrs["fit_sha256"]:
        return FitResult({**attrs, "runs": len(runs)}, plan, candidates_within(plan, runs), runs)
    return FitResult(attrs, plan, candidates, {point.index: point for point in points})  # type: ignore[misc]


# What a fit came to: labelled lines and a table for people, plain data for programs.


Lines = list[tuple[str, str]]
Table = tuple[tuple[str, ...], list[tuple[str, ...]]]  # heads, rows

SHOWN = 10  # rows of a table


def describe(path: str | Path) -> tuple[Lines, dict[str, Any]]:
    """Lines and facts of a fit file. Raises ResultFileError where it holds none."""
    fit = open_fit(path)
    return fit_lines(fit), facts(fit)


def fit_lines(fit: FitResult) -> Lines:
    """Summary of a fit: what was sought, among which candidates, from which starts."""
    plan = fit.plan
    lines = [("case", f"{case.name}  {case.title}") for case in plan.cases]
    lines += [("free", str(each)) for each in plan.free]
    lines += [(f"statement {i}", _statement_line(fit, i - 1)) for i in range(1, len(plan.statements) + 1)]
    lines.append(("starts", starts_text(fit)))
    lines.append(("search", search_text(fit)))
    if fit.ranking:
        lines.append(("best", best_text(fit)))
        lines += [("horizon", text) for text in horizon_texts(fit, fit.best)]
    if not fit.complete:
        lines.append(("incomplete", "the search did not reach its end; the same command resumes it"))
    return lines


def _statement_line(fit: FitResult, position: int) -> str:
    statement = fit.statements[position]
    name = f"{fit.plan.cases[statement.case].name}: " if len(fit.plan.cases) > 1 else ""
    return f"{name}{statement.text}"


def starts_text(fit: FitResult) -> str:
    """Starts from which runs are judged, in words."""
    members = fit.plan.members
    if members is None:
        return "that of the case alone"
    fresh = f"; the best from {len(fit.plan.fresh_starts)} more" if fit.plan.fresh_starts else ""
    return f"that of the case and {members}{fresh}"


def search_text(fit: FitResult) -> str:
    """Method of the search, and how much of it was done."""
    search, searched = fit.plan.search, sum(one.origin == "search" for one in fit.candidates)
    readings = counted(len(fit.plan.readings), "reading")
    how = [f"{counted(searched, 'candidate')}, {search.method}, seed {search.seed}"] if fit.plan.free else []
    if fit.plan.free and search.at_most:
        how.append(f"at most {search.at_most} changed at a time")
    how += [readings] if fit.plan.readings else []
    return f"{'; '.join(how)}; {counted(len(fit.runs), 'run')}"


def best_text(fit: FitResult) -> str:
    """The first of the ranking in a sentence."""
    best = fit.best
    return (
        f"{best.candidate}: {best.explained} of {len(best.results)} statements hold, penalty {best.price:.3f}"
    )


def horizon_texts(fit: FitResult, judged: Judgement) -> list[str]:
    """From the cases' own start: until when each is right, and what is decided by then."""
    texts = []
    for position, case in enumerate(fit.plan.cases):
        horizon = fit.horizon(judged.candidate, position)
        if isnan(horizon):
            continue
        sides: dict[bool | None, list[str]] = {True: [], False: []}
        for i, statement in enumerate(fit.statements, start=1):
            if statement.case == position:
                sides[fit.within_horizon(judged.candidate, statement)].append(str(i))
        words = [
            f"{name} {', '.join(numbers)}"
            for name, numbers in (
                ("decided within it", sides[True]),
                ("beyond it, so by the starts", sides[False]),
            )
            if numbers
        ]
        texts.append(f"{case.name} right until {horizon:.4g} s: statement {'; '.join(words)}")
    return texts


def ranking_table(fit: FitResult, rows: int = SHOWN) -> Table:
    """The first rows of the ranking, and those of the printed values and the readings."""
    heads = ("", "changed", *(f"{i}" for i in range(1, len(fit.statements) + 1)), "hold", "penalty")
    shown = [
        (rank, each)
        for rank, each in enumerate(fit.ranking, start=1)
        if rank <= rows or each.candidate.origin != "search"
    ]
    return heads, [_row(fit, rank, each) for rank, each in shown]


def _row(fit: FitResult, rank: int, judged: Judgement) -> tuple[str, ...]:
    mark = "" if fit.is_confirmed(judged) else "*"
    shares = (f"{each.count}/{each.of}{'' if each.holds else ' -'}" for each in judged.results)
    return (f"{rank}{mark}", str(judged.candidate), *shares, str(judged.explained), f"{judged.price:.3f}")


def facts(fit: FitResult) -> dict[str, Any]:
    """The fit as plain data."""
    left_out = ("case_yaml", "case_resolved_json", "cases_resolved_json", "fit_settings_json")
    attrs = {name: value for name, value in fit.attrs.items() if name not in left_out}
    return {
        **attrs,
        "fit": json.loads(fit.attrs["fit_settings_json"]),
        "ranking": [judged_facts(fit, each) for each in fit.ranking],
    }


def judged_facts(fit: FitResult, judged: Judgement) -> dict[str, Any]:
    """One candidate of the ranking as plain data."""
    one = judged.candidate
    horizons = {case.name: fit.horizon(one, i) for i, case in enumerate(fit.plan.cases)}
    return {
        "number": one.number,
        "origin": one.origin,
        "changes": one.changes,
        "price": judged.price,
        "leaving": one.leaving,
        "confirmed": fit.is_confirmed(judged),
        "explained": judged.explained,
        "failed_runs": judged.failed,
        "trust_horizon_s": {name: _known(value) for name, value in horizons.items()},
        "statements": [_statement_facts(fit, judged, each) for each in judged.results],
    }


def _statement_facts(fit: FitResult, judged: Judgement, result: StatementResult) -> dict[str, Any]:
    return {
        "case": fit.plan.cases[result.statement.case].name,
        "text": result.statement.text,
        "holds": result.holds,
        "count": result.count,
        "of": result.of,
        "low": result.low,
        "high": result.high,
        "shortfall": result.shortfall,
        "median": _known(result.median),
        "from_own_start": _known(fit.own_value(judged.candidate, result.statement)),
        "within_trust_horizon": fit.within_horizon(judged.candidate, result.statement),
    }


def _known(value: float) -> float | None:
    return None if isnan(value) else value


# The runs of a fit: in memory, and on file as they come, so that none is computed twice.


class FitStore(Store[SweepPoint]):
    """The runs of one fit, by index; `candidates` are those that the search has made."""

    what, record = "fit", SweepPoint
    patient = True

    def make_memory(self) -> None:
        self.runs: Runs = {}
        self.candidates: list[Candidate] = []

    def origin(self) -> dict[str, Any]:
        return origin(self.plan)

    def take(self, record: SweepPoint) -> None:
        self.runs[record.index] = record  # type: ignore[index]

    def take_stored(self) -> dict[str, Any]:
        attrs, there, _, points = read_fit(Path(self.shown))
        if attrs["fit_sha256"] != self.plan.fingerprint:
            others = " and ".join(_differences(self.plan, there.cases, attrs["fit_settings_json"]))
            raise ResultFileError(
                f"{self.shown}: holds another fit, of other {others}; kept (force=True replaces it)"
            )
        for point in points:
            self.take(point)
        return attrs

    def write(self, path: Path) -> None:
        write_fit(path, self.result)

    @property
    def result(self) -> FitResult:
        """The fit as far as it is computed."""
        attrs = {**self.attrs, "complete": int(self.complete), "runs": len(self.runs)}
        return FitResult(attrs, self.plan, self.candidates, self.runs)


NAMES = {"free": "free parameters", "starts": "starts", "search": "search settings", "scipy": "scipy",
         "fitting": "version of vibsim"}  # fmt: skip


def _differences(plan: FitPlan, cases: Sequence[Case], stored: str) -> list[str]:
    """Differences between a plan and the fit on file, in words."""
    ours, theirs = json.loads(json.dumps(plan.settings)), json.loads(stored)
    named = [NAMES.get(key, key) for key in ours if ours[key] != theirs.get(key)]
    same_cases = [case.sha256 for case in plan.cases] == [case.sha256 for case in cases]
    return named if same_cases else ["cases", *named]


# The call that runs a fit.


def fit(
    cases: CaseLike | Sequence[CaseLike],
    free: Mapping[str, str] | None = None,
    statements: Iterable[str] = (),
    *,
    readings: Iterable[str] = (),
    leave: Mapping[str, float] | None = None,
    ensemble: int = 8,
    spread: Mapping[str, str] | None = None,
    method: str = "quasi-random",
    candidates: int = 256,
    at_most: int | None = None,
    screen: int = 2,
    confirm: int = 3,
    fresh: int = 24,
    seed: int = 0,
    jobs: int | None = None,
    out: str | PathLike[str] | None = None,
    force: bool = False,
) -> FitResult:
    """Search for values under which the runs of one or more cases do what statements say of them.

    Parameters
    ----------
    cases : one case or several, each as of `load_case`; a value that is changed is changed in all of them
    free : key -> range, e.g. {"J": "0.5:20 g m^2", "c": "log 0.001:0.05"}; none: only the readings are judged
    statements : one or several, such as "captured until the end" or "II-C: settles between 6.1 and 6.3 Hz",
        see docs/fit.md
    readings : changes to judge beside what is found, e.g. "J=0.006 kg m^2, c=0.005 N s/m"
    leave : key -> penalty for leaving the printed value by a factor of 10; 0.1 by default
    ensemble : starts that are drawn, besides each case's own; 0: none
    spread : key -> what varies over them, as of `vibsim.sweep`; with a motor by default the rotor angle
    method : "quasi-random" or "evolution"
    candidates : how many are tried
    at_most : parameters changed at a time; by default all together
    screen : starts that quasi-random candidates are judged from first; the best quarter is from all
    confirm, fresh : so many of the best are judged again, from so many starts that the search has not seen
    seed : of the search and of the starts
    jobs : runs computed at a time; by default the available cores. The result is the same bit for bit
    out : HDF5 file; one that holds a part of this very fit is completed, any other is an error unless `force`

    Raises CaseError, FitError and ResultFileError. A run that fails counts as one that fulfils no statement.

    >>> import vibsim
    >>> free, statement = {"drive.A": "0.05:0.5 N"}, "impacts per cycle between 0.9 and 1.1"
    >>> result = vibsim.fit(
    ...     "gallery/impact-oscillator-coco", free, [statement], candidates=4, confirm=0, ensemble=0, jobs=1
    ... )
    >>> len(result.candidates), result.best.price <= min(each.price for each in result.ranking)
    (5, True)
    """
    listed = [cases] if isinstance(cases, (Case, str, PathLike, Mapping)) else list(cases)
    read = [load_case(case) for case in listed]
    settings = Search(method, candidates, seed, at_most, screen, confirm, fresh)
    free, leave = by_key("free", free, "{'J': '0.5:20 g m^2'}"), by_key("leave", leave, "{'J': 0.05}")
    spread = by_key("spread", spread, "{'x1': '1 mm'}")
    statements, readings = texts("statements", statements), texts("readings", readings)
    for key, text in free.items():
        if not isinstance(text, str):
            raise TypeError(f"free {key}: a range is a text such as '0.5:20 g m^2', got {text!r:.60}")
    plan = make_plan(read, free, statements, readings, leave, ensemble, spread, settings)
    result, _ = run_fit(plan, out, jobs, force)
    return result


def run_fit(
    plan: FitPlan,
    out: str | PathLike[str] | None = None,
    jobs: int | None = None,
    force: bool = False,
    watch: Watch | None = None,
) -> tuple[FitResult, bool]:
    """Run a fit, or complete it; the result, and whether the search reached its end."""
    if jobs is not None and jobs < 1:
        raise FitError(f"jobs must be at least 1, got {jobs}")
    store = FitStore(plan, None if out is None else str(out), force)
    for note in store.notes:
        warnings.warn(note, stacklevel=2)
    with store, LocalWorkers(plan.work, jobs or available_cores(), measure_all) as workers:
        evaluation = Evaluation(plan, store.runs, store.candidates, workers, store.add, watch)
        with suppress(FitInterrupted):
            search(evaluation)
            store.complete = True
    return store.result, store.complete

"""Plan of a fit: cases, free parameters, readings, statements, starts, search; and its HDF5 file.

The file holds what was measured over candidates, statements and starts, and what came of it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import comb
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy

from vibsim.cases import Case
from vibsim.cases.quantities import UNITS, exact_number
from vibsim.fitting.measures import FitError
from vibsim.fitting.statements import (
    PRINTED,
    Asked,
    Candidate,
    FreeParameter,
    Statement,
    parse_statement,
    read_free,
    read_reading,
)
from vibsim.results.file_contents import (
    ENGINE,
    ENGINE_NAME,
    PROVENANCE,
    TEXT,
    WHOLE,
    Attribute,
    Column,
    Dataset,
    provenance,
)
from vibsim.results.hdf5_reading import (
    opened,
    read_attributes,
    read_datasets,
    stored_case,
    understood,
)
from vibsim.results.hdf5_writing import write_hdf5
from vibsim.results.store import BESIDE, from_plain, plain_data, stored
from vibsim.sweeps.axes import Members, read_members, rotor_angles
from vibsim.sweeps.points import SweepPoint
from vibsim.sweeps.quantities import DONE, MISSING, STATUS_FLAGS
from vibsim.sweeps.sweep_plan import PlanError
from vibsim.sweeps.sweeping import read_ensemble

if TYPE_CHECKING:
    from vibsim.fitting.fit_result import FitResult


QUASI_RANDOM, EVOLUTION = "quasi-random", "evolution"
METHODS = (QUASI_RANDOM, EVOLUTION)
MOST_SETS = 10_000  # of parameters that are changed together
FITTING = 1  # raised when a measure or the search is computed differently: runs of two versions do not mix


@dataclass(frozen=True)
class Search:
    """Settings of the search of a fit.

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


# The plan that a call or a command line describes.


def make_plan(
    cases: list[Case],
    free: Mapping[str, str],
    statements: Iterable[str],
    readings: Iterable[str],
    leave: Mapping[str, float],
    ensemble: int,
    spread: Mapping[str, str],
    settings: Search,
) -> FitPlan:
    """The plan of `fit`, everything checked."""
    _check(settings)
    if not cases:
        raise FitError("a fit needs a case")
    prices = dict(leave)
    read = tuple(read_free(cases, key, text, prices.pop(key, None)) for key, text in free.items())
    if prices:
        free_text = f"free are {', '.join(free)}" if free else "none is free"
        raise FitError(f"leave {next(iter(prices))}: must name a free parameter, and {free_text}")
    plan = FitPlan(
        tuple(cases),
        read,
        tuple(read_reading(cases, text) for text in readings),
        tuple(parse_statement(text, cases) for text in statements),
        _members(cases, ensemble, settings.seed, spread),
        settings,
    )
    plan.check()
    for statement in plan.statements:
        statement.check_window(cases)
    return plan


def _check(settings: Search) -> None:
    if settings.method not in METHODS:
        raise FitError(f"the method must be {' or '.join(METHODS)}, got {settings.method}")
    least = {"candidates": 0, "seed": 0, "screen": 1, "confirm": 0, "fresh": 0}
    for name, low in least.items():
        if getattr(settings, name) < low:
            raise FitError(f"{name} must be at least {low}, got {getattr(settings, name)}")
    if settings.at_most is not None and settings.at_most < 1:
        raise FitError(f"at least one parameter must be changed at a time, got {settings.at_most}")


def _members(cases: list[Case], ensemble: int, seed: int, spread: Mapping[str, str]) -> Members | None:
    if ensemble < 0:
        raise FitError(f"the number of starts must not be negative, got {ensemble}")
    if not ensemble and not spread:
        return None
    if not spread and not rotor_angles(cases[0]):
        raise FitError(
            'say what varies over the starts, such as spread={"x1": "1 mm"}, or ask for none: ensemble=0'
        )
    try:
        (members,) = read_ensemble(cases[0], ensemble, seed, spread)
        for case in cases[1:]:
            read_members(case, ensemble, seed, spread)
    except (PlanError, ValueError) as error:
        raise FitError(str(error)) from None
    return members


# One run of a fit; how it is simulated and measured stands in `vibsim.fitting.search`.


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


# A fit as an HDF5 file: what was measured over candidates, statements and starts, and what came of it.


DEFINITIONS = (
    "A shortfall is 0 where a value lies in the range that a statement asks for and grows in proportion to "
    "the distance from it, up to 1 at one width of the range (of an open range: the magnitude of its end); a "
    "verdict has 0 or 1. The penalty is the mean shortfall over statements (by weight) and starts, and what "
    "leaving the printed values costs. Start 0 is that of the case, the last n_fresh are not seen by "
    "the search."
)


def origin(plan: FitPlan) -> dict[str, Any]:
    """Attributes that are known before the first run."""
    names = " and ".join(each.name for each in plan.cases)
    return {
        **provenance("fit", plan.cases[0], f"Fit of {names}"),
        "cases_resolved_json": json.dumps([each.resolved_json() for each in plan.cases]),
        "fit_settings_json": json.dumps(plan.settings),
        "fit_sha256": plan.fingerprint,
        "n_fresh": len(plan.fresh_starts),
        "definitions": DEFINITIONS,
        "engine": ENGINE_NAME,
    }


def write_fit(path: Path, fit: FitResult) -> None:
    """Write a fit to `path`, replacing what is there in one instant. Raises ResultFileError."""
    write_hdf5(path, fit.attrs, datasets_of(fit.plan), file_values(fit))


def file_values(fit: FitResult) -> dict[str, Any]:
    """Values of the datasets of a fit, by name."""
    return {**_scales(fit), **_described(fit), **_read_measured(fit), **_read_judged(fit)}


def _scales(fit: FitResult) -> dict[str, Any]:
    """The numbers of candidates, cases, statements and starts."""
    lengths = {CANDIDATE: len(fit.candidates), **lengths_of(fit.plan)}
    return {name: np.arange(length) for name, length in lengths.items()}


def _described(fit: FitResult) -> dict[str, Any]:
    """Cases and statements; of each candidate what it changes."""
    candidates = fit.candidates
    values = {f"value_{free.name}": [number_of(one, free) for one in candidates] for free in fit.plan.free}
    return {
        "case_name": [case.name for case in fit.plan.cases],
        "statement_text": [each.text for each in fit.statements],
        "statement_case": [each.case for each in fit.statements],
        "changes": [json.dumps(one.changes) for one in candidates],
        "origin": [one.origin for one in candidates],
        "leaving": [one.leaving for one in candidates],
        **values,
    }


def _read_measured(fit: FitResult) -> dict[str, Any]:
    """Measurements of each run."""
    candidates, cases, starts = fit.candidates, range(len(fit.plan.cases)), range(fit.plan.all_starts)
    index = product([one.number for one in candidates], cases, starts)
    runs = [fit.runs.get(each) or SweepPoint(each, MISSING, "") for each in index]
    return {
        **{name: [getattr(run, name) for run in runs] for name in ("status", "sha256", "error")},
        "value": [fit.values(each, one) for one in candidates for each in fit.statements],
        "trust_horizon": [fit.horizon(one, case) for one in candidates for case in cases],
    }


def _read_judged(fit: FitResult) -> dict[str, Any]:
    """Score of every candidate; NaN, and rank 0, for one that is not in the ranking."""
    numbers = [one.number for one in fit.candidates]
    judged = {each.candidate.number: each for each in fit.ranking}
    ranks = {number: rank for rank, number in enumerate(judged, start=1)}
    price = [judged[number].price if number in judged else np.nan for number in numbers]
    results = [
        judged[number].results if number in judged else [None] * len(fit.statements) for number in numbers
    ]
    of_statements = {
        name: [getattr(each, name, np.nan) for row in results for each in row]
        for name in ("share", "shortfall")
    }
    return {"price": price, "rank": [ranks.get(number, 0) for number in numbers], **of_statements}


def number_of(candidate: Candidate, free: FreeParameter) -> float:
    """The value of a free parameter in its unit; NaN where the candidate leaves it as printed."""

    text = candidate.changes.get(free.key)
    if text is None:
        return np.nan
    number, _, written = text.partition(" ")
    return float(exact_number(number) * UNITS[written].factor / UNITS[free.unit].factor)


# What a fit file holds.


ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("cases_resolved_json", "fit_settings_json", "fit_sha256")),
    ENGINE,
    *(Attribute(name, WHOLE) for name in ("runs", "n_fresh")),
    Attribute("complete", WHOLE, allowed=(0, 1)),
]
CANDIDATE, CASE, STATEMENT, START = "candidate", "case", "statement", "start"
DIMENSIONS = (CANDIDATE, CASE, STATEMENT, START)
RUN = (CANDIDATE, CASE, START)


def lengths_of(plan: FitPlan) -> dict[str, int]:
    """Lengths of the dimensions that the plan knows."""
    return {CASE: len(plan.cases), STATEMENT: len(plan.statements), START: plan.all_starts}


def datasets_of(plan: FitPlan) -> list[Dataset]:
    """The datasets of a fit: what it is read back from, and what was made of it for other readers."""
    scales = [Dataset(name, Column("1", f"number of the {name}", dtype="i4"), (name,)) for name in DIMENSIONS]
    return [*scales, *_measured_datasets(), *_judged_datasets(plan), *map(_value_of, plan.free)]


def _measured_datasets() -> list[Dataset]:
    return [
        _text("origin", "where the candidate comes from", CANDIDATE),
        _text("changes", "values changed, as JSON", CANDIDATE),
        Dataset("leaving", Column("1", "penalty for leaving the printed values"), (CANDIDATE,)),
        Dataset("status", Column("1", "whether it was run", dtype="i1", flags=STATUS_FLAGS), RUN),
        _text("sha256", "SHA-256 of the case of a run", *RUN),
        _text("error", "why a run failed", *RUN),
        _number("value", Column("1", "what was measured, in SI units and Hz"), CANDIDATE, STATEMENT, START),
        _number("trust_horizon", Column("s", "of the run from the case's own start"), CANDIDATE, CASE),
    ]


def _judged_datasets(plan: FitPlan) -> list[Dataset]:
    of_case = frozenset(range(len(plan.cases)))
    rank = Column("1", "place in the ranking, from 1; 0: not judged from all starts", dtype="i8")
    return [
        _text("case_name", "name of the case", CASE),
        _text("statement_text", "as given", STATEMENT),
        Dataset("statement_case", Column("1", "position of its case", dtype="i8"), (STATEMENT,), of_case),
        _number("price", Column("1", "see the attribute `definitions`"), CANDIDATE),
        Dataset("rank", rank, (CANDIDATE,)),
        _number("share", Column("1", "share of the starts from which it holds"), CANDIDATE, STATEMENT),
        _number("shortfall", Column("1", "mean"), CANDIDATE, STATEMENT),
    ]


def _value_of(free: FreeParameter) -> Dataset:
    column = Column(free.unit or "1", f"{free.key}, as printed where NaN")
    return _number(f"value_{free.name}", column, CANDIDATE)


def _number(name: str, column: Column, *dims: str) -> Dataset:
    return Dataset(name, column, dims, gaps=True)


def _text(name: str, long_name: str, *dims: str) -> Dataset:
    return Dataset(name, Column(None, long_name, dtype="text"), dims)


# A fit file read back, held against what it must hold.


SETTINGS = "the attribute fit_settings_json"

Stored = tuple[dict[str, Any], FitPlan, list[Candidate], list[SweepPoint]]


def read_fit(path: Path) -> Stored:
    """Attributes, plan, candidates and runs of a fit file, the file checked. Raises ResultFileError."""
    with opened(path, "fit") as file:
        attrs = read_attributes(path, file, ATTRIBUTES)
        case = stored_case(path, attrs)
        with understood(path, f"{SETTINGS} and fit_sha256 describe no fit of its cases"):
            plan = _plan(case, attrs)
            plan.check()
        values = read_datasets(path, file, datasets_of(plan), lengths_of(plan))
    with understood(path, "changes has values that its cases do not take"):
        candidates = _candidates(values, plan)
    return attrs, plan, candidates, _runs(values, plan)


def _plan(first: Case, attrs: Mapping[str, Any]) -> FitPlan:
    """The plan that a file's attributes describe."""
    settings = json.loads(attrs["fit_settings_json"])
    others = [Case.from_resolved_json(text) for text in json.loads(attrs["cases_resolved_json"])[1:]]
    cases = (first, *others)
    if fingerprint_of(cases, settings) != attrs["fit_sha256"]:
        raise ValueError("settings or cases were changed")
    statements = tuple(parse_statement(text, cases) for text in settings["statements"])
    plan: FitPlan = from_plain(FitPlan, settings, cases=cases, statements=statements)
    return plan


def _candidates(stored: Mapping[str, Any], plan: FitPlan) -> list[Candidate]:
    candidates = []
    rows = zip(stored["origin"], stored["changes"], stored["leaving"], strict=True)
    for number, (origin, changes, leaving) in enumerate(rows):
        values = dict(json.loads(changes))
        plan.cases[0].with_values(values)
        candidates.append(Candidate(number, str(origin), values, float(leaving)))
    return candidates


def _runs(stored: Mapping[str, Any], plan: FitPlan) -> list[SweepPoint]:
    """The runs, trust horizons included."""
    names = ("status", "value", "trust_horizon", "sha256", "error")
    status, values, horizons, sha256, error = (stored[name] for name in names)
    runs = []
    for number, case, start in np.argwhere(status != MISSING).tolist():
        measured = {
            str(plan.asked[case].index(each.asked)): float(values[number, i, start])
            for i, each in enumerate(plan.statements)
            if each.case == case
        }
        at = number, case, start
        runs.append(SweepPoint(at, int(status[at]), str(sha256[at]), str(error[at]), measured))
    for number, case in np.argwhere(~np.isnan(horizons)).tolist():
        attributes = {HORIZON: float(horizons[number, case])}
        runs.append(SweepPoint((number, case, TRUST), DONE, str(sha256[number, case, 0]), "", attributes))
    return runs

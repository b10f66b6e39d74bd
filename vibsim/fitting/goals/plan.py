"""What a fit is to do: cases, free parameters, readings, statements, starts, and how it searches."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from math import comb
from typing import TYPE_CHECKING, Any

import scipy

from vibsim.fitting.errors import FitError
from vibsim.fitting.goals.free_parameter import FreeParameter
from vibsim.fitting.goals.measuring import Task, Work
from vibsim.fitting.goals.reading import PRINTED, Candidate
from vibsim.fitting.goals.statement import Asked, Statement
from vibsim.sweeps.plan.members import Members

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

    cases: tuple[Case, ...]
    free: tuple[FreeParameter, ...]
    readings: tuple[dict[str, str], ...]
    statements: tuple[Statement, ...]
    members: Members | None
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
        return old and Members(len(old) + self.search.fresh, old.seed, old.spreads, old.first)

    def start(self, position: int) -> dict[str, str]:
        """What a start changes in a case; the first one nothing."""
        return self.drawn.changes(position - 1) if position and self.drawn else {}

    def statements_on(self, case: int) -> list[Statement]:
        """The statements on one case."""
        return [statement for statement in self.statements if statement.case == case]

    @cached_property
    def asked(self) -> tuple[tuple[Asked, ...], ...]:
        """What is measured of each case, each once."""
        return tuple(
            tuple(dict.fromkeys(each.asked for each in self.statements_on(case)))
            for case in range(len(self.cases))
        )

    @cached_property
    def work(self) -> Work:
        """What workers need to know besides their tasks."""
        return Work(self.cases, self.asked)

    def task(self, candidate: Candidate, case: int, start: int) -> Task:
        """The run of a candidate of one case from one start."""
        return Task((candidate.number, case, start), case, {**candidate.changes, **self.start(start)})

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
            "free": [each.plain() for each in self.free],
            "readings": [dict(each) for each in self.readings],
            "statements": [f"{self.cases[each.case].name}: {each.text}" for each in self.statements],
            "starts": self.members.plain() if self.members else None,
            "search": asdict(self.search),
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

"""What a fit came to: labelled lines and a table for people, plain data for programs."""

from __future__ import annotations

import json
from math import isnan
from pathlib import Path
from typing import Any

from vibsim.fitting.fit_result import FitResult, open_fit
from vibsim.fitting.judgement import Judgement, StatementResult

Lines = list[tuple[str, str]]
Table = tuple[tuple[str, ...], list[tuple[str, ...]]]  # heads, rows

SHOWN = 10  # rows of a table


def describe(path: str | Path) -> tuple[Lines, dict[str, Any]]:
    """Lines and facts of a fit file. Raises ResultFileError where it holds none."""
    fit = open_fit(path)
    return fit_lines(fit), facts(fit)


def fit_lines(fit: FitResult) -> Lines:
    """What was sought, among what, from which starts."""
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
        lines.append(("incomplete", "the search did not reach its end; the same command goes on"))
    return lines


def _statement_line(fit: FitResult, position: int) -> str:
    statement = fit.statements[position]
    name = f"{fit.plan.cases[statement.case].name}: " if len(fit.plan.cases) > 1 else ""
    return f"{name}{statement.text}"


def starts_text(fit: FitResult) -> str:
    """Which starts runs are judged from."""
    members = fit.plan.members
    if members is None:
        return "that of the case alone"
    fresh = f"; the best from {len(fit.plan.fresh_starts)} more" if fit.plan.fresh_starts else ""
    return f"that of the case and {members}{fresh}"


def search_text(fit: FitResult) -> str:
    """How it was searched, and how much of it was done."""
    search, searched = fit.plan.search, sum(one.origin == "search" for one in fit.candidates)
    readings = f"{len(fit.plan.readings)} reading{'' if len(fit.plan.readings) == 1 else 's'}"
    how = [f"{searched} candidates, {search.method}, seed {search.seed}"] if fit.plan.free else []
    if fit.plan.free and search.at_most:
        how.append(f"at most {search.at_most} changed at a time")
    how += [readings] if fit.plan.readings else []
    return f"{'; '.join(how)}; {len(fit.runs)} runs"


def best_text(fit: FitResult) -> str:
    """The first of the ranking in a sentence."""
    best = fit.best
    return (
        f"{best.candidate}: {best.explained} of {len(best.results)} statements hold, price {best.price:.3f}"
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
    heads = ("", "changed", *(f"{i}" for i in range(1, len(fit.statements) + 1)), "hold", "price")
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

"""A fit as an HDF5 file: what was measured over candidates, statements and starts, and what came of it."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.choice import engine_name
from vibsim.files.provenance import provenance
from vibsim.files.writing import write_hdf5
from vibsim.fitting.goals.free_parameter import FreeParameter
from vibsim.fitting.goals.plan import FitPlan
from vibsim.fitting.goals.reading import Candidate
from vibsim.fitting.store.fit_structure import CANDIDATE, datasets_of, lengths_of
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.statistics.columns import MISSING

if TYPE_CHECKING:
    from vibsim.fitting.fit_result import FitResult

DEFINITIONS = (
    "A shortfall is 0 where a value lies in the range that a statement asks for and grows in proportion to "
    "the distance from it, up to 1 at one width of the range (of an open range: the magnitude of its end); a "
    "verdict has 0 or 1. The price is the mean shortfall over statements (by weight) and starts, and what "
    "leaving the printed values costs. Start 0 is that of the case, the last n_fresh are not seen by "
    "the search."
)


def origin(plan: FitPlan, engine: str) -> dict[str, Any]:
    """Attributes that are known before the first run."""
    names = " and ".join(each.name for each in plan.cases)
    return {
        **provenance("fit", plan.cases[0], f"Fit of {names}"),
        "cases_resolved_json": json.dumps([each.resolved_json() for each in plan.cases]),
        "fit_settings_json": json.dumps(plan.settings),
        "fit_sha256": plan.fingerprint,
        "n_fresh": len(plan.fresh_starts),
        "definitions": DEFINITIONS,
        "engine": engine_name(engine),
    }


def write_fit(path: Path, fit: FitResult) -> None:
    """Write a fit to `path`, replacing what is there in one instant. Raises ResultFileError."""
    write_hdf5(path, fit.attrs, datasets_of(fit.plan), file_values(fit))


def file_values(fit: FitResult) -> dict[str, Any]:
    """What stands in the datasets of a fit, by name."""
    return {**_scales(fit), **_described(fit), **_measured(fit), **_judged(fit)}


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


def _measured(fit: FitResult) -> dict[str, Any]:
    """What came of each run."""
    candidates, cases, starts = fit.candidates, range(len(fit.plan.cases)), range(fit.plan.all_starts)
    index = product([one.number for one in candidates], cases, starts)
    runs = [fit.runs.get(each) or Point(each, MISSING, "") for each in index]
    return {
        **{name: [getattr(run, name) for run in runs] for name in ("status", "sha256", "error")},
        "value": [fit.values(each, one) for one in candidates for each in fit.statements],
        "trust_horizon": [fit.horizon(one, case) for one in candidates for case in cases],
    }


def _judged(fit: FitResult) -> dict[str, Any]:
    """What every candidate is worth; NaN, and rank 0, for one that is not in the ranking."""
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
    from vibsim.cases.values.quantities import parse_quantity
    from vibsim.cases.values.units import UNITS

    text = candidate.changes.get(free.key)
    if text is None:
        return np.nan
    quantity = parse_quantity(text, UNITS[free.unit].dimension)
    return float(quantity.value / UNITS[free.unit].factor)

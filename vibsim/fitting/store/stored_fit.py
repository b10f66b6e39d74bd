"""A fit file read back, held against what it must hold."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases import Case
from vibsim.files.reading import opened, read_attributes, read_datasets
from vibsim.files.stored_case import stored_case, understood
from vibsim.fitting.goals.free_parameter import FreeParameter
from vibsim.fitting.goals.grammar import parse_statement
from vibsim.fitting.goals.measuring import HORIZON, TRUST
from vibsim.fitting.goals.plan import FitPlan, Search, fingerprint_of
from vibsim.fitting.goals.reading import Candidate
from vibsim.fitting.store.fit_structure import ATTRIBUTES, datasets_of, lengths_of
from vibsim.sweeps.plan.members import Members, axis_from_plain
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.statistics.columns import DONE, MISSING

SETTINGS = "the attribute fit_settings_json"

Stored = tuple[dict[str, Any], FitPlan, list[Candidate], list[Point]]


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
    members = axis_from_plain(settings["starts"]) if settings["starts"] else None
    if not (members is None or isinstance(members, Members)):
        raise ValueError("starts")
    return FitPlan(
        cases,
        tuple(map(FreeParameter.from_plain, settings["free"])),
        tuple(dict(reading) for reading in settings["readings"]),
        tuple(parse_statement(text, cases) for text in settings["statements"]),
        members,
        Search(**settings["search"]),
    )


def _candidates(stored: Mapping[str, Any], plan: FitPlan) -> list[Candidate]:
    candidates = []
    rows = zip(stored["origin"], stored["changes"], stored["leaving"], strict=True)
    for number, (origin, changes, leaving) in enumerate(rows):
        values = dict(json.loads(changes))
        plan.cases[0].with_values(values)
        candidates.append(Candidate(number, str(origin), values, float(leaving)))
    return candidates


def _runs(stored: Mapping[str, Any], plan: FitPlan) -> list[Point]:
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
        runs.append(Point(at, int(status[at]), str(sha256[at]), str(error[at]), measured))
    for number, case in np.argwhere(~np.isnan(horizons)).tolist():
        attributes = {HORIZON: float(horizons[number, case])}
        runs.append(Point((number, case, TRUST), DONE, str(sha256[number, case, 0]), "", attributes))
    return runs

"""A fit file read back, held against what it must hold."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vibsim.cases import Case, CaseError
from vibsim.fitting.fit_structure import ATTRIBUTES, datasets_of, lengths_of
from vibsim.fitting.free_parameter import FreeParameter
from vibsim.fitting.grammar import parse_statement
from vibsim.fitting.measuring import HORIZON, TRUST
from vibsim.fitting.plan import FitPlan, Search, fingerprint_of
from vibsim.fitting.reading import Candidate
from vibsim.results.attributes import read_attrs
from vibsim.results.errors import ResultFileError
from vibsim.results.hdf5_file import damage_named, open_hdf5
from vibsim.results.stored_case import stored_case
from vibsim.results.structure import check_datasets, check_values, checked_attributes, damaged
from vibsim.sweeps.plan.members import Members, axis_from_plain
from vibsim.sweeps.points.point import Point
from vibsim.sweeps.statistics.columns import DONE, MISSING

SETTINGS = "the attribute fit_settings_json"
WRONG = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError, CaseError)

Stored = tuple[dict[str, Any], FitPlan, list[Candidate], list[Point]]


def read_fit(path: Path) -> Stored:
    """Attributes, plan, candidates and runs of a fit file, the file checked. Raises ResultFileError."""
    with damage_named(path), open_hdf5(path) as file:
        kind = file.attrs.get("vibsim_kind")
        if kind != "fit":
            raise ResultFileError(f"{path}: holds a {kind or 'trajectory'}, not a fit")
        attrs = checked_attributes(path, read_attrs(file), ATTRIBUTES)
        case = stored_case(path, attrs)
        try:
            plan = _plan(case, attrs)
            plan.check()
        except WRONG as error:
            raise damaged(path, f"{SETTINGS} and fit_sha256 describe no fit of its cases") from error
        declared = datasets_of(plan)
        check_datasets(path, file, declared, lengths_of(plan))
        for dataset in declared:
            if dataset.dtype != "text":
                check_values(path, dataset, file[dataset.name][...])
        try:
            candidates = _candidates(file, plan)
        except WRONG as error:
            raise damaged(path, "changes has values that its cases do not take") from error
        return attrs, plan, candidates, _runs(file, plan)


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


def _candidates(file: h5py.File, plan: FitPlan) -> list[Candidate]:
    origins, changes = file["origin"].asstr()[...], file["changes"].asstr()[...]
    leaving = file["leaving"][...]
    found = []
    for number in range(len(origins)):
        values = dict(json.loads(changes[number]))
        plan.cases[0].with_values(values)
        found.append(Candidate(number, str(origins[number]), values, float(leaving[number])))
    return found


def _runs(file: h5py.File, plan: FitPlan) -> list[Point]:
    """The runs, trust horizons included."""
    status, values, horizons = file["status"][...], file["value"][...], file["trust_horizon"][...]
    sha256, error = file["sha256"].asstr()[...], file["error"].asstr()[...]
    found = []
    for number, case, start in np.argwhere(status != MISSING).tolist():
        measured = {
            str(plan.asked[case].index(each.asked)): float(values[number, i, start])
            for i, each in enumerate(plan.statements)
            if each.case == case
        }
        at = number, case, start
        found.append(Point(at, int(status[at]), str(sha256[at]), str(error[at]), measured))
    for number, case in np.argwhere(~np.isnan(horizons)).tolist():
        told = {HORIZON: float(horizons[number, case])}
        found.append(Point((number, case, TRUST), DONE, str(sha256[number, case, 0]), "", told))
    return found

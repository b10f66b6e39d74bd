"""A branch as an HDF5 file: written whole, read back to the bit."""

import json
from collections.abc import Callable, Sequence
from itertools import starmap
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.branches.branch import Branch
from vibsim.branches.plan import BranchPlan
from vibsim.branches.special.special import UNRESOLVED
from vibsim.branches.store.structure import (
    ATTRIBUTES,
    BODY,
    KINDS,
    MULTIPLIER,
    POINT,
    SCALED,
    SPECIAL,
    UNKNOWN,
    datasets_of,
)
from vibsim.branches.tracing.records import OrbitRecord, PointRecord, SpecialRecord
from vibsim.engine.choice import engine_name
from vibsim.files.provenance import provenance
from vibsim.files.reading import opened, read_attributes, read_datasets
from vibsim.files.stored_case import stored_case, understood
from vibsim.files.writing import write_hdf5
from vibsim.orbits.returns.word import LETTERS, Word

KIND = "branch"
KIND_NAMES = {code: kind for kind, code in KINDS.items()}
EVENTS = {letter: kind for kind, letter in LETTERS.items()}


def origin(plan: BranchPlan, engine: str = "auto") -> dict[str, Any]:
    """Attributes that are known before the first point."""
    return {
        **provenance("branch", plan.case, f"Periodic orbits of {plan.case.name} over {plan.keys[0]}"),
        "branch_settings_json": json.dumps(plan.settings),
        "branch_sha256": plan.fingerprint,
        "engine": engine_name(engine),
    }


def write_branch(path: Path, branch: Branch, attrs: dict[str, Any], complete: bool) -> None:
    """Write a branch to `path`, replacing what is there in one instant. Raises ResultFileError."""
    specials, orbits = branch.specials, branch.points
    unresolved = sum(one.kind == UNRESOLVED for one in specials)
    counts = {"points": len(orbits), "special_points": len(specials), "unresolved": unresolved}
    counts["complete"] = int(complete)
    names = {"names_json": json.dumps(branch.names)}
    write_hdf5(path, {**attrs, **names, **counts}, datasets_of(branch.unit), values_of(branch))


def values_of(branch: Branch) -> dict[str, Any]:
    """What stands in the datasets of a branch, by name."""
    specials = branch.specials
    records = {record.unknowns: record for record in branch.records[1]}
    special_records = [records[one.unknowns] for one in specials]
    orbits = [point.orbit for point in branch.points]
    return {
        POINT: np.arange(len(orbits)),
        SPECIAL: np.arange(len(special_records)),
        UNKNOWN: np.arange(len(branch.plan.state)),
        SCALED: np.arange(len(branch.points[0].unknowns)),
        MULTIPLIER: np.arange(len(orbits[0].multipliers)),
        BODY: np.arange(len(orbits[0].drift)),
        **orbit_values("", branch.spelled, branch.points),
        **orbit_values("special_", branch.spelled, special_records),
        **{name: [getattr(one, name) for one in branch.points] for name in ("step", "iterations", "ended")},
        "special_kind": [KINDS[record.kind] for record in special_records],
        "special_label": [one.label for one in specials],
        "special_before": [branch.spelled(record.before) for record in special_records],
        "special_after": [branch.spelled(record.after) for record in special_records],
        "special_jump": [record.jump for record in special_records],
    }


def orbit_values(prefix: str, spelled: Callable[[Word], str], records: Sequence[Any]) -> dict[str, Any]:
    """What is told of the orbits of records, by name of the dataset."""
    orbits = [record.orbit for record in records]
    plain = ("parameter", "period", "state", "fold", "doubling", "margin", "drift", "residual", "uncertified")
    values: dict[str, Any] = {name: [getattr(orbit, name) for orbit in orbits] for name in plain}
    places = ("way", "number", "unknowns", "tangent")
    values |= {name: [getattr(one, name) for one in records] for name in places}
    values["multiplier_re"] = [[mu.real for mu in orbit.multipliers] for orbit in orbits]
    values["multiplier_im"] = [[mu.imag for mu in orbit.multipliers] for orbit in orbits]
    values["word"] = [spelled(orbit.word) for orbit in orbits]
    return {f"{prefix}{name}": value for name, value in values.items()}


def read_branch(path: str | Path) -> Branch:
    """The branch in a file, in which everything has been checked. Raises ResultFileError."""
    path = Path(path)
    with opened(path, KIND) as file:
        attrs = read_attributes(path, file, ATTRIBUTES)
        plan = _plan(path, attrs)
        lengths = {POINT: attrs["points"], SPECIAL: attrs["special_points"]}
        values = read_datasets(path, file, datasets_of(plan.unit), lengths)
    with understood(path, "its points make no sense"):
        points = [_point(values, i) for i in range(attrs["points"])]
        specials = [_special(values, i) for i in range(attrs["special_points"])]
        branch = Branch(plan, points, sorted(specials, key=lambda one: (-one.way, one.number)), attrs)
        if not points or not any(point.number == 0 for point in points):
            raise ValueError("no start")
        len(branch.specials)
    return branch


def _plan(path: Path, attrs: dict[str, Any]) -> BranchPlan:
    case = stored_case(path, attrs)
    with understood(path, "the attribute branch_settings_json makes no sense"):
        return BranchPlan.from_settings(case, json.loads(attrs["branch_settings_json"]))


def _point(values: dict[str, Any], i: int) -> PointRecord:
    number, way = int(values["number"][i]), int(values["way"][i])
    z, tangent = places_of("", values, i)
    step, iterations = float(values["step"][i]), int(values["iterations"][i])
    orbit, ended = orbit_of("", values, i), str(values["ended"][i])
    return PointRecord(way, number, orbit, z, tangent, step, iterations, ended)


def _special(values: dict[str, Any], i: int) -> SpecialRecord:
    number, way = int(values["special_number"][i]), int(values["special_way"][i])
    z, tangent = places_of("special_", values, i)
    before, after = (read_spelled(values[name][i]) for name in ("special_before", "special_after"))
    kind, jump = KIND_NAMES[int(values["special_kind"][i])], int(values["special_jump"][i])
    return SpecialRecord(way, number, kind, orbit_of("special_", values, i), z, tangent, before, after, jump)


def places_of(prefix: str, values: dict[str, Any], i: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Scaled unknowns and tangent of row i of the datasets with a prefix."""
    return tuple(values[f"{prefix}unknowns"][i].tolist()), tuple(values[f"{prefix}tangent"][i].tolist())


def orbit_of(prefix: str, values: dict[str, Any], i: int) -> OrbitRecord:
    """The orbit of row i of the datasets with a prefix."""

    def of(name: str) -> Any:
        return values[f"{prefix}{name}"][i]

    return OrbitRecord(
        parameter=float(of("parameter")),
        period=float(of("period")),
        state=tuple(of("state").tolist()),
        multipliers=tuple(starmap(complex, zip(of("multiplier_re"), of("multiplier_im"), strict=True))),
        word=read_spelled(of("word")),
        fold=float(of("fold")),
        doubling=float(of("doubling")),
        margin=float(of("margin")),
        drift=tuple(of("drift").tolist()),
        residual=float(of("residual")),
        uncertified=int(of("uncertified")),
    )


def read_spelled(text: str) -> Word:
    """The word of its letters, as `vibsim.orbits.returns.word.spelled` writes it."""
    letters = text.split() if " " in text or text[1:].isdigit() else list(text)
    return tuple((EVENTS[one[0]], int(one[1:] or 1) - 1) for one in letters)

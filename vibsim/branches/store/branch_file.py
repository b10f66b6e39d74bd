"""A branch as an HDF5 file: written whole, read back to the bit."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain, starmap
from pathlib import Path
from typing import Any, TypeVar

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
from vibsim.branches.tracing.records import OrbitRecord, PointRecord, SpecialRecord, read_record
from vibsim.engine.choice import engine_name
from vibsim.files.journal import Waiting
from vibsim.files.provenance import provenance
from vibsim.files.reading import opened, read_attributes, read_datasets
from vibsim.files.stored_case import stored_case, understood
from vibsim.files.writing import write_hdf5
from vibsim.orbits.returns.word import LETTERS, Word

KIND = "branch"
KIND_NAMES = {code: kind for kind, code in KINDS.items()}
Walked = TypeVar("Walked", bound=Any)  # a point with its way and its number on it
Others = TypeVar("Others")
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
    names = {"names_json": json.dumps(branch.names), "complete": int(complete)}
    write_hdf5(path, {**attrs, **names, **_counts(branch)}, datasets_of(branch.unit), values_of(branch))


def _counts(branch: Branch) -> dict[str, int]:
    """Attributes that count what there is."""
    unresolved = sum(one.kind == UNRESOLVED for one in branch.specials)
    return {
        "points": len(branch.points),
        "special_points": len(branch.specials),
        "unresolved": unresolved,
    }


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
    """The branch in a file, in which everything has been checked, with the points that wait in its journal.

    Raises ResultFileError.
    """
    waiting, branch = Waiting(path), stored_branch(path)
    points, specials = branch.records
    follows = follow_up(points, map(read_pair, waiting.records(branch.plan.fingerprint)))
    if not follows:
        return branch
    points = [*in_order(points), *(point for point, _ in follows)]
    specials = [*specials, *chain.from_iterable(others for _, others in follows)]
    whole = Branch(branch.plan, points, specials)
    return Branch(branch.plan, points, specials, {**branch.attrs, **_counts(whole)})


def stored_branch(path: str | Path) -> Branch:
    """The branch in a file as it stands there. Raises ResultFileError."""
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


def in_order(points: Iterable[Walked]) -> list[Walked]:
    """Points of a file, where they stand along the branch, in the order in which they were made."""
    return sorted(points, key=lambda point: (-point.way, point.number))


def read_pair(record: Mapping[str, Any]) -> tuple[PointRecord, list[SpecialRecord]]:
    """A point in a journal, and the special points in front of it."""
    point: Any = read_record(record["point"])
    specials: Any = [read_record(each) for each in record["specials"]]
    return point, specials


def follow_up(
    points: Iterable[Walked], waiting: Iterable[tuple[Walked, Others]]
) -> list[tuple[Walked, Others]]:
    """What waits, each point with something, as far as each is the next one of its way behind the points that
    are known: none that is known, nor what stands behind a damaged record.
    """
    last: dict[int, int] = {}
    for point in points:
        last[point.way] = max(point.number, last.get(point.way, 0))
    follows = []
    for point, others in waiting:
        if point.number == last.get(point.way, 0 if last else -1) + 1:
            last[point.way] = point.number
            follows.append((point, others))
    return follows


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

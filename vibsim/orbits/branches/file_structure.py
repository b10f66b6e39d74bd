"""What files of branches and loci hold, and how they are written."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.engine.choice import engine_name
from vibsim.orbits.branches.plan import BranchPlan
from vibsim.orbits.branches.special_points import LABELS, UNRESOLVED
from vibsim.orbits.coordinates import Word, spelled
from vibsim.results.file_contents import (
    ENGINE,
    PROVENANCE,
    TEXT,
    WHOLE,
    Attribute,
    Column,
    Dataset,
    provenance,
)
from vibsim.results.hdf5_writing import write_hdf5

if TYPE_CHECKING:
    from vibsim.orbits.branches.branch import Branch
    from vibsim.orbits.branches.locus_result import Locus, LocusPlan

BRANCH_KIND = "branch"
LOCUS_KIND = "locus"


ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("branch_settings_json", "branch_sha256", "names_json")),
    ENGINE,
    *(Attribute(name, WHOLE) for name in ("points", "special_points", "unresolved")),
    Attribute("complete", WHOLE, allowed=(0, 1)),
]
POINT, SPECIAL = "point", "special"
UNKNOWN, SCALED, MULTIPLIER, BODY = "unknown", "scaled", "multiplier", "body"
FURTHER = (UNKNOWN, SCALED, MULTIPLIER, BODY)
KINDS = {kind: code for code, kind in enumerate(LABELS)}


def datasets_of(unit: str) -> list[Dataset]:
    """The datasets of a branch whose parameter has a unit."""
    scales = [
        Dataset(name, Column("1", f"number of the {what}", dtype="i4"), (name,))
        for name, what in (
            (POINT, "point along the branch"),
            (SPECIAL, "special point along the branch"),
            (UNKNOWN, "unknown on the section, see the attribute names_json"),
            (SCALED, "scaled unknown: state, time of return with a motor, parameter"),
            (MULTIPLIER, "multiplier, the largest first"),
            (BODY, "set of bodies that is held nowhere"),
        )
    ]
    along = [
        Dataset("step", Column("1", "scaled length of the step behind it"), (POINT,)),
        Dataset("iterations", Column("1", "Newton steps that it took", dtype="i4"), (POINT,)),
        Dataset("ended", Column(None, "why the branch goes no further", dtype="text"), (POINT,)),
    ]
    special = [
        Dataset("special_kind", Column(None, "what it is", dtype="i1", flags=KINDS), (SPECIAL,)),
        Dataset("special_label", Column(None, "what it is called", dtype="text"), (SPECIAL,)),
        Dataset("special_before", Column(None, "events in front of it, as walked", dtype="text"), (SPECIAL,)),
        Dataset("special_after", Column(None, "events behind it, as walked", dtype="text"), (SPECIAL,)),
        Dataset(
            "special_jump",
            Column("1", "multipliers more outside the circle behind it, as walked", dtype="i4"),
            (SPECIAL,),
        ),
    ]
    return [*scales, *_orbits("", POINT, unit), *along, *_orbits("special_", SPECIAL, unit), *special]


LOCUS_ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("locus_settings_json", "locus_sha256")),
    ENGINE,
    Attribute("points", WHOLE),
    Attribute("complete", WHOLE, allowed=(0, 1)),
]


def locus_datasets(unit: str, second_unit: str) -> list[Dataset]:
    """The datasets of a locus whose two parameters have units."""
    scales = [scale for scale in datasets_of(unit) if scale.is_scale and scale.name != SPECIAL]
    second = Column(second_unit or "1", "value of the second parameter")
    others = Column("1", "multipliers outside the unit circle besides those on it", dtype="i4")
    return [
        *scales,
        *_orbits("", POINT, unit),
        Dataset("second", second, (POINT,)),
        Dataset("index", others, (POINT,)),
        Dataset("step", Column("1", "scaled length of the step behind it"), (POINT,)),
        Dataset("ended", Column(None, "why the locus goes no further", dtype="text"), (POINT,)),
    ]


def _orbits(prefix: str, along: str, unit: str) -> list[Dataset]:
    """What is told of an orbit, be it a point of the branch or a special one."""

    def number(name: str, units: str, what: str, *further: str, gaps: bool = False) -> Dataset:
        return Dataset(f"{prefix}{name}", Column(units, what), (along, *further), gaps=gaps)

    def whole(name: str, what: str) -> Dataset:
        return Dataset(f"{prefix}{name}", Column("1", what, dtype="i4"), (along,))

    return [
        number("parameter", unit or "1", "value of the parameter"),
        number("period", "s", "time of return"),
        number("state", "SI", "unknowns on the section", UNKNOWN),
        number("multiplier_re", "1", "real parts of the multipliers", MULTIPLIER),
        number("multiplier_im", "1", "imaginary parts of the multipliers", MULTIPLIER),
        number("fold", "1", "det(P' - I)"),
        number("doubling", "1", "det(P' + I)"),
        number("margin", "m", "smallest gap at a turn without contact; infinite without any", gaps=True),
        number("drift", "m", "displacement per period of what is held nowhere", BODY),
        number("residual", "1", "of the scaled equations"),
        Dataset(f"{prefix}word", Column(None, "events of one period, as a circle", dtype="text"), (along,)),
        whole("uncertified", "doubts of the certificate"),
        whole("way", "1 forwards from the start of the branch, -1 backwards"),
        whole("number", "steps from the start"),
        number("unknowns", "1", "scaled unknowns", SCALED),
        number("tangent", "1", "along the branch, scaled, as walked", SCALED),
    ]


def branch_origin(plan: BranchPlan, engine: str = "auto") -> dict[str, Any]:
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
    write_hdf5(
        path, {**attrs, **names, **kind_counts(branch)}, datasets_of(branch.unit), branch_values(branch)
    )


def kind_counts(branch: Branch) -> dict[str, int]:
    """Attributes that count what there is."""
    unresolved = sum(one.kind == UNRESOLVED for one in branch.specials)
    return {
        "points": len(branch.points),
        "special_points": len(branch.specials),
        "unresolved": unresolved,
    }


def branch_values(branch: Branch) -> dict[str, Any]:
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


def locus_origin(plan: LocusPlan, engine: str = "auto") -> dict[str, Any]:
    """Attributes that are known before the first point."""
    title = f"{plan.kind} {plan.label} of {plan.branch.case.name} over {plan.keys[0]}"
    return {
        **provenance(LOCUS_KIND, plan.branch.case, title),
        "locus_settings_json": json.dumps(plan.settings),
        "locus_sha256": plan.fingerprint,
        "engine": engine_name(engine),
    }


def write_locus(path: Path, locus: Locus, attrs: dict[str, Any], complete: bool) -> None:
    """Write a locus to `path`, replacing what is there in one instant. Raises ResultFileError."""
    counts = {"points": len(locus), "complete": int(complete)}
    declared = locus_datasets(locus.plan.branch.unit, locus.plan.unit)
    write_hdf5(path, {**attrs, **counts}, declared, locus_values(locus))


def locus_values(locus: Locus) -> dict[str, Any]:
    """What stands in the datasets of a locus, by name."""
    points, scene = locus.points, locus.case.scene()
    first = points[0]
    return {
        POINT: np.arange(len(points)),
        UNKNOWN: np.arange(len(first.orbit.state)),
        SCALED: np.arange(len(first.unknowns)),
        MULTIPLIER: np.arange(len(first.orbit.multipliers)),
        BODY: np.arange(len(first.orbit.drift)),
        **orbit_values("", lambda word: spelled(scene, word), points),
        **{name: [getattr(one, name) for one in points] for name in ("second", "index", "step", "ended")},
    }

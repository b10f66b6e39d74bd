"""What files of branches and loci hold: attributes, datasets, and records as their rows."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from itertools import starmap
from typing import Any

import numpy as np

from vibsim.engine.choice import engine_name
from vibsim.orbits.branches.plan import CurvePlan
from vibsim.orbits.branches.special_points import LABELS
from vibsim.orbits.branches.tracing import OrbitRecord
from vibsim.orbits.coordinates import LETTERS, Word
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


def curve_origin(plan: CurvePlan, engine: str = "auto") -> dict[str, Any]:
    """Attributes that are known before the first point."""
    return {
        **provenance(plan.noun, plan.case, plan.title),
        f"{plan.noun}_settings_json": json.dumps(plan.settings),
        f"{plan.noun}_sha256": plan.fingerprint,
        "engine": engine_name(engine),
    }


# Records as rows of datasets. Words are spelled in letters, complex numbers have a dataset of each part.


KINDS_BY_CODE = {code: kind for kind, code in KINDS.items()}
EVENTS = {letter: kind for kind, letter in LETTERS.items()}
SPELLED = ("word", "before", "after")


def scale_values(record: Any) -> dict[str, Any]:
    """The numbers along the dimensions that the points of a curve share, told by one of them."""
    orbit = record.orbit
    lengths = (orbit.state, record.unknowns, orbit.multipliers, orbit.drift)
    return {name: np.arange(len(each)) for name, each in zip(FURTHER, lengths, strict=True)}


def columns_of(
    kind: Any, records: Sequence[Any], spell: Callable[[Word], str], prefix: str = ""
) -> dict[str, Any]:
    """What stands in the datasets of records of a kind, by name."""
    columns: dict[str, Any] = {}
    for name in (each.name for each in fields(kind)):
        values = [getattr(record, name) for record in records]
        if name == "orbit":
            columns |= columns_of(OrbitRecord, values, spell, prefix)
        elif name == "multipliers":
            columns[f"{prefix}multiplier_re"] = [[mu.real for mu in each] for each in values]
            columns[f"{prefix}multiplier_im"] = [[mu.imag for mu in each] for each in values]
        elif name in SPELLED:
            columns[f"{prefix}{name}"] = [spell(word) for word in values]
        else:
            columns[f"{prefix}{name}"] = [KINDS[each] for each in values] if name == "kind" else values
    return columns


def record_of(kind: Any, columns: Mapping[str, Any], i: int, prefix: str = "") -> Any:
    """The record of a kind in row i of the datasets that `columns_of` has made."""

    def value(name: str, of: Any) -> Any:
        if name == "orbit":
            return record_of(OrbitRecord, columns, i, prefix)
        if name == "multipliers":
            parts = (columns[f"{prefix}multiplier_{part}"][i] for part in ("re", "im"))
            return tuple(starmap(complex, zip(*parts, strict=True)))
        here = columns[f"{prefix}{name}"][i]
        if name in SPELLED:
            return read_spelled(here)
        if name == "kind":
            return KINDS_BY_CODE[int(here)]
        return of(here) if of in (int, float, str) else tuple(here.tolist())

    return kind(**{each.name: value(each.name, each.type) for each in fields(kind)})


def read_spelled(text: str) -> Word:
    """The word of its letters, as `vibsim.orbits.coordinates.spelled` writes it."""
    letters = text.split() if " " in text or text[1:].isdigit() else list(text)
    return tuple((EVENTS[one[0]], int(one[1:] or 1) - 1) for one in letters)

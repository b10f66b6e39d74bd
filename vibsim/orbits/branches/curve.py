"""A curve of periodic orbits, a branch or a locus: points along it, arrays by name, its file, its store."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cached_property
from itertools import starmap
from os import PathLike
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np

from vibsim.orbits.branches.plan import CurvePlan
from vibsim.orbits.branches.special_points import LABELS
from vibsim.orbits.branches.tracing import OrbitRecord, Watch
from vibsim.orbits.words import LETTERS, Word, spelled
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
from vibsim.results.hdf5_reading import ResultFileError, read_attributes, stored_case, understood
from vibsim.results.hdf5_writing import write_hdf5
from vibsim.results.labelled import Arrays, Labelled
from vibsim.results.output_files import check_result_output
from vibsim.results.store import R, Store, Waiting, from_plain


class OrbitCurve(Labelled):
    """Points along a curve, those backwards from its start first; a class of it says what it is.

    plan : what was followed
    attrs : of its file
    """

    noun: str
    _record: type  # of a point
    _shown: tuple[str, ...]  # arrays that a table shows first
    plan: Any
    points: list[Any]

    def _place(self, plan: CurvePlan, points: Sequence[Any], attrs: Mapping[str, Any] | None) -> None:
        """Put points in their order along the curve; where it is stuck its last point comes again."""
        self.plan, self.attrs = plan, dict(attrs or {})
        last = {(point.way, point.number): point for point in points}
        back = sorted((p for p in last.values() if p.way < 0), key=lambda p: -p.number)
        self.points = [*back, *sorted((p for p in last.values() if p.way > 0), key=lambda p: p.number)]

    @property
    def _arrays(self) -> Mapping[str, np.ndarray]:
        raise NotImplementedError

    @property
    def _scene(self) -> Any:
        """By which events are spelled."""
        raise NotImplementedError

    def _declared(self) -> list[Dataset]:
        """The datasets of its file."""
        raise NotImplementedError

    def _counts(self) -> dict[str, int]:
        """Attributes of its file that count what there is."""
        return {"points": len(self.points)}

    def _file_attributes(self, complete: bool) -> dict[str, Any]:
        """Attributes of its file that are known at the end."""
        return {**self._counts(), "complete": int(complete)}

    @property
    def _followed(self) -> bool:
        """Whether it was followed to its ends."""
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self.points)

    def keys(self) -> list[str]:
        """Names of the arrays along it."""
        return [*self._arrays]

    def __getitem__(self, name: str) -> np.ndarray:
        """An array along it, first axis the points. Raises KeyError with the names that there are."""
        if name not in self._arrays:
            raise KeyError(f"{name} is not in this {self.noun}; it has {', '.join(self._arrays)}")
        return self._arrays[name]

    @property
    def case(self) -> Any:
        return self.plan.case

    def spelled(self, word: Word) -> str:
        """A word in letters."""
        return spelled(self._scene, word)

    @cached_property
    def _orbit_arrays(self) -> dict[str, np.ndarray]:
        """Arrays of the orbit of every point."""
        names = ["parameter", "period", "state", "multipliers", "fold", "doubling", "margin", "residual"]
        return {name: np.array([getattr(p.orbit, name) for p in self.points]) for name in (*names, "drift")}

    def _file_values(self) -> dict[str, Any]:
        """Values of the datasets of its file, by name."""
        columns = columns_of(self._record, self.points, self.spelled)
        return {POINT: np.arange(len(self)), **scale_values(self.points[0]), **columns}

    def arrays(self) -> Arrays:
        """Arrays of its file, by point, special point and multiplier."""
        return Arrays.of_values(self._declared(), self._file_values(), (POINT,), self.attrs, self._shown)

    def save(self, path: str | PathLike[str], force: bool = False) -> Path:
        """Write it to an HDF5 file, which every command takes; its absolute path.

        force : replace what is there. Raises ResultFileError where it cannot be written.

        `continue_branch(..., out=path)` and `continue_locus` go on with it where it did not come to its ends.
        """
        target = check_result_output(Path(path), force)
        write_curve(target, self, self.attrs or curve_origin(self.plan), self._followed)
        return target


def write_curve(path: Path, curve: OrbitCurve, attrs: Mapping[str, Any], complete: bool) -> None:
    """Write a curve to `path`, replacing what is there in one instant. Raises ResultFileError."""
    known = {**attrs, **curve._file_attributes(complete)}
    write_hdf5(path, known, curve._declared(), curve._file_values())


# What files of branches and loci hold: attributes, datasets, and records as their rows.


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
    """Datasets of an orbit, be it a point of the branch or a special one."""

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


def curve_origin(plan: CurvePlan) -> dict[str, Any]:
    """Attributes that are known before the first point."""
    return {
        **provenance(plan.noun, plan.case, plan.title),
        f"{plan.noun}_settings_json": json.dumps(plan.settings),
        f"{plan.noun}_sha256": plan.fingerprint,
        "engine": ENGINE_NAME,
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
    """Values of the datasets of records of a kind, by name."""
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
    """The word of its letters, as `vibsim.orbits.words.spelled` writes it."""
    letters = text.split() if " " in text or text[1:].isdigit() else list(text)
    return tuple((EVENTS[one[0]], int(one[1:] or 1) - 1) for one in letters)


# A curve read from its file, to the bit.


def attributes_and_plan(
    path: Path, file: Any, declared: Sequence[Attribute], kind: Any
) -> tuple[dict[str, Any], Any]:
    """Attributes and plan of a file, checked."""
    attrs = read_attributes(path, file, declared)
    case, name = stored_case(path, attrs), f"{kind.noun}_settings_json"
    with understood(path, f"the attribute {name} makes no sense"):
        return attrs, from_plain(kind, json.loads(attrs[name]), case=case)


def points_on_file(kind: Any, values: Mapping[str, Any], count: int) -> list[Any]:
    """The points on file. Raises ValueError where the start is not among them."""
    points = [record_of(kind, values, i) for i in range(count)]
    if not any(point.number == 0 for point in points):
        raise ValueError("no start")
    return points


Walked = TypeVar("Walked", bound=Any)  # a point with its way and its number on it
Other = TypeVar("Other", bound=Any)  # the same, as it waits in a journal
C = TypeVar("C", bound=OrbitCurve)


def in_order(points: Iterable[Walked]) -> list[Walked]:
    """Points of a file, where they stand along the branch, in the order in which they were made."""
    return sorted(points, key=lambda point: (-point.way, point.number))


def follow_up(points: Iterable[Walked], waiting: Iterable[Other]) -> list[Other]:
    """Waiting records, as far as each is the next one of its path behind the points that are known: none that
    is known, nor what stands behind a damaged record.
    """
    last: dict[int, int] = {}
    for point in points:
        last[point.way] = max(point.number, last.get(point.way, 0))
    follows = []
    for record in waiting:
        if record.number == last.get(record.way, 0 if last else -1) + 1:
            last[record.way] = record.number
            follows.append(record)
    return follows


# Where the points of a curve go while it is followed.


class CurveStore(Store[R], Generic[R, C]):
    """Points of a curve in the order in which they come."""

    most: int  # points, unless told otherwise
    stored: Callable[[Any], C]  # the curve in a file as it stands there

    @classmethod
    def read(cls, path: str | Path) -> C:
        """The curve in a file, with the points that wait in its journal. Raises ResultFileError."""
        waiting, there = Waiting(path), cls.stored(path)
        follows: list[Any] = follow_up(there.points, waiting.records(there.plan.fingerprint, cls.record))
        if not follows:
            return there
        store = cls(there.plan)
        store.take_curve(there)
        for record in follows:
            store.take(record)
        whole = store.curve
        whole.attrs = {**there.attrs, **whole._counts()}
        return whole

    def origin(self) -> dict[str, Any]:
        return curve_origin(self.plan)

    def write(self, path: Path) -> None:
        write_curve(path, self.curve, self.attrs, self.complete)

    def make_memory(self) -> None:
        self.points: list[Any] = []

    @property
    def curve(self) -> C:
        """The curve as far as it is known."""
        raise NotImplementedError

    def trace(self, most: int, watch: Watch | None) -> bool:
        """Follow what is missing, up to so many points; whether that came to an end."""
        raise NotImplementedError

    def take_stored(self) -> dict[str, Any]:
        there = type(self).stored(self.shown)
        if there.plan.fingerprint != self.plan.fingerprint:
            kept = f"holds another {self.what}; kept (force=True replaces it)"
            raise ResultFileError(f"{self.shown}: {kept}{self.difference(there)}")
        self.take_curve(there)
        return there.attrs

    def take_curve(self, there: C) -> None:
        """Take over the points of the curve on file."""
        self.points = in_order(there.points)

    def difference(self, there: C) -> str:
        """In what the curve on file differs, as the end of a message."""
        return ""

    def following(self, waiting: Iterable[R]) -> Iterable[R]:
        return follow_up(self.points, waiting)

    @property
    def has_file(self) -> bool:
        return bool(self.points)


def complete(
    store: CurveStore[Any, C], most: int | None = None, watch: Watch | None = None
) -> tuple[C, bool]:
    """Follow what a store lacks of its branch or locus; that, and whether it came to an end."""
    with store:
        store.complete = store.trace(most or store.most, watch)
    return store.curve, store.complete

"""Branches and loci read back from their HDF5 files, to the bit, and their stores while they are followed."""

import json
from collections.abc import Iterable
from itertools import chain, starmap
from pathlib import Path
from typing import Any, Generic, TypeVar

from vibsim.orbits.branches.branch import Branch
from vibsim.orbits.branches.file_structure import (
    ATTRIBUTES,
    BRANCH_KIND,
    KINDS,
    LOCUS_ATTRIBUTES,
    LOCUS_KIND,
    POINT,
    SPECIAL,
    branch_origin,
    datasets_of,
    kind_counts,
    locus_datasets,
    locus_origin,
    write_branch,
    write_locus,
)
from vibsim.orbits.branches.locus_result import MOST_POINTS as MOST_LOCUS_POINTS
from vibsim.orbits.branches.locus_result import Locus, LocusPlan, LocusRecord, trace_locus
from vibsim.orbits.branches.plan import BranchPlan
from vibsim.orbits.branches.tracing import (
    MOST_POINTS,
    BranchStep,
    OrbitRecord,
    PointRecord,
    SpecialRecord,
    Watch,
    trace,
)
from vibsim.orbits.coordinates import LETTERS, Word
from vibsim.results.hdf5_reading import (
    ResultFileError,
    opened,
    read_attributes,
    read_datasets,
    stored_case,
    understood,
)
from vibsim.results.plain_data import from_plain
from vibsim.results.store import R, Store, Waiting

KIND_NAMES = {code: kind for kind, code in KINDS.items()}
Walked = TypeVar("Walked", bound=Any)  # a point with its way and its number on it
Other = TypeVar("Other", bound=Any)  # the same, as it waits in a journal
C = TypeVar("C", Branch, Locus)
EVENTS = {letter: kind for kind, letter in LETTERS.items()}


def read_branch(path: str | Path) -> Branch:
    """The branch in a file, in which everything has been checked, with the points that wait in its journal.

    Raises ResultFileError.
    """
    waiting, branch = Waiting(path), stored_branch(path)
    points, specials = branch.records
    follows = follow_up(points, waiting.records(branch.plan.fingerprint, BranchStep))
    if not follows:
        return branch
    points = [*in_order(points), *(step.point for step in follows)]
    specials = [*specials, *chain.from_iterable(step.specials for step in follows)]
    whole = Branch(branch.plan, points, specials)
    return Branch(branch.plan, points, specials, {**branch.attrs, **kind_counts(whole)})


def stored_branch(path: str | Path) -> Branch:
    """The branch in a file as it stands there. Raises ResultFileError."""
    path = Path(path)
    with opened(path, BRANCH_KIND) as file:
        attrs = read_attributes(path, file, ATTRIBUTES)
        plan = _plan(path, attrs)
        lengths = {POINT: attrs["points"], SPECIAL: attrs["special_points"]}
        values = read_datasets(path, file, datasets_of(plan.unit), lengths)
    with understood(path, "its points make no sense"):
        points = [_branch_point(values, i) for i in range(attrs["points"])]
        specials = [_special(values, i) for i in range(attrs["special_points"])]
        branch = Branch(plan, points, sorted(specials, key=lambda one: (-one.way, one.number)), attrs)
        if not points or not any(point.number == 0 for point in points):
            raise ValueError("no start")
        len(branch.specials)
    return branch


def in_order(points: Iterable[Walked]) -> list[Walked]:
    """Points of a file, where they stand along the branch, in the order in which they were made."""
    return sorted(points, key=lambda point: (-point.way, point.number))


def follow_up(points: Iterable[Walked], waiting: Iterable[Other]) -> list[Other]:
    """What waits as far as each is the next one of its way behind the points that are known: none that is
    known, nor what stands behind a damaged record.
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


def _plan(path: Path, attrs: dict[str, Any]) -> BranchPlan:
    case = stored_case(path, attrs)
    with understood(path, "the attribute branch_settings_json makes no sense"):
        plan: BranchPlan = from_plain(BranchPlan, json.loads(attrs["branch_settings_json"]), case=case)
        return plan


def _branch_point(values: dict[str, Any], i: int) -> PointRecord:
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
    """The word of its letters, as `vibsim.orbits.coordinates.spelled` writes it."""
    letters = text.split() if " " in text or text[1:].isdigit() else list(text)
    return tuple((EVENTS[one[0]], int(one[1:] or 1) - 1) for one in letters)


def read_locus(path: str | Path) -> Locus:
    """The locus in a file, in which everything has been checked, with the points that wait in its journal.

    Raises ResultFileError.
    """
    waiting, locus = Waiting(path), stored_locus(path)
    records = waiting.records(locus.plan.fingerprint, LocusRecord)
    points = [*locus.points, *follow_up(locus.points, records)]
    return Locus(locus.plan, points, {**locus.attrs, "points": len(points)})


def stored_locus(path: str | Path) -> Locus:
    """The locus in a file as it stands there. Raises ResultFileError."""
    path = Path(path)
    with opened(path, LOCUS_KIND) as file:
        attrs = read_attributes(path, file, LOCUS_ATTRIBUTES)
        case = stored_case(path, attrs)
        with understood(path, "the attribute locus_settings_json makes no sense"):
            plan = from_plain(LocusPlan, json.loads(attrs["locus_settings_json"]), case=case)
        declared = locus_datasets(plan.branch.unit, plan.unit)
        values = read_datasets(path, file, declared, {POINT: attrs["points"]})
    with understood(path, "its points make no sense"):
        points = [_locus_point(values, i) for i in range(attrs["points"])]
        if not any(point.number == 0 for point in points):
            raise ValueError("no start")
        return Locus(plan, points, attrs)


def _locus_point(values: dict[str, Any], i: int) -> LocusRecord:
    z, tangent = places_of("", values, i)
    return LocusRecord(
        int(values["way"][i]),
        int(values["number"][i]),
        orbit_of("", values, i),
        float(values["second"][i]),
        int(values["index"][i]),
        z,
        tangent,
        float(values["step"][i]),
        str(values["ended"][i]),
    )


# Where the points of a branch or a locus go while it is followed.


class CurveStore(Store[R], Generic[R, C]):
    """Points of a curve in the order in which they come."""

    most: int  # points, unless told otherwise

    def make_memory(self) -> None:
        self.points: list[Any] = []

    @property
    def curve(self) -> C:
        """What there is of it."""
        raise NotImplementedError

    def trace(self, most: int, watch: Watch | None) -> bool:
        """Follow what is missing, up to so many points; whether that came to an end."""
        raise NotImplementedError

    def stored(self) -> C:
        """The curve in the file as it stands there."""
        raise NotImplementedError

    def take_stored(self) -> dict[str, Any]:
        there = self.stored()
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


class BranchStore(CurveStore[BranchStep, Branch]):
    """Points of a branch, and its special points."""

    what, record, most = "branch", BranchStep, MOST_POINTS

    def make_memory(self) -> None:
        super().make_memory()
        self.specials: list[SpecialRecord] = []

    def origin(self) -> dict[str, Any]:
        return branch_origin(self.plan, self.engine)

    def take(self, record: BranchStep) -> None:
        self.points.append(record.point)
        self.specials += record.specials

    def stored(self) -> Branch:
        return stored_branch(self.shown)

    def take_curve(self, there: Branch) -> None:
        super().take_curve(there)
        self.specials = there.records[1]

    def difference(self, there: Branch) -> str:
        ours, theirs = self.plan.settings, there.plan.settings
        named = [name for name in ours if ours[name] != theirs[name]]
        named += ["case"] if there.case.sha256 != self.plan.case.sha256 else []
        return f". It differs in {', '.join(named)}"

    def write(self, path: Path) -> None:
        write_branch(path, self.curve, self.attrs, self.complete)

    @property
    def curve(self) -> Branch:
        return Branch(self.plan, self.points, self.specials, self.attrs)

    def trace(self, most: int, watch: Watch | None) -> bool:
        return trace(self.plan, self, most, self.engine, watch)


class LocusStore(CurveStore[LocusRecord, Locus]):
    """Points of a locus."""

    what, record, most = "locus", LocusRecord, MOST_LOCUS_POINTS

    def origin(self) -> dict[str, Any]:
        return locus_origin(self.plan, self.engine)

    def take(self, record: LocusRecord) -> None:
        self.points.append(record)

    def stored(self) -> Locus:
        return stored_locus(self.shown)

    def write(self, path: Path) -> None:
        write_locus(path, self.curve, self.attrs, self.complete)

    @property
    def curve(self) -> Locus:
        return Locus(self.plan, self.points, self.attrs)

    def trace(self, most: int, watch: Watch | None) -> bool:
        return trace_locus(self.plan, self, most, self.engine, watch)

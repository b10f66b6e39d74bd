"""Branches and loci read back from their HDF5 files, to the bit, and their stores while they are followed."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Generic, TypeVar

from vibsim.orbits.branches.branch import Branch
from vibsim.orbits.branches.curve import (
    ATTRIBUTES,
    LOCUS_ATTRIBUTES,
    POINT,
    SPECIAL,
    counts_of,
    curve_origin,
    datasets_of,
    locus_datasets,
    record_of,
    write_curve,
)
from vibsim.orbits.branches.locus_result import MOST_POINTS as MOST_LOCUS_POINTS
from vibsim.orbits.branches.locus_result import Locus, LocusPlan, LocusRecord, trace_locus
from vibsim.orbits.branches.plan import BranchPlan
from vibsim.orbits.branches.tracing import MOST_POINTS, BranchStep, PointRecord, SpecialRecord, Watch, trace
from vibsim.results.file_contents import Attribute
from vibsim.results.hdf5_reading import (
    ResultFileError,
    opened,
    read_attributes,
    read_datasets,
    stored_case,
    understood,
)
from vibsim.results.store import R, Store, Waiting, from_plain

Walked = TypeVar("Walked", bound=Any)  # a point with its way and its number on it
Other = TypeVar("Other", bound=Any)  # the same, as it waits in a journal
C = TypeVar("C", Branch, Locus)


def read_branch(path: str | Path) -> Branch:
    """The branch in a file, in which everything has been checked, with the points that wait in its journal.

    Raises ResultFileError.
    """
    return BranchStore.read(path)


def read_locus(path: str | Path) -> Locus:
    """The locus in a file, in which everything has been checked, with the points that wait in its journal.

    Raises ResultFileError.
    """
    return LocusStore.read(path)


def stored_branch(path: str | Path) -> Branch:
    """The branch in a file as it stands there. Raises ResultFileError."""
    path = Path(path)
    with opened(path, "branch") as file:
        attrs, plan = _plan(path, file, ATTRIBUTES, BranchPlan)
        lengths = {POINT: attrs["points"], SPECIAL: attrs["special_points"]}
        values = read_datasets(path, file, datasets_of(plan.unit), lengths)
    with understood(path, "its points make no sense"):
        points = _points(PointRecord, values, attrs["points"])
        specials = [record_of(SpecialRecord, values, i, "special_") for i in range(attrs["special_points"])]
        branch = Branch(plan, points, in_order(specials), attrs)
        len(branch.specials)
    return branch


def stored_locus(path: str | Path) -> Locus:
    """The locus in a file as it stands there. Raises ResultFileError."""
    path = Path(path)
    with opened(path, "locus") as file:
        attrs, plan = _plan(path, file, LOCUS_ATTRIBUTES, LocusPlan)
        declared = locus_datasets(plan.branch.unit, plan.unit)
        values = read_datasets(path, file, declared, {POINT: attrs["points"]})
    with understood(path, "its points make no sense"):
        return Locus(plan, _points(LocusRecord, values, attrs["points"]), attrs)


def _plan(path: Path, file: Any, declared: Sequence[Attribute], kind: Any) -> tuple[dict[str, Any], Any]:
    """Attributes and plan of a file, checked."""
    attrs = read_attributes(path, file, declared)
    case, name = stored_case(path, attrs), f"{kind.noun}_settings_json"
    with understood(path, f"the attribute {name} makes no sense"):
        return attrs, from_plain(kind, json.loads(attrs[name]), case=case)


def _points(kind: Any, values: Mapping[str, Any], count: int) -> list[Any]:
    """The points on file. Raises ValueError where the start is not among them."""
    points = [record_of(kind, values, i) for i in range(count)]
    if not any(point.number == 0 for point in points):
        raise ValueError("no start")
    return points


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


# Where the points of a branch or a locus go while it is followed.


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
        whole.attrs = {**there.attrs, **counts_of(whole)}
        return whole

    def origin(self) -> dict[str, Any]:
        return curve_origin(self.plan, self.engine)

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


class BranchStore(CurveStore[BranchStep, Branch]):
    """Points of a branch, and its special points."""

    what, record, most = "branch", BranchStep, MOST_POINTS
    stored = staticmethod(stored_branch)

    def make_memory(self) -> None:
        super().make_memory()
        self.specials: list[SpecialRecord] = []

    def take(self, record: BranchStep) -> None:
        self.points.append(record.point)
        self.specials += record.specials

    def take_curve(self, there: Branch) -> None:
        super().take_curve(there)
        self.specials = there.records[1]

    def difference(self, there: Branch) -> str:
        ours, theirs = self.plan.settings, there.plan.settings
        named = [name for name in ours if ours[name] != theirs[name]]
        named += ["case"] if there.case.sha256 != self.plan.case.sha256 else []
        return f". It differs in {', '.join(named)}"

    @property
    def curve(self) -> Branch:
        return Branch(self.plan, self.points, self.specials, self.attrs)

    def trace(self, most: int, watch: Watch | None) -> bool:
        return trace(self.plan, self, most, self.engine, watch)


class LocusStore(CurveStore[LocusRecord, Locus]):
    """Points of a locus."""

    what, record, most = "locus", LocusRecord, MOST_LOCUS_POINTS
    stored = staticmethod(stored_locus)

    def take(self, record: LocusRecord) -> None:
        self.points.append(record)

    @property
    def curve(self) -> Locus:
        return Locus(self.plan, self.points, self.attrs)

    def trace(self, most: int, watch: Watch | None) -> bool:
        return trace_locus(self.plan, self, most, self.engine, watch)

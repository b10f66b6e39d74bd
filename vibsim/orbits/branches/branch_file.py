"""Branches and loci read back from their HDF5 files, to the bit; the store of a locus under way."""

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from itertools import chain, starmap
from pathlib import Path
from typing import Any, TypeVar

from vibsim.orbits.branches.branch import Branch
from vibsim.orbits.branches.file_structure import (
    ATTRIBUTES,
    BRANCH_KIND,
    KINDS,
    LOCUS_ATTRIBUTES,
    LOCUS_KIND,
    POINT,
    SPECIAL,
    datasets_of,
    kind_counts,
    locus_datasets,
    locus_origin,
    write_locus,
)
from vibsim.orbits.branches.locus_result import MOST_POINTS, Locus, LocusPlan, LocusRecord, trace_locus
from vibsim.orbits.branches.plan import BranchPlan
from vibsim.orbits.branches.tracing import (
    OrbitRecord,
    PointRecord,
    SpecialRecord,
    plain_orbit,
    read_orbit,
    read_record,
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
from vibsim.results.journal import Journal, Waiting
from vibsim.results.output_files import check_leftover, check_result_output

KIND_NAMES = {code: kind for kind, code in KINDS.items()}
Walked = TypeVar("Walked", bound=Any)  # a point with its way and its number on it
Others = TypeVar("Others")
EVENTS = {letter: kind for kind, letter in LETTERS.items()}


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


# A locus as an HDF5 file, and where its points go while it is followed.


def read_locus(path: str | Path) -> Locus:
    """The locus in a file, in which everything has been checked, with the points that wait in its journal.

    Raises ResultFileError.
    """
    waiting, locus = Waiting(path), stored_locus(path)
    records = map(read_point, waiting.records(locus.plan.fingerprint))
    follows = follow_up(locus.points, ((point, None) for point in records))
    points = [*locus.points, *(point for point, _ in follows)]
    return Locus(locus.plan, points, {**locus.attrs, "points": len(points)})


def stored_locus(path: str | Path) -> Locus:
    """The locus in a file as it stands there. Raises ResultFileError."""
    path = Path(path)
    with opened(path, LOCUS_KIND) as file:
        attrs = read_attributes(path, file, LOCUS_ATTRIBUTES)
        case = stored_case(path, attrs)
        with understood(path, "the attribute locus_settings_json makes no sense"):
            plan = LocusPlan.from_settings(case, json.loads(attrs["locus_settings_json"]))
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


def plain(point: LocusRecord) -> dict[str, Any]:
    """A point as plain data for JSON."""
    return {**vars(point), "orbit": plain_orbit(point.orbit)}


def read_point(data: dict[str, Any]) -> LocusRecord:
    """The point that `plain` wrote down."""
    places = {name: tuple(data[name]) for name in ("unknowns", "tangent")}
    return LocusRecord(**{**data, **places, "orbit": read_orbit(data["orbit"])})


class LocusStore:
    """Points of a locus, kept in the journal of its file as they come; goes on from what is there.

    Raises ResultFileError where the file holds anything else (unless `force`) or cannot be written.
    """

    def __init__(
        self, plan: LocusPlan, path: str | Path | None = None, engine: str = "auto", force: bool = False
    ):
        self.plan, self.engine, self.points = plan, engine, list[LocusRecord]()
        self.notes: list[str] = []
        self.attrs = locus_origin(plan, engine)
        self.path = None if path is None else check_result_output(path, force=True)
        if path is not None:
            check_leftover(path, force)
        self._on_file = (0, False)  # points, and whether they are all
        self._journal = None if self.path is None else Journal(self.path, "locus", path or "")
        if self._journal is not None:
            try:
                self._go_on(path, force)
            except BaseException:
                self._journal.close(remove=False)
                raise

    def _go_on(self, shown: Any, force: bool) -> None:
        assert self.path is not None and self._journal is not None
        if force:
            self._journal.restart(self.plan.fingerprint)
            return
        if self.path.exists():
            there = stored_locus(shown)
            if there.plan.fingerprint != self.plan.fingerprint:
                raise ResultFileError(f"{shown}: holds another locus; kept (force=True replaces it)")
            self.points = in_order(there.points)
            self.attrs["date_created"] = there.attrs["date_created"]
            self._on_file = (len(self.points), bool(there.attrs["complete"]))
        waiting = list(self._journal.read(self.plan.fingerprint))
        records = ((read_point(each), None) for each in waiting)
        self.points += [point for point, _ in follow_up(self.points, records)]
        self.notes += self._journal.notes()
        self._journal.go_on(self.plan.fingerprint, waiting)

    def _add(self, point: LocusRecord) -> None:
        self.points.append(point)
        if self._journal is not None:
            self._journal.add([plain(point)])
            if self._on_file == (0, False):  # with the first point the file is made, which holds the plan
                with suppress(ResultFileError):  # the journal has it; what is wrong is told at the end
                    self._write(False)

    def complete(self, most: int = MOST_POINTS, watch: Any = None) -> tuple[Locus, bool]:
        """Follow what is missing; the locus, and whether that came to an end."""
        finished = False
        try:
            finished = trace_locus(self.plan, self._add, self.points, most, self.engine, watch)
        finally:
            self._close(finished)
        return self.locus, finished

    def _close(self, finished: bool) -> None:
        if self._journal is None or self.path is None:
            return
        published = False
        try:
            self._write(finished)
            published = True
        except ResultFileError as failure:
            raise self._journal.kept_after(failure) from failure
        finally:
            self._journal.close(remove=published)

    def _write(self, finished: bool) -> None:
        """Write the file, unless it holds all that there is."""
        if self.path is not None and (len(self.points), finished) > self._on_file:
            write_locus(self.path, self.locus, self.attrs, finished)
            self._on_file = (len(self.points), finished)

    @property
    def locus(self) -> Locus:
        """What there is of the locus."""
        return Locus(self.plan, self.points, self.attrs)

"""A locus as an HDF5 file, and where its points go while it is followed."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.branches.loci.locus_plan import LocusPlan
from vibsim.branches.loci.locus_result import MOST_POINTS, Locus, LocusRecord, trace_locus
from vibsim.branches.store.branch_file import follow_up, in_order, orbit_of, orbit_values, places_of
from vibsim.branches.store.structure import (
    BODY,
    LOCUS_ATTRIBUTES,
    MULTIPLIER,
    POINT,
    SCALED,
    UNKNOWN,
    locus_datasets,
)
from vibsim.branches.tracing.records import plain_orbit, read_orbit
from vibsim.engine.choice import engine_name
from vibsim.files.errors import ResultFileError
from vibsim.files.journal import Journal, Waiting
from vibsim.files.output_file import check_result_output
from vibsim.files.provenance import provenance
from vibsim.files.reading import opened, read_attributes, read_datasets
from vibsim.files.stored_case import stored_case, understood
from vibsim.files.writers import check_leftover
from vibsim.files.writing import write_hdf5
from vibsim.orbits.returns.word import spelled

KIND = "locus"


def origin(plan: LocusPlan, engine: str = "auto") -> dict[str, Any]:
    """Attributes that are known before the first point."""
    title = f"{plan.kind} {plan.label} of {plan.branch.case.name} over {plan.keys[0]}"
    return {
        **provenance(KIND, plan.branch.case, title),
        "locus_settings_json": json.dumps(plan.settings),
        "locus_sha256": plan.fingerprint,
        "engine": engine_name(engine),
    }


def write_locus(path: Path, locus: Locus, attrs: dict[str, Any], complete: bool) -> None:
    """Write a locus to `path`, replacing what is there in one instant. Raises ResultFileError."""
    counts = {"points": len(locus), "complete": int(complete)}
    declared = locus_datasets(locus.plan.branch.unit, locus.plan.unit)
    write_hdf5(path, {**attrs, **counts}, declared, values_of(locus))


def values_of(locus: Locus) -> dict[str, Any]:
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
    with opened(path, KIND) as file:
        attrs = read_attributes(path, file, LOCUS_ATTRIBUTES)
        case = stored_case(path, attrs)
        with understood(path, "the attribute locus_settings_json makes no sense"):
            plan = LocusPlan.from_settings(case, json.loads(attrs["locus_settings_json"]))
        declared = locus_datasets(plan.branch.unit, plan.unit)
        values = read_datasets(path, file, declared, {POINT: attrs["points"]})
    with understood(path, "its points make no sense"):
        points = [_point(values, i) for i in range(attrs["points"])]
        if not any(point.number == 0 for point in points):
            raise ValueError("no start")
        return Locus(plan, points, attrs)


def _point(values: dict[str, Any], i: int) -> LocusRecord:
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
        self.attrs = origin(plan, engine)
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

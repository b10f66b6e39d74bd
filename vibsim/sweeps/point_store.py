"""Where the points of a running sweep are kept: in memory and the journal at once, on file now and then."""

import json
import time
from collections.abc import Iterator, Mapping
from functools import partial
from math import fsum, isnan
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from vibsim.cases import Case
from vibsim.engine.choice import engine_name, flow_of
from vibsim.results.file_contents import provenance
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.journal import Journal as Records
from vibsim.results.journal import journal_path as journal_path
from vibsim.results.output_files import check_leftover, check_result_output
from vibsim.sweeps.axes import axis_from_plain
from vibsim.sweeps.points import SweepPoint, Table
from vibsim.sweeps.quantities import DEFINITIONS, DONE, FAILED
from vibsim.sweeps.sweep_file import read_column, read_sweep, write_sweep
from vibsim.sweeps.sweep_plan import SweepPlan, check_memory

LEAST_PAUSE = 10.0  # seconds between two writings of the HDF5 file while points come in
LARGEST_SHARE = 0.02  # of the time that writing it may take


class Store:
    """The points of one sweep. `table` holds them; `add` takes more."""

    def __init__(self, plan: SweepPlan, engine: str = "auto"):
        check_memory(plan)
        self.plan = plan
        self.attrs: dict[str, Any] = origin(plan, engine)
        self.table = Table(plan)
        self.notes: list[str] = []  # what the user should know of what was there before

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        pass

    def make_room(self, count: int) -> None:
        """Make sure that so many more points can be kept, before they are computed."""

    def add(self, points: list[SweepPoint]) -> None:
        """Keep points."""
        for point in points:
            self.table.put(point)

    @property
    def all_attrs(self) -> dict[str, Any]:
        """The attributes that a file written now would have."""
        return {**self.attrs, **outcome(self.table)}


class FileStore(Store):
    """A store on file: goes on from what the file and its journal hold, and keeps every point from then on.

    Used as a context manager. At its end, whatever ended it, the file holds all points and the journal is
    gone. Raises ResultFileError when the file holds another sweep or anything else (unless `force`), when
    another process writes it, or when it cannot be written.
    """

    def __init__(self, plan: SweepPlan, path: str | Path, engine: str = "auto", force: bool = False):
        super().__init__(plan, engine)
        self.path = check_result_output(path, force=True)
        check_leftover(path, force)
        self._shown = path
        self._record_bytes = record_bytes(plan)
        self._journal = PointJournal(self.path, shown=path)
        self._next = 0.0  # when the file is written next
        self._on_file = False  # whether the file holds all that the table holds
        try:
            if not force:
                self._go_on()
        except BaseException:
            self._journal.close(remove=False)
            raise

    def _go_on(self) -> None:
        """Take over what the file and the journal hold; they must be of this sweep."""
        if self.path.exists():
            attrs, _, file = read_sweep(Path(self._shown))
            with file:
                self._refuse(differences(self.plan, attrs))
                self.table.fill(partial(read_column, Path(self._shown), file, self.plan))
            self.attrs["date_created"] = attrs["date_created"]
            self._on_file = True
        for point in self._journal.read(self.plan.fingerprint):
            self.table.put(point)
            self._on_file = False
        self.notes += self._journal.notes()

    def _refuse(self, differences: list[str]) -> None:
        if differences:
            listed = "\n  ".join(differences)
            raise ResultFileError(
                f"{self._shown}: holds another sweep; kept (force=True replaces it)."
                f" It differs in\n  {listed}"
            )

    def __enter__(self) -> "FileStore":
        try:
            self._publish()
        except BaseException:
            self._journal.close(remove=False)
            raise
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        published = False
        try:
            self._journal.give_back()
            self._publish()
            published = True
        except ResultFileError as failure:
            raise self._journal.kept_after(failure) from failure
        finally:
            self._journal.close(remove=published)

    def make_room(self, count: int) -> None:
        """As above. Raises ResultFileError when the disk is full."""
        if not self._journal.reserve(count * self._record_bytes):
            done = self.table.count(DONE)
            held = (
                f"it holds {done} points, and the same command goes on from there"
                if done
                else "no point was done"
            )
            raise ResultFileError(f"{self._shown}: disk full; {held}")

    def add(self, points: list[SweepPoint]) -> None:
        """Keep points. The journal has them even where there is no room for the file beside its old self."""
        super().add(points)
        self._on_file = False
        self._journal.add(points)
        if time.monotonic() >= self._next:
            try:
                self._publish()
            except ResultFileError:
                self._next = time.monotonic() + LEAST_PAUSE

    def _publish(self) -> None:
        """Write the file anew if need be; then the journal, whose points are in it, begins anew."""
        began = time.monotonic()
        if not self._on_file:
            write_sweep(self.path, self.plan, self.table, self.all_attrs)
        self._on_file = True
        self._journal.restart(self.plan.fingerprint)
        ended = time.monotonic()
        self._next = ended + max(LEAST_PAUSE, (ended - began) / LARGEST_SHARE)


# The journal of a sweep: finished points, as they come.


NUMBER = 60  # bytes of a number and its name
TEXTS = 1500  # bytes of place, fingerprint and the reason of a failure


class PointJournal(Records):
    """A journal whose records are points."""

    def __init__(self, target: Path, what: str = "sweep", shown: str | Path = ""):
        super().__init__(target, what, shown)

    def _plain(self, point: SweepPoint) -> dict[str, Any]:
        """A point as plain data. Arrays are the hex digits of their doubles, which is five times as fast as
        decimals.
        """
        return {
            **vars(point),
            "arrays": {name: array.astype("<f8").tobytes().hex() for name, array in point.arrays.items()},
        }

    def _from_plain(self, plain: dict[str, Any]) -> SweepPoint:
        return point_from(plain)


def point_from(plain: dict[str, Any]) -> SweepPoint:
    """The point that a journal wrote down."""
    arrays = {name: np.frombuffer(bytes.fromhex(digits), "<f8") for name, digits in plain["arrays"].items()}
    return SweepPoint(**{**plain, "index": tuple(plain["index"]), "arrays": arrays})


def record_bytes(plan: SweepPlan) -> int:
    """Room that one point takes at most, about [bytes]."""
    further = [name for name, column in plan.columns.items() if column.dimension]
    doubles = sum(plan.shape_of(name)[-1] for name in further)
    return 2 * 8 * doubles + NUMBER * len(plan.columns) + TEXTS


# The root attributes of a sweep file: what was swept, how, by what, and what came of it.


def origin(plan: SweepPlan, engine: str) -> dict[str, Any]:
    """Attributes that are known before the first point."""
    case, scene = plan.case, plan.case.scene()
    attrs: dict[str, Any] = {
        **provenance("sweep", case),
        "sweep_settings_json": json.dumps(plan.settings),
        "sweep_sha256": plan.fingerprint,
        "definitions": DEFINITIONS,
        "method": flow_of(scene),
        "engine": engine_name(engine),
    }
    if attrs["method"] == "taylor":
        attrs |= {"taylor_order": scene.order, "taylor_tolerance": float(scene.tol)}
    return attrs


def outcome(table: Table) -> dict[str, Any]:
    """Attributes of what came of the sweep so far; wall_time_s adds up the points."""
    times = table.numbers["wall_time"].ravel().tolist()
    return {
        "complete": int(table.complete),
        "points": table.status.size,
        "points_done": table.count(DONE),
        "points_failed": table.count(FAILED),
        "wall_time_s": fsum(value for value in times if not isnan(value)),
    }


# What keeps a file from being continued: how the sweep in it differs from the one that is wanted.


AT_MOST = 12  # lines; a sweep of another model differs in everything


def differences(plan: SweepPlan, attrs: Mapping[str, Any]) -> list[str]:
    """Lines `what: in the file X, here Y`; empty for the same sweep.

    attrs : root attributes of the file
    """
    if attrs.get("sweep_sha256") == plan.fingerprint:
        return []
    stored = json.loads(attrs["sweep_settings_json"])
    listed = [*_settings(stored, plan.settings), *_cases(attrs["case_resolved_json"], plan, stored["axes"])]
    more = len(listed) - AT_MOST
    return [*listed[:AT_MOST], *([f"and {more} more"] if more > 0 else [])]


def _settings(stored: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[str]:
    axes = [{axis["key"]: axis for axis in side["axes"]} for side in (stored, settings)]
    for key in dict.fromkeys([*axes[1], *axes[0]]):
        yield from _line(key, *(_axis(side.get(key)) for side in axes))
    if set(axes[0]) == set(axes[1]):
        yield from _line("order of the axes", *map(", ".join, axes))
    for name in dict.fromkeys([*settings, *stored]):
        if name != "axes":
            yield from _line(name.replace("_", " "), *(_words(side.get(name)) for side in (stored, settings)))


def _cases(resolved: str, plan: SweepPlan, stored_axes: list[dict[str, Any]]) -> Iterator[str]:
    """Values that no axis of either sweep varies and that are not the same number."""
    theirs, ours = Case.from_resolved_json(resolved), plan.case
    stored = {key for axis in stored_axes for key in axis_from_plain(axis).keys}
    swept = {key for axis in plan.axes for key in axis.keys} | stored | {"name", "title"}
    exact = [_exact_values(case) for case in (theirs, ours)]
    for key in dict.fromkeys([*ours.values, *theirs.values]):
        if key not in swept and exact[0].get(key) != exact[1].get(key):
            yield from _line(key, *(str(case.values.get(key, "absent")) for case in (theirs, ours)))


def _exact_values(case: Case) -> dict[str, Any]:
    return {
        key: (value.value, value.per_turn) if hasattr(value, "per_turn") else value
        for key, value in case.values.items()
    }


def _line(what: str, stored: str, planned: str) -> Iterator[str]:
    if stored != planned:
        yield f"{what}: in the file {stored}, here {planned}"


def _axis(axis: Mapping[str, Any] | None) -> str:
    if axis is None:
        return "not swept"
    if "seed" in axis:
        return str(axis_from_plain(axis))
    read = axis_from_plain(axis)
    values = [read.text(i).removesuffix(read.unit).strip() for i in _few(len(read))]
    text = ", ".join(values if len(read) <= 3 else [*values[:2], f"... {values[2]}"])
    return f"{text} {read.unit}".strip() + f" ({len(read)} values)"


def _few(count: int) -> list[int]:
    return list(range(count)) if count <= 3 else [0, 1, count - 1]


def _words(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, list):
        return " and ".join(map(str, value))
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)

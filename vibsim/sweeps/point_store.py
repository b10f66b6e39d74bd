"""Where the points of a running sweep are kept: in memory and the journal at once, on file now and then."""

import json
from collections.abc import Iterator, Mapping
from functools import partial
from math import fsum, isnan
from pathlib import Path
from typing import Any

from vibsim.cases import Case
from vibsim.engine.choice import engine_name, flow_of
from vibsim.results.file_contents import provenance
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.store import Store
from vibsim.sweeps.axes import axis_from_plain
from vibsim.sweeps.points import SweepPoint, Table
from vibsim.sweeps.quantities import DEFINITIONS, DONE, FAILED
from vibsim.sweeps.sweep_file import read_column, read_sweep, write_sweep
from vibsim.sweeps.sweep_plan import SweepPlan, check_memory


class SweepStore(Store[SweepPoint]):
    """The points of one sweep. `table` holds them."""

    what, record = "sweep", SweepPoint

    def make_memory(self) -> None:
        check_memory(self.plan)
        self.table = Table(self.plan)
        self._record_bytes = record_bytes(self.plan)

    def origin(self) -> dict[str, Any]:
        return origin(self.plan, self.engine)

    def take(self, record: SweepPoint) -> None:
        self.table.put(record)

    def take_stored(self) -> dict[str, Any]:
        path = Path(self.shown)
        attrs, _, file = read_sweep(path)
        with file:
            if listed := differences(self.plan, attrs):
                lines = "\n  ".join(["It differs in", *listed])
                raise ResultFileError(f"{path}: holds another sweep; kept (force=True replaces it). {lines}")
            self.table.fill(partial(read_column, path, file, self.plan))
        return attrs

    def write(self, path: Path) -> None:
        write_sweep(path, self.plan, self.table, self.all_attrs)

    @property
    def all_attrs(self) -> dict[str, Any]:
        """The attributes that a file written now would have."""
        return {**self.attrs, **outcome(self.table)}

    def make_room(self, count: int) -> None:
        """Make sure that so many more points can be kept, before they are computed. Raises ResultFileError
        when the disk is full.
        """
        if self.path is not None and not self._journal.reserve(count * self._record_bytes):
            done = self.table.count(DONE)
            held = (
                f"it holds {done} points, and the same command goes on from there"
                if done
                else "no point was done"
            )
            raise ResultFileError(f"{self.shown}: disk full; {held}")


# Room that a point takes in the journal.


NUMBER = 60  # bytes of a number and its name
TEXTS = 1500  # bytes of place, fingerprint and the reason of a failure


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

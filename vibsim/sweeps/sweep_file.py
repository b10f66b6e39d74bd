"""A sweep as an HDF5 file: written whole beside its name and renamed, so that it opens at every moment."""

import json
from collections.abc import Iterator, Mapping
from functools import partial
from math import fsum, isnan, prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from vibsim.cases import Case
from vibsim.cases.problems import counted
from vibsim.engine.trajectory import flow_of
from vibsim.results.file_contents import (
    ENGINE,
    ENGINE_NAME,
    NUMBER,
    PROVENANCE,
    TEXT,
    WHOLE,
    Attribute,
    Column,
    Dataset,
    provenance,
)
from vibsim.results.hdf5_reading import (
    ResultFileError,
    check_datasets,
    check_kind,
    check_values,
    damage_named,
    damaged,
    open_hdf5,
    read_attributes,
    read_values,
    stored_case,
    understood,
)
from vibsim.results.hdf5_writing import write_hdf5
from vibsim.results.store import Store, from_plain
from vibsim.signals import ended_at_once
from vibsim.sweeps.axes import Axis, Members, Spread, axis_from_plain
from vibsim.sweeps.contact_computations import QUANTILES
from vibsim.sweeps.points import SweepPoint, Table
from vibsim.sweeps.quantities import DEFINITIONS, DONE, FAILED, NAME, NONE, STATUS_FLAGS
from vibsim.sweeps.sweep_plan import DIRECTION_FLAGS, SweepPlan, check_memory

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.sweeps.attractors import Attractors


KIND = "sweep"
NUMBERED = ("exponent", "multiplier", "unknown", "observable")  # further dimensions that count from 1


def write_sweep(path: Path, plan: SweepPlan, table: Table, attrs: Mapping[str, Any]) -> None:
    """Write a sweep to `path`, replacing what is there in one instant. Raises ResultFileError."""
    points = {**table.numbers, "status": table.status, "sha256": table.sha256, "error": table.error}
    derived = {}
    if NAME in plan.compute:
        from vibsim.sweeps.attractors import gather, values_of_group

        found = gather(plan, table)
        names = names_of_unknowns(plan)
        derived = {NAME: found.labels, MIRRORED: found.mirrored}
        derived |= values_of_group(found, names, len(plan.case.scene().line))
    declared = [*datasets_of(plan), *group_of(plan)]
    write_hdf5(path, attrs, declared, {**coordinates(plan), **points, **derived})


def names_of_unknowns(plan: SweepPlan) -> tuple[str, ...]:
    """Names of the unknowns of the orbits of a sweep's case."""
    from vibsim.sweeps.attractor_labels import coordinates_of

    at = coordinates_of(plan.case.scene())
    return at.names if at else ()


def group_of(plan: SweepPlan) -> list[Dataset]:
    """The datasets of the group `attractors`, where the sweep has it."""
    if NAME not in plan.compute:
        return []
    from vibsim.sweeps.attractors import datasets_of_attractors

    scene = plan.case.scene()
    return datasets_of_attractors(names_of_unknowns(plan), [scene.unit_of(body) for body in scene.line])


def read_attractors(path: Path, file: h5py.File, plan: SweepPlan) -> "Attractors":
    """The attractors in the checked file of a sweep."""
    from vibsim.sweeps.attractors import COLUMNS, Attractors

    values = {}
    for declared in group_of(plan):
        with damage_named(path):
            values[declared.name.rpartition("/")[2]] = np.asarray(read_values(file, declared))
        if declared.column.dtype != "text":
            check_values(path, declared, values[declared.name.rpartition("/")[2]])
    values.setdefault("state", np.empty((len(values["kind"]), 0)))
    labels, mirrored = (np.asarray(read_column(path, file, plan, name)) for name in (NAME, MIRRORED))
    if not ((labels >= NONE) & (labels < len(values["kind"]))).all():
        raise damaged(path, f"{NAME} names attractors that are not there")
    return Attractors(labels, mirrored, {name: values[name] for name in (*COLUMNS, "state", "amplitude")})


def coordinates(plan: SweepPlan) -> dict[str, np.ndarray]:
    """The values of axes, direction and further dimensions, and what was drawn for members of an ensemble."""
    values = {name: _counted(name, plan.length_of(name)) for name in further_dimensions(plan)}
    values[DIRECTION] = np.array(plan.directions)
    for axis in plan.axes:
        values[axis.name] = axis.numbers()
        if isinstance(axis, Members):
            drawn = zip(axis.spreads, axis.drawn.values(), strict=True)
            values |= {drawn_name(axis, spread): numbers for spread, numbers in drawn}
    return values


def _counted(dimension: str, count: int) -> np.ndarray:
    """The values of a further dimension's scale."""
    if dimension == QUANTILE:
        return QUANTILES
    return np.arange(1, count + 1) if dimension in NUMBERED else np.arange(1 - count, 1)


def read_column(path: Path, file: h5py.File, plan: SweepPlan, name: str) -> np.ndarray:
    """One column of the checked file of a sweep, or its status, sha256 or error; NaN where it has no room.

    The file is read as it was when it was opened, though another may have its name by now.
    """
    declared = next((each for each in datasets_of(plan) if each.name == name), None)
    if declared is None:
        return np.full(plan.shape_of(name), np.nan)
    with damage_named(path):
        values = read_values(file, declared)
    if name not in TEXTS:
        check_values(path, declared, values)
    return np.asarray(values)


# What a sweep file holds, told from its plan.


COUNTS = ("points", "points_done", "points_failed")
ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in ("sweep_settings_json", "sweep_sha256", "method")),
    ENGINE,
    *(Attribute(name, WHOLE) for name in COUNTS),
    Attribute("complete", WHOLE, allowed=(0, 1)),
    Attribute("wall_time_s", NUMBER),
]
DIRECTION, QUANTILE = "direction", "quantile"
FURTHER_SCALES = {
    "section": Column("1", "stroboscopic points, counted back from the last", dtype="i4"),
    "contact": Column("1", "beginnings of contact, counted back from the last", dtype="i4"),
    QUANTILE: Column("1", "share of the impacts that are not faster"),
    "multiplier": Column("1", "number of the multiplier, the largest first", dtype="i4"),
    "exponent": Column("1", "number of the exponent, the largest first", dtype="i4"),
    "unknown": Column("1", "number of the unknown of the orbits", dtype="i4"),
    "observable": Column("1", "of each unknown the mean, the mean square, the mean change", dtype="i4"),
}
STATUS = Column(None, "whether the point was computed", dtype="i1", flags=STATUS_FLAGS)
MIRRORED = f"{NAME}_mirrored"
DERIVED = {  # from the labels of all points, see `vibsim.sweeps.attractors`
    NAME: Column("1", "number of its attractor; -1: undecided or not computed", dtype="i8", missing=NONE),
    MIRRORED: Column("1", "1: it ends on the mirror image of the attractor's orbit", dtype="i8"),
}
TEXTS = {
    "sha256": Column(None, "SHA-256 of the point's case", dtype="text"),
    "error": Column(None, "why a point failed", dtype="text"),
}


def datasets_of(plan: SweepPlan) -> list[Dataset]:
    """All datasets; a column that has no room for a single number is not written."""
    return [*_scales(plan), *_drawn(plan), *_of_points(plan)]


def _scales(plan: SweepPlan) -> list[Dataset]:
    """The scales of the axes, of the direction, and of further dimensions that are not empty."""
    way = Column(None, f"direction in which {plan.axes[0].name} was swept", dtype="i1", flags=DIRECTION_FLAGS)
    axes = [Dataset(axis.name, _values_of(axis), (axis.name,), gaps=True) for axis in plan.axes]
    further = [name for name in further_dimensions(plan) if plan.length_of(name)]
    return [
        *axes,
        Dataset(DIRECTION, way, (DIRECTION,)),
        *(Dataset(name, FURTHER_SCALES[name], (name,)) for name in further),
    ]


def _values_of(axis: Axis | Members) -> Column:
    key = {"key": axis.key}
    if isinstance(axis, Members):
        return Column(axis.unit or "1", "number of the member of the ensemble", dtype="i8", besides=key)
    return Column(axis.unit or "1", axis.key, besides=key)


def _drawn(plan: SweepPlan) -> list[Dataset]:
    """Datasets of the numbers drawn for each member of an ensemble."""
    drawn = [(axis, spread) for axis in plan.axes if isinstance(axis, Members) for spread in axis.spreads]
    return [
        Dataset(drawn_name(axis, spread), Column(spread.unit or "1", f"{spread.key}: {spread}"), (axis.name,))
        for axis, spread in drawn
    ]


def drawn_name(members: Members, spread: Spread) -> str:
    """Name of the dataset of what was drawn for a spread."""
    return f"{members.name}_{spread.name}"


def _of_points(plan: SweepPlan) -> list[Dataset]:
    dims = dimensions(plan)
    numbers = [
        Dataset(name, column, (*dims, *filter(None, [column.dimension])), gaps=True)
        for name, column in plan.columns.items()
        if 0 not in plan.shape_of(name)
    ]
    texts = [Dataset(name, column, dims) for name, column in TEXTS.items()]
    if NAME in plan.compute:
        numbers += [Dataset(name, column, dims) for name, column in DERIVED.items()]
    return [*numbers, Dataset("status", STATUS, dims), *texts]


def dimensions(plan: SweepPlan) -> tuple[str, ...]:
    """Names of the dimensions of a number per point."""
    return (*(axis.name for axis in plan.axes), DIRECTION)


def further_dimensions(plan: SweepPlan) -> list[str]:
    """Names of the dimensions that only some columns have."""
    return list(dict.fromkeys(column.dimension for column in plan.columns.values() if column.dimension))


def lengths_of(plan: SweepPlan) -> dict[str, int]:
    """Length of every dimension, by name."""
    return {
        **dict(zip(dimensions(plan), plan.shape, strict=True)),
        **{dimension: plan.length_of(dimension) for dimension in further_dimensions(plan)},
    }


# The plan in a sweep file, and the check of the file against it.


SETTINGS = "the attribute sweep_settings_json"


@ended_at_once()
def read_sweep(path: Path) -> tuple[dict[str, Any], SweepPlan, h5py.File]:
    """Root attributes and plan of a sweep file, the file checked and left open. Raises ResultFileError."""
    file = open_hdf5(path)
    try:
        with damage_named(path):
            check_kind(path, file, KIND)
            return *_checked(path, file), file
    except BaseException:
        file.close()
        raise


def _checked(path: Path, file: h5py.File) -> tuple[dict[str, Any], SweepPlan]:
    attrs = read_attributes(path, file, ATTRIBUTES)
    settings = _settings(path, attrs)
    _check_count(path, file, settings["axes"])
    case = stored_case(path, attrs)
    with understood(path, f"{SETTINGS} describes no sweep of its case"):
        if not isinstance(settings["section"], int) or settings["section"] < 0:
            raise ValueError("section")
        plan = from_plain(SweepPlan, settings, case=case)
        _check_axes(case, plan)
    check_datasets(path, file, [*datasets_of(plan), *group_of(plan)], lengths_of(plan))
    _check_scales(path, file, plan)
    if attrs["points"] != plan.count or not all(0 <= attrs[name] <= plan.count for name in COUNTS):
        raise damaged(path, f"the attribute points is {attrs['points']}, and its axes have {plan.count}")
    return attrs, plan


def _settings(path: Path, attrs: Mapping[str, Any]) -> Mapping[str, Any]:
    """The settings as plain data, with a list of axes."""
    with understood(path, f"{SETTINGS} is not that of a sweep"):
        settings: Mapping[str, Any] = json.loads(attrs["sweep_settings_json"])
        for axis in settings["axes"]:
            _length(axis)
        return settings


def _length(axis: Mapping[str, Any]) -> int:
    return len(axis["values"]) if "values" in axis else int(axis["count"])


def _check_count(path: Path, file: h5py.File, axes: list[Mapping[str, Any]]) -> None:
    """A number of points that the file does not have must not be made: it may be any number."""
    status = file.get("status")
    there = status.size if isinstance(status, h5py.Dataset) and status.size is not None else 0
    expected = prod(map(_length, axes))
    if not 0 < expected <= there:
        raise damaged(path, f"{SETTINGS} names {counted(expected, 'point')}, and status has {there}")


def _check_axes(case: "Case", plan: SweepPlan) -> None:
    """Raise one of WRONG unless the axes vary numbers of the case, in units of theirs."""
    for axis in plan.axes:
        for key, text in axis.changes(0).items():
            measured = case.measured(key)
            if measured is None or case.values[key] is None:
                raise ValueError(key)
            measured.parsed(text)


def _check_scales(path: Path, file: h5py.File, plan: SweepPlan) -> None:
    """The scales must say what the settings say."""
    values = [*(axis.numbers() for axis in plan.axes), np.array(plan.directions)]
    for name, expected in zip(dimensions(plan), values, strict=True):
        if not np.array_equal(file[name][...], expected):
            raise damaged(path, f"{name} and {SETTINGS} name different values")


# Where the points of a running sweep are kept: in memory and the journal at once, on file now and then.


class SweepStore(Store[SweepPoint]):
    """The points of one sweep. `table` holds them."""

    what, record = "sweep", SweepPoint

    def make_memory(self) -> None:
        check_memory(self.plan)
        self.table = Table(self.plan)
        self._record_bytes = record_bytes(self.plan)

    def origin(self) -> dict[str, Any]:
        return origin(self.plan)

    def take(self, record: SweepPoint) -> None:
        self.table.put(record)

    def take_stored(self) -> dict[str, Any]:
        path = Path(self.shown)
        attrs, _, file = read_sweep(path)
        with file:
            if listed := differences(self.plan, attrs):
                kept = f"{path}: holds another sweep; kept (force=True replaces it)"
                raise ResultFileError(f"{kept}. It differs in {'; '.join(listed)}")
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
                f"it holds {counted(done, 'point')}, and the same command resumes it"
                if done
                else "no point was done"
            )
            raise ResultFileError(f"{self.shown}: disk full; {held}")


# Room that a point takes in the journal.


FOR_NUMBER = 60  # bytes of a number and its name
FOR_TEXTS = 1500  # bytes of place, fingerprint and the reason of a failure


def record_bytes(plan: SweepPlan) -> int:
    """Room that one point takes at most, about [bytes]."""
    further = [name for name, column in plan.columns.items() if column.dimension]
    doubles = sum(plan.shape_of(name)[-1] for name in further)
    return 2 * 8 * doubles + FOR_NUMBER * len(plan.columns) + FOR_TEXTS


# The root attributes of a sweep file: what was swept, how, by what, and what came of it.


def origin(plan: SweepPlan) -> dict[str, Any]:
    """Attributes that are known before the first point."""
    case, scene = plan.case, plan.case.scene()
    attrs: dict[str, Any] = {
        **provenance("sweep", case),
        "sweep_settings_json": json.dumps(plan.settings),
        "sweep_sha256": plan.fingerprint,
        "definitions": DEFINITIONS,
        "method": flow_of(scene),
        "engine": ENGINE_NAME,
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
    listed = [
        *_different_settings(stored, plan.settings),
        *_cases(attrs["case_resolved_json"], plan, stored["axes"]),
    ]
    more = len(listed) - AT_MOST
    return [*listed[:AT_MOST], *([f"and {more} more"] if more > 0 else [])]


def _different_settings(stored: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[str]:
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
    return f"{text} {read.unit}".strip() + f" ({counted(len(read), 'value')})"


def _few(count: int) -> list[int]:
    return list(range(count)) if count <= 3 else [0, 1, count - 1]


def _words(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, list):
        return " and ".join(map(str, value))
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)

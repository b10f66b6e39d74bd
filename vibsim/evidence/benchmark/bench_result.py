"""A bench as users meet it: rows, truth, and columns by name."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases import Case
from vibsim.cases.problems import counted
from vibsim.evidence.benchmark.plan import family_of
from vibsim.evidence.peers.solvers import kinds_of
from vibsim.physics.parts import EVENT_KINDS, IMPACTS, Scene, columns_of
from vibsim.results.columns import tables_of
from vibsim.results.file_contents import LIST, NUMBER, PROVENANCE, TEXT, WHOLE, Attribute, Column, Dataset
from vibsim.results.hdf5_reading import (
    damaged,
    opened,
    read_attributes,
    read_datasets,
    stored_case,
)
from vibsim.results.hdf5_writing import write_hdf5

FAITHFUL = 1e-3  # m: largest error of the displacements of a faithful run, a gap of the paper
SMALL = 0.05  # of the largest displacement, where that is smaller


def displacements_of(scene: Scene) -> list[str]:
    """Names of the columns of displacements; states have each of them in front of its velocity."""
    return [columns_of(body.name)[0] for body in scene.line]


@dataclass(frozen=True)
class BenchTruth:
    """States at the instants of a plan, and events.

    Attributes
    ----------
    fingerprint : of the plan that it was computed for
    samples : columns time [s], x1, v1 (, x2, v2, phi, phidot) (n)
    events : columns t [s] and kind
    attrs : digits carried and right, library, time it took [s]
    """

    fingerprint: str
    samples: Mapping[str, np.ndarray]
    events: Mapping[str, np.ndarray]
    attrs: Mapping[str, Any]


@dataclass(frozen=True)
class EventCount:
    """Events of one kind up to some instant."""

    found: int
    missed: int
    spurious: int


def faithful_error(truth: BenchTruth, scene: Scene) -> float:
    """The largest error of a faithful run [m]: FAITHFUL, or a share of the largest displacement."""
    largest = max(float(np.abs(truth.samples[name]).max()) for name in displacements_of(scene))
    return min(FAITHFUL, SMALL * largest) if largest else FAITHFUL


# One row of a bench: a method at a setting, what it took and how right it was.


DONE, SLOWER, FAILED = 1, 2, 3
STATUS_FLAGS = {"done": DONE, "slower": SLOWER, "failed": FAILED}


@dataclass
class BenchRow:
    """Result of one method at one setting.

    Attributes
    ----------
    method, setting : name of the family, entry of its ladder
    status : DONE; SLOWER where the time limit stopped it at t_reached; FAILED, then `problem` says how
    wall_time, cpu_time : of a run, the least of `runs`, which other processes disturb least [s]
    setup_time : before the first run, such as compiling [s]
    steps, evaluations : steps and right-hand sides of a run; -1 where there is no such number
    t_reached : time until which it ran [s]
    faithful_time : time until which the error is within 1e-3 m [s]
    error : of the displacements [m] at each instant compared, NaN from t_reached on
    events : counts up to faithful_time by kind, of the kinds that the method reports
    """

    method: str
    setting: str
    status: int
    problem: str = ""
    wall_time: float = nan
    cpu_time: float = nan
    setup_time: float = nan
    runs: int = 0
    steps: int = -1
    evaluations: int = -1
    t_reached: float = 0.0
    faithful_time: float = 0.0
    error: np.ndarray = field(default_factory=lambda: np.empty(0))
    events: dict[str, EventCount] = field(default_factory=dict)

    @property
    def time_per_second(self) -> float:
        """Processor time per second of motion [s/s]; NaN where nothing was run."""
        return self.cpu_time / self.t_reached if self.t_reached else nan

    def error_until(self, time: np.ndarray, t: float) -> float:
        """Largest error [m] at the instants `time` [s] up to `t`; NaN where the run ended before."""
        until = self.error[: np.searchsorted(time, t, side="right")]
        return float(until.max()) if len(until) else nan

    def counted(self) -> EventCount | None:
        """Events of all kinds that it reports; None for a row that failed."""
        if not self.events:
            return None
        counts = self.events.values()
        return EventCount(
            sum(c.found for c in counts), sum(c.missed for c in counts), sum(c.spurious for c in counts)
        )


TRUSTED = 1e-6  # m: an error beyond this is the chaos of the case rather than the work of the method


class BenchResult:
    """A bench, in memory or from a file.

    `bench.rows` are its rows, `bench["wall_time"]` one number of them all (n), `bench["error"]` their errors
    at the instants `bench["time"]` (n, instants). `bench.attrs` says where it comes from.
    """

    def __init__(self, attrs: dict[str, Any], truth: BenchTruth, rows: list[BenchRow]):
        self.attrs, self.truth, self.rows = attrs, truth, rows

    def __getitem__(self, name: str) -> np.ndarray:
        if name == "time":
            return self.truth.samples["time"]
        if name not in BenchRow.__dataclass_fields__ or name == "events":
            raise KeyError(f"no {name}; a bench has time, {', '.join(self.keys())}")
        return np.array([getattr(row, name) for row in self.rows])

    def keys(self) -> list[str]:
        """Names of what is known per row."""
        return [name for name in BenchRow.__dataclass_fields__ if name != "events"]

    @cached_property
    def case(self) -> Case:
        """The case that was run, its run settings those of the bench."""
        case = Case.from_resolved_json(self.attrs["case_resolved_json"])
        return replace(case, text=self.attrs["case_yaml"])

    @property
    def complete(self) -> bool:
        """Whether every row was run."""
        return bool(self.attrs["complete"])

    @property
    def check_times(self) -> list[float]:
        """The instants at which errors are told [s]."""
        return [float(t) for t in np.atleast_1d(self.attrs["check_times_s"])]

    @property
    def error_unit(self) -> str:
        """Unit of errors: m, of torsional scenes rad."""
        return tables_of(self.case.scene()).error_unit

    @cached_property
    def faithful_error(self) -> float:
        """The largest error of a faithful run [`error_unit`]."""
        return faithful_error(self.truth, self.case.scene())

    @cached_property
    def telling_time(self) -> float:
        """The latest instant [s] to compare errors at: where some row is still right to 1e-6 m, else the
        first.
        """
        right = [
            t
            for t in self.check_times
            if any(row.error_until(self["time"], t) <= TRUSTED for row in self.rows)
        ]
        return max(right, default=self.check_times[0])

    def __repr__(self) -> str:
        size = f"{counted(len(self.rows), 'row')}, {self['time'][-1]:g} s"
        return f"<BenchResult {self.case.name}: {size}; {', '.join(self.keys())}>"


def open_bench(path: str | Path) -> BenchResult:
    """The BenchResult in an HDF5 file. Raises ResultFileError where it holds none."""
    path = Path(path)
    with opened(path, "bench") as file:
        attrs = read_attributes(path, file, ATTRIBUTES)
        check_lists(path, attrs)
        scene = stored_case(path, attrs).scene()
        values = read_datasets(path, file, datasets_of(scene), lengths_of(scene))
    return BenchResult(attrs, read_truth(values, attrs), read_rows(values, scene))


def check_lists(path: Path, attrs: dict[str, Any]) -> None:
    """Raise ResultFileError unless lists of names are such, and there is an instant to compare at."""
    for name in ("methods", "not_installed"):
        try:
            names = json.loads(attrs[name])
        except (ValueError, RecursionError):
            names = None
        if not isinstance(names, list) or not all(isinstance(each, str) for each in names):
            raise damaged(path, f"the attribute {name} is not a list of names")
    if not len(attrs["check_times_s"]):
        raise damaged(path, "the attribute check_times_s is empty")


# The columns of a bench file: what each row of it holds.


NONE = -1  # of a count that a method does not give


def scales_of(scene: Scene) -> dict[str, Column]:
    """Columns that count rows, instants and kinds of events."""
    flags = {name: EVENT_KINDS[name] for name in kinds_of(scene)}
    return {
        "row": Column("1", "row of the bench", dtype="i4"),
        "time": Column("s", "time"),
        "kind": Column("1", "kind of the events", dtype="i1", flags=flags),
    }


TEXTS = {
    "method": Column(None, "family of methods", dtype="text"),
    "label": Column(None, "family of methods in words", dtype="text"),
    "setting": Column(None, "setting of the method", dtype="text"),
    "problem": Column(None, "why the method failed", dtype="text"),
}
ROW = {
    "wall_time": Column("s", "wall time of a run, least"),
    "cpu_time": Column("s", "CPU time of a run, least"),
    "setup_time": Column("s", "wall time before the first run, such as compiling"),
    "runs": Column("1", "runs of which the least is taken", dtype="i4"),
    "steps": Column("1", "steps of a run", dtype="i8", missing=NONE),
    "evaluations": Column("1", "right-hand sides evaluated in a run", dtype="i8", missing=NONE),
    "t_reached": Column("s", "time of the motion until which the method ran"),
    "faithful_time": Column("s", "time until which the displacements are faithful"),
}
STATUS = Column("1", "what came of the row", dtype="i1", flags=STATUS_FLAGS)
ERROR = Column("m", "largest error of the displacements")
COUNTS = {
    "found": Column("1", "true events found, up to faithful_time", dtype="i8", missing=NONE),
    "missed": Column("1", "true events missed, up to faithful_time", dtype="i8", missing=NONE),
    "spurious": Column("1", "events reported that are not, up to faithful_time", dtype="i8", missing=NONE),
}


# What a bench says: who is fastest, who most accurate, and what the peers take beside vibsim.


FLOOR = 2.0**-60  # m: smaller errors are rounding of the truth, 1e-18 m beside displacements of centimetres


@dataclass(frozen=True)
class Beside:
    """A row beside that of vibsim: ratios of processor times and of errors, theirs to vibsim's."""

    row: BenchRow
    times: float
    errors: float


def error_at(bench: BenchResult, row: BenchRow) -> float:
    """Error of a row [m] until the telling time, at least FLOOR; NaN where it did not come so far."""
    error = row.error_until(bench["time"], bench.telling_time)
    return max(error, FLOOR) if isfinite(error) else error


def fastest(bench: BenchResult) -> BenchRow | None:
    """The row that took the least time of those that are faithful until the telling time."""
    done = [row for row in bench.rows if row.status == DONE and error_at(bench, row) <= bench.faithful_error]
    return min(done, key=lambda row: row.time_per_second, default=None)


def most_accurate(bench: BenchResult, method: str | None = None) -> BenchRow | None:
    """The row with the least error until the telling time, of one family or of all."""
    judged = [row for row in bench.rows if method in (None, row.method) and isfinite(error_at(bench, row))]
    return min(judged, key=lambda row: error_at(bench, row), default=None)


def reference(bench: BenchResult) -> BenchRow | None:
    """The row of vibsim as it runs by default: the last of its first family, in C or else in Python."""
    own = [row for row in bench.rows if family_of(row.method).own and row.status == DONE]
    first = [row for row in own if row.method == own[0].method]
    return first[-1] if first else None


def beside_reference(bench: BenchResult) -> list[Beside]:
    """The most accurate row of every peer beside vibsim's own."""
    ours = reference(bench)
    peers = [name for name in dict.fromkeys(row.method for row in bench.rows) if not family_of(name).own]
    best = [most_accurate(bench, name) for name in peers]
    if ours is None:
        return []
    return [
        Beside(row, row.time_per_second / ours.time_per_second, error_at(bench, row) / error_at(bench, ours))
        for row in best
        if row is not None
    ]


def impacts_per_second(bench: BenchResult, row: BenchRow) -> float | None:
    """True impacts until the time that a row reached, per second of processor time; None without any."""
    codes = [EVENT_KINDS[name] for name in IMPACTS]
    impacts = np.isin(bench.truth.events["kind"], codes) & (bench.truth.events["t"] <= row.t_reached)
    count = np.count_nonzero(impacts)
    return count / row.cpu_time if count and row.cpu_time > 0 else None


def faster(bench: BenchResult, row: BenchRow) -> float | None:
    """Time of a row over that of vibsim, at an error that vibsim does not exceed.

    Beside it stands the fastest row of vibsim's own that is at least as accurate; None where there is none.
    """
    own = [each for each in bench.rows if family_of(each.method).own and each.status == DONE]
    accurate = [each.time_per_second for each in own if error_at(bench, each) <= error_at(bench, row)]
    return row.time_per_second / min(accurate) if accurate else None


# A bench as a dict for programs.


STATUS_NAMES = {code: name for name, code in STATUS_FLAGS.items()}


def facts(bench: BenchResult) -> dict[str, Any]:
    """Attributes and rows as plain data, the case as an object; what is not known is null."""
    attrs = {name: value for name, value in bench.attrs.items() if name != "case_yaml"}
    case = json.loads(attrs.pop("case_resolved_json"))
    attrs |= {name: json.loads(attrs[name]) for name in ("methods", "not_installed")}
    attrs["check_times_s"] = bench.check_times
    attrs["left_out"] = refusals(bench)
    ratios = [
        {
            "method": each.row.method,
            "setting": each.row.setting,
            "time_ratio": each.times,
            "error_ratio": each.errors,
        }
        for each in beside_reference(bench)
    ]
    rows = [row_facts(bench, row) for row in bench.rows]
    return {**attrs, "case": case, "telling_time_s": bench.telling_time, "rows": rows, "beside": ratios}


def refusals(bench: BenchResult) -> dict[str, str]:
    """Reasons why families that were asked for cannot take the case, by name."""
    scene = bench.case.scene()
    sentences = {name: family_of(name).refusal(scene) for name in json.loads(bench.attrs["methods"])}
    return {name: sentence for name, sentence in sentences.items() if sentence is not None}


def row_facts(bench: BenchResult, row: BenchRow) -> dict[str, Any]:
    """One row as plain data."""
    numbers = {name: _known(getattr(row, name), column.missing) for name, column in ROW.items()}
    errors = [_known(row.error_until(bench["time"], t)) for t in bench.check_times]
    return {
        "method": row.method,
        "label": family_of(row.method).label,
        "setting": row.setting,
        "status": STATUS_NAMES[row.status],
        "problem": row.problem or None,
        **numbers,
        "impacts_per_second": impacts_per_second(bench, row),
        "errors_m": errors,
        "events": {name: vars(count) for name, count in row.events.items()},
    }


def _known(value: float, missing: int | None = None) -> float | None:
    return value if isfinite(value) and value != missing else None


# A bench as an HDF5 file: written whole beside its name and renamed, so that it opens at every moment.


OWN = ("method", "setting", "problem", "status", *ROW, "error")  # what a Row has by the same name


def write_bench(
    path: Path, attrs: Mapping[str, Any], scene: Scene, truth: BenchTruth, rows: Sequence[BenchRow]
) -> None:
    """Write a bench of `scene` to `path`, replacing what is there in one instant. Raises ResultFileError."""
    kinds = kinds_of(scene)
    known = {**attrs, "truth_sha256": truth.fingerprint, **truth.attrs}
    values = {
        **{f"truth/{name}": column for name, column in truth.samples.items()},
        **{f"truth/events/{name}": column for name, column in truth.events.items()},
        "row": np.arange(len(rows)),
        "time": truth.samples["time"],
        "kind": [EVENT_KINDS[name] for name in kinds],
        "label": [family_of(row.method).label for row in rows],
        **{name: [getattr(row, name) for row in rows] for name in OWN},
        **{name: [_count(row, kind, name) for row in rows for kind in kinds] for name in COUNTS},
    }
    write_hdf5(path, known, datasets_of(scene), values)


def _count(row: BenchRow, kind: str, name: str) -> int:
    return getattr(row.events[kind], name) if kind in row.events else NONE


def read_truth(values: Mapping[str, Any], attrs: Mapping[str, Any]) -> BenchTruth:
    """The truth in a bench file of these datasets and attributes."""
    events = {name: values[f"truth/events/{name}"] for name in ("t", "kind")}
    samples = {
        name.removeprefix("truth/"): column
        for name, column in values.items()
        if name.startswith("truth/") and not name.startswith("truth/events/")
    }
    known = {name: attrs[name] for name in attrs if name.startswith("truth_") and name != "truth_sha256"}
    return BenchTruth(attrs["truth_sha256"], samples, events, known)


def read_rows(values: Mapping[str, Any], scene: Scene) -> list[BenchRow]:
    """The rows in a bench file of these datasets, of a bench of `scene`."""
    count, kinds = len(values["row"]), kinds_of(scene)
    return [_row({name: values[name][i] for name in (*OWN, *COUNTS)}, kinds) for i in range(count)]


def _row(values: Mapping[str, Any], kinds: Sequence[str]) -> BenchRow:
    own: dict[str, Any] = {name: str(values[name]) for name in TEXTS if name in OWN}
    own |= {name: values[name].item() for name in ("status", *ROW)}
    events = {
        kind: EventCount(**{name: int(values[name][k]) for name in COUNTS})
        for k, kind in enumerate(kinds)
        if values["found"][k] != NONE
    }
    return BenchRow(**own, error=values["error"], events=events)


# What a bench file holds.


WORDS = ("methods", "not_installed", "processor", "scipy_version", "heyoka_version")
TRUTH = ("truth_sha256", "truth_library")
ATTRIBUTES = [
    *PROVENANCE,
    *(Attribute(name, TEXT) for name in (*WORDS, *TRUTH)),
    *(Attribute(name, WHOLE) for name in ("truth_digits", "truth_digits_right", "cores")),
    *(Attribute(name, NUMBER) for name in ("truth_wall_time_s", "t_end_s", "limit_s")),
    Attribute("check_times_s", LIST),
    Attribute("complete", WHOLE, allowed=(0, 1)),
]


def lengths_of(scene: Scene) -> dict[str, int]:
    """Lengths of the dimensions that are known."""
    return {"kind": len(kinds_of(scene))}


def datasets_of(scene: Scene) -> list[Dataset]:
    """The datasets of a bench of that scene."""
    return [*_truth(scene), *_rows(scene)]


def _truth(scene: Scene) -> list[Dataset]:
    tables = tables_of(scene)
    states = [Dataset(f"truth/{name}", tables.samples[name], ("time",)) for name in tables.states]
    return [
        Dataset("truth/time", tables.samples["time"], ("time",), ascending=True),
        *states,
        Dataset("truth/events/t", tables.events["t"], ("t",), ascending=True),
        Dataset("truth/events/kind", tables.events["kind"], ("t",)),
    ]


def _rows(scene: Scene) -> list[Dataset]:
    scales = [Dataset(name, column, (name,)) for name, column in scales_of(scene).items()]
    of_rows = {**TEXTS, "status": STATUS, **ROW}
    rows = [Dataset(name, column, ("row",), gaps=True) for name, column in of_rows.items()]
    error = replace(ERROR, units=tables_of(scene).error_unit)
    errors = Dataset("error", error, ("row", "time"), gaps=True)
    counts = [Dataset(name, column, ("row", "kind")) for name, column in COUNTS.items()]
    return [*scales, *rows, errors, *counts]


# The truth of an earlier bench, taken over where it is that of the same case over the same instants.

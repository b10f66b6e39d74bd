"""A trajectory file opened for reading: checked once, its columns read when they are asked for."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from vibsim.engine.doubts import Doubt
from vibsim.engine.modes.formula_rows import SIDE
from vibsim.results.columns import TIMES, Digits, Tables, tables_of
from vibsim.results.file_contents import (
    ENGINE,
    EXTENDED,
    LIST,
    NUMBER,
    PROVENANCE,
    ROWS,
    TEXT,
    WHOLE,
    Attribute,
    Column,
    Dataset,
)
from vibsim.results.hdf5_reading import (
    check_datasets,
    check_values,
    checked_attributes,
    damage_named,
    open_hdf5,
    read_attrs,
    stored_case,
)
from vibsim.results.trust_horizon import COLUMN as ERROR_ESTIMATE

if TYPE_CHECKING:
    from vibsim.cases import Case


class TrajectoryFile:
    """An HDF5 file of one trajectory.

    tables : the columns of a file that this process has just written, which is not checked again; None:
    everything is checked, and `attrs` and `case` are read. Raises ResultFileError for a file that is no
    trajectory, or damaged.
    """

    def __init__(self, path: str | Path, tables: Tables | None = None):
        self.path = Path(path)
        self.attrs: dict[str, Any] = {}
        self.case: Case | None = None
        self._file = open_hdf5(self.path)
        try:
            with damage_named(self.path):
                self._open_tables(tables)
        except BaseException:
            self.close()
            raise

    def _open_tables(self, tables: Tables | None) -> None:
        t_end = inf
        if tables is None:
            tables, t_end = self._promised()
        samples, events = sample_datasets(tables, t_end), event_datasets(tables, t_end)
        digits = digit_datasets(tables) if "digits" in self._file else []
        orbit = orbit_datasets(self._file[GROUP]) if GROUP in self._file else []
        if self.case is not None:
            check_datasets(self.path, self._file, [*samples, *events, *digits, *orbit])
        self.orbit = FileColumns(self.path, self._file, orbit) if orbit else None
        self.samples = FileColumns(self.path, self._file, samples)
        self.events = FileColumns(self.path, self._file, events)
        self.digits = self._digits(digits)

    def _promised(self) -> tuple[Tables, float]:
        """Columns and end [s] that the case and the attributes promise, both checked."""

        self.attrs = checked_attributes(self.path, read_attrs(self._file), ATTRIBUTES)
        doubts_in(self.attrs)
        self.case = stored_case(self.path, self.attrs)
        scene = self.case.scene()
        known = ERROR_ESTIMATE in self._file or "trust_horizon_s" in self.attrs
        tables = tables_of(scene)
        told = {
            name: column
            for name, column in tables.events.items()
            if not name.startswith(SIDE) or f"events/{name}" in self._file  # not in older files
        }
        tables = replace(tables, events=told)
        return (tables.judged() if known else tables), scene.t_end

    def _digits(self, datasets: list[Dataset]) -> Digits | None:
        if not datasets:
            return None
        samples, events = (
            FileColumns(self.path, self._file, [each for each in datasets if of_events(each) == after])
            for after in (False, True)
        )
        return Digits(samples, events)

    def close(self) -> None:
        """Let go of the file; columns not read so far can then not be read."""
        self._file.close()


def of_events(dataset: Dataset) -> bool:
    """Whether a dataset of digits belongs to the table of events."""
    return "/events/" in dataset.name


class FileColumns(Mapping[str, np.ndarray]):
    """Columns of one table on file, read whole on first access and kept; `column` reads slices instead."""

    def __init__(self, path: Path, file: h5py.File, datasets: Iterable[Dataset]):
        self._path, self._file = path, file
        self._datasets = {dataset.name.rpartition("/")[2]: dataset for dataset in datasets}
        self._kept: dict[str, np.ndarray] = {}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._kept:
            self._kept[name] = self.column(name)[:]
        return self._kept[name]

    def column(self, name: str) -> "FileColumn":
        """One column, not read yet; KeyError when there is none of this name."""
        return FileColumn(self._path, self._file, self._datasets[name])

    def __contains__(self, name: object) -> bool:
        return name in self._datasets

    def __iter__(self) -> Iterator[str]:
        return iter(self._datasets)

    def __len__(self) -> int:
        return len(self._datasets)


class FileColumn:
    """One column on file: `column[a:b]` and `column[i]` read that much, `len` reads nothing.

    Raises ResultFileError for numbers that cannot be right.
    """

    def __init__(self, path: Path, file: h5py.File, declared: Dataset):
        self._path, self._declared = path, declared
        with damage_named(path):
            item = file[declared.name]
        self.dtype = item.dtype
        self._dataset = item.asstr() if declared.column.dtype == "text" else item

    def __len__(self) -> int:
        return int(self._dataset.shape[0])

    def __getitem__(self, rows: Any) -> Any:
        with damage_named(self._path):
            values = self._dataset[rows]
        check_values(self._path, self._declared, values)
        return values


# What the file of a periodic orbit holds besides a run of one period: the group `orbit`, and attributes.


GROUP = "orbit"
ORBIT_ATTRIBUTES = [
    Attribute("orbit_periods", WHOLE, optional=True),
    Attribute("orbit_period_s", NUMBER, optional=True, where="orbit_periods"),
    Attribute("orbit_stable", WHOLE, optional=True, where="orbit_periods", allowed=(0, 1)),
    Attribute("orbit_events", TEXT, optional=True, where="orbit_periods"),
    Attribute("orbit_residual", NUMBER, optional=True, where="orbit_periods"),
    Attribute("orbit_sliding_margin", EXTENDED, optional=True, where="orbit_periods"),
    Attribute("orbit_digits", WHOLE, optional=True),
]
UNKNOWN, MULTIPLIER, RETURN = ("unknown",), ("multiplier",), ("return",)
DATASETS = [
    Dataset(f"{GROUP}/unknown", Column(None, "name of the unknown on the section", dtype="text"), UNKNOWN),
    Dataset(f"{GROUP}/units", Column(None, "unit of the unknown", dtype="text"), UNKNOWN),
    Dataset(f"{GROUP}/multiplier", Column("1", "number of the multiplier", dtype="i4"), MULTIPLIER),
    Dataset(f"{GROUP}/multiplier_real", Column("1", "real part of the Floquet multiplier"), MULTIPLIER),
    Dataset(f"{GROUP}/multiplier_imaginary", Column("1", "imaginary part of it"), MULTIPLIER),
    Dataset(f"{GROUP}/return", Column("1", "number of the return to the section", dtype="i4"), RETURN),
    Dataset(f"{GROUP}/points", Column(None, "unknowns at the returns"), (*RETURN, *UNKNOWN)),
    Dataset(f"{GROUP}/derivative", Column(None, "derivative of the return map"), (*UNKNOWN, *UNKNOWN)),
]
DIGITS = [
    Dataset(
        f"{GROUP}/digits_start", Column(None, "unknowns at the start, decimal digits", dtype="S"), UNKNOWN
    ),
    Dataset(f"{GROUP}/digits_real", Column(None, "real part, decimal digits", dtype="S"), MULTIPLIER),
    Dataset(
        f"{GROUP}/digits_imaginary", Column(None, "imaginary part, decimal digits", dtype="S"), MULTIPLIER
    ),
]


def orbit_datasets(group: object) -> list[Dataset]:
    """The datasets of a group `orbit`, by what is in it."""
    return DATASETS + (DIGITS if "digits_start" in group else [])  # type: ignore[operator]


# What a trajectory file must hold, told from the columns of its scene.


COUNTS = ("impacts", "sticks", "reversals", "steps", "evaluations")
STRUCK = ("transmitted", "chatters", "rests")  # of scenes with rigid stops
LEFT_OUT = ("chatter_time", "chatter_speed", "chatter_distance")
NUMBERS = ("rest_distance_needed", "wall_time_s", "taylor_tolerance", "lyapunov_volume_residual")

ATTRIBUTES = [
    *PROVENANCE,
    Attribute("method", TEXT),
    ENGINE,
    Attribute("t_end_s", NUMBER),
    Attribute("complete", WHOLE, allowed=(0, 1)),
    Attribute("t_reached_s", NUMBER, optional=True, where="complete"),
    Attribute("events", WHOLE, optional=True),
    *(Attribute(name, WHOLE, optional=True, where="events") for name in COUNTS),
    *(Attribute(name, WHOLE, optional=True) for name in STRUCK),
    *(Attribute(name, NUMBER, optional=True) for name in LEFT_OUT),
    Attribute("certified", WHOLE, optional=True, allowed=(0, 1)),
    Attribute("uncertified", WHOLE, optional=True, where="certified"),
    Attribute("first_uncertified_time", NUMBER, optional=True, where="uncertified"),
    Attribute("doubts_json", TEXT, optional=True),
    Attribute("violations", WHOLE, optional=True),
    Attribute("first_violation_time", NUMBER, optional=True, where="violations"),
    Attribute("grazing_margin", NUMBER, optional=True, where="grazing_time"),
    Attribute("grazing_time", NUMBER, optional=True, where="grazing_margin"),
    Attribute("energy_residual", NUMBER, optional=True),
    Attribute("energy_residual_relative", NUMBER, optional=True, where="energy_residual"),
    Attribute("trust_horizon_s", NUMBER, optional=True),
    Attribute("trust_tolerance_m", NUMBER, optional=True, where="trust_horizon_s"),
    Attribute("error_estimate_max", NUMBER, optional=True, where="trust_horizon_s"),
    Attribute("trust_known_to_s", NUMBER, optional=True),
    Attribute("trust_unknown_why", TEXT, optional=True, where="trust_known_to_s"),
    Attribute("clearances_needed", LIST, optional=True),
    Attribute("taylor_order", WHOLE, optional=True),
    Attribute("digits", WHOLE, optional=True),
    Attribute("number_type", TEXT, optional=True, where="digits"),
    Attribute("digits_right", WHOLE, optional=True),
    Attribute("digits_right_from", TEXT, optional=True, where="digits_right"),
    Attribute("lyapunov_growth", ROWS, optional=True),
    Attribute("lyapunov_exponents", LIST, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_rank_losses", WHOLE, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_pieces", WHOLE, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_tangencies", WHOLE, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_closest_tangency", EXTENDED, optional=True, where="lyapunov_growth"),
    Attribute("lyapunov_closest_tangency_time", NUMBER, optional=True),
    Attribute("lyapunov_undefined_time", NUMBER, optional=True),
    *(Attribute(name, NUMBER, optional=True) for name in NUMBERS),
    *ORBIT_ATTRIBUTES,
]
ROUNDED = 1 + 4 * 2.0**-52  # the last sample and the end are rounded apart
SAMPLE, EVENT = "sample", "event"


def sample_datasets(tables: Tables, t_end: float = inf) -> list[Dataset]:
    """The datasets of the sampled columns, `time` first, of a run that ends at `t_end` [s] or before."""
    return [_dataset(name, name, column, SAMPLE, t_end) for name, column in tables.samples.items()]


def event_datasets(tables: Tables, t_end: float = inf) -> list[Dataset]:
    """The datasets of the table of events."""
    return [_dataset(f"events/{name}", name, column, EVENT, t_end) for name, column in tables.events.items()]


def digit_datasets(tables: Tables) -> list[Dataset]:
    """The texts of sampled states, and those of the table of events."""
    samples, events = digit_columns(tables)
    return [
        *(Dataset(f"digits/{name}", column, (SAMPLE,)) for name, column in samples.items()),
        *(Dataset(f"digits/events/{name}", column, (EVENT,)) for name, column in events.items()),
    ]


def digit_columns(tables: Tables) -> tuple[dict[str, Column], dict[str, Column]]:
    """Columns of the texts of sampled states, and of those of the table of events, by name."""
    return (
        {name: _written_out(tables.samples[name]) for name in tables.states},
        {name: _written_out(tables.events[name]) for name in ("t", *tables.states)},
    )


def _written_out(column: Column) -> Column:
    return Column(column.units, f"{column.long_name}, decimal digits", dtype="S")


def _dataset(path: str, name: str, column: Column, dimension: str, t_end: float) -> Dataset:
    if name in TIMES:
        return Dataset(path, column, (dimension,), ascending=True, span=(0.0, t_end * ROUNDED))
    return Dataset(path, column, (dimension,))


# Lyapunov exponents of a run as attributes of its file.


def exponent_attributes(totals: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes from the totals of a run; empty where it carried no tangent bundle, or ended too early.

    lyapunov_exponents [1/s], the largest first, -inf where sticking or rest took the direction, NaN where the
    motion has no derivative, from lyapunov_undefined_time [s] on; lyapunov_growth: rows (t [s], logarithm of
    the growth of each disturbance since the first row); what checks them.
    """
    if len(totals.get("growth", ())) < 2:
        return {}
    known = {
        "lyapunov_exponents": totals["exponents"],
        "lyapunov_growth": totals["growth"],
        "lyapunov_rank_losses": totals["rank_losses"],
        "lyapunov_pieces": totals["tangent_pieces"],
        "lyapunov_tangencies": totals["tangencies"],
        "lyapunov_closest_tangency": totals["closest_tangency"],
    }
    for name in ("volume_residual", "closest_tangency_time", "undefined_time"):
        if np.isfinite(totals[name]):
            known[f"lyapunov_{name}"] = totals[name]
    return known


# The first doubts of the certificate as an attribute.


def doubt_attributes(doubts: Sequence[Doubt]) -> dict[str, Any]:
    """The doubts as JSON; empty where there are none."""
    return {"doubts_json": json.dumps(doubt_objects(doubts))} if doubts else {}


def doubt_objects(doubts: Sequence[Doubt]) -> list[dict[str, Any]]:
    """Each doubt for JSON: time [s], events by the names of the parts, reason."""
    return [{"time_s": time, "events": list(events), "reason": reason} for time, events, reason in doubts]


def doubts_in(attrs: Mapping[str, Any]) -> list[Doubt]:
    """The doubts that attributes describe; none of files of versions that counted them only.

    Raises ValueError where the attribute has another form.
    """
    try:
        read = json.loads(attrs.get("doubts_json", "[]"))
        doubts = [Doubt(one["time_s"], tuple(one["events"]), one["reason"]) for one in read]
        texts = [text for doubt in doubts for text in (*doubt.events, doubt.reason)]
        right = all(isfinite(doubt.time) for doubt in doubts) and all(isinstance(text, str) for text in texts)
    except (ValueError, TypeError, KeyError, RecursionError, OverflowError):
        right = False
    if not right:
        raise ValueError("the attribute doubts_json does not describe doubts")
    return doubts

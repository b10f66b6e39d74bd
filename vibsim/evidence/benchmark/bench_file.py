"""A bench as an HDF5 file: written whole beside its name and renamed, so that it opens at every moment."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vibsim.evidence.benchmark.columns import COUNTS, ROW, TEXTS
from vibsim.evidence.benchmark.event_counts import EventCount
from vibsim.evidence.benchmark.families import family_of
from vibsim.evidence.benchmark.row import STATUS_FLAGS, Row
from vibsim.evidence.benchmark.truth import Truth
from vibsim.evidence.peers.attempt import EVERY_KIND
from vibsim.physics.modes import EVENT_KINDS
from vibsim.results.columns import Tables
from vibsim.results.hdf5_image import write_hdf5

COMPRESSED = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
NONE = -1  # of a count that a method does not give


def write_bench(
    path: Path, attrs: Mapping[str, Any], tables: Tables, truth: Truth, rows: Sequence[Row]
) -> None:
    """Write a bench to `path`, replacing what is there in one instant. Raises ResultFileError."""

    def fill(file: h5py.File) -> None:
        for name, value in {**attrs, "truth_sha256": truth.fingerprint, **truth.attrs}.items():
            file.attrs[name] = value
        _write_truth(file.create_group("truth"), tables, truth)
        _write_rows(file, truth, rows)

    write_hdf5(path, fill)


def _write_truth(group: h5py.Group, tables: Tables, truth: Truth) -> None:
    events = group.create_group("events")
    for place, table, columns in (
        (group, truth.samples, tables.samples),
        (events, truth.events, tables.events),
    ):
        first = next(iter(columns))
        scale = _dataset(place, first, table[first], columns[first].long_name, columns[first].units)
        scale.make_scale(first)
        for name in table:
            if name != first:
                column = columns[name]
                dataset = _dataset(place, name, table[name], column.long_name, column.units or "1", [scale])
                if column.flags:
                    _describe_flags(dataset, column.flags)


def _write_rows(file: h5py.File, truth: Truth, rows: Sequence[Row]) -> None:
    row = _scale(file, "row", np.arange(len(rows), dtype="i4"), "row of the bench", "1")
    time = _scale(file, "time", truth.samples["time"], "time", "s")
    codes = np.array([EVENT_KINDS[name] for name in EVERY_KIND], dtype="i1")
    kind = _scale(file, "kind", codes, "kind of the events", "1")
    _describe_flags(kind, {name: EVENT_KINDS[name] for name in EVERY_KIND})
    for name, meaning in TEXTS.items():
        texts = [_text(each, name) for each in rows]
        _dataset(file, name, np.array(texts, dtype=h5py.string_dtype()), meaning, None, [row])
    status = np.array([each.status for each in rows], dtype="i1")
    _describe_flags(_dataset(file, "status", status, "what came of the row", "1", [row]), STATUS_FLAGS)
    for name, column in ROW.items():
        numbers = np.array([getattr(each, name) for each in rows], dtype=column.dtype)
        _dataset(file, name, numbers, column.long_name, column.units, [row], column.missing)
    errors = np.array([each.error for each in rows]).reshape(len(rows), len(time))
    _dataset(file, "error", errors, "largest error of the displacements x1, x2", "m", [row, time])
    for name, meaning in COUNTS.items():
        counts = [[_count(each, kind_name, name) for kind_name in EVERY_KIND] for each in rows]
        table = np.array(counts, dtype="i8").reshape(len(rows), len(codes))
        _dataset(file, name, table, meaning, "1", [row, kind], NONE)


def _text(row: Row, name: str) -> str:
    return family_of(row.method).label if name == "label" else getattr(row, name)


def _count(row: Row, kind: str, name: str) -> int:
    return getattr(row.events[kind], name) if kind in row.events else NONE


def _scale(place: h5py.Group, name: str, values: np.ndarray, long_name: str, units: str) -> h5py.Dataset:
    scale = _dataset(place, name, values, long_name, units)
    scale.make_scale(name)
    return scale


def _dataset(
    place: h5py.Group,
    name: str,
    values: np.ndarray,
    long_name: str,
    units: str | None,
    scales: Sequence[h5py.Dataset] = (),
    missing: int | None = None,
) -> h5py.Dataset:
    options = COMPRESSED if values.size and values.dtype.kind in "fi" else {}
    dataset = place.create_dataset(name, data=values, **options)
    dataset.attrs["long_name"] = long_name
    if units is not None:
        dataset.attrs["units"] = units
    if missing is not None:
        dataset.attrs["missing_value"] = np.array(missing, values.dtype)
    for dimension, scale in zip(dataset.dims, scales, strict=False):
        dimension.attach_scale(scale)
    return dataset


def _describe_flags(dataset: h5py.Dataset, flags: Mapping[str, int]) -> None:
    dataset.attrs["flag_values"] = np.array(list(flags.values()), dataset.dtype)
    dataset.attrs["flag_meanings"] = " ".join(flags)


def read_truth(file: h5py.File, attrs: Mapping[str, Any]) -> Truth:
    """The truth in an open bench file of these attributes."""
    group = file["truth"]
    samples = {name: item[...] for name, item in group.items() if isinstance(item, h5py.Dataset)}
    events = {name: group["events"][name][...] for name in ("t", "kind")}
    known = {name: attrs[name] for name in attrs if name.startswith("truth_") and name != "truth_sha256"}
    return Truth(attrs["truth_sha256"], samples, events, known)


def read_rows(file: h5py.File) -> list[Row]:
    """The rows in an open bench file."""
    texts = {name: file[name].asstr()[...] for name in ("method", "setting", "problem")}
    numbers = {name: file[name][...] for name in ("status", *ROW)}
    counts = {name: file[name][...] for name in COUNTS}
    errors = file["error"][...]
    rows = []
    for i in range(len(errors)):
        values: dict[str, Any] = {name: str(column[i]) for name, column in texts.items()}
        values |= {name: column[i].item() for name, column in numbers.items()}
        events = {
            kind: EventCount(**{name: int(table[i, k]) for name, table in counts.items()})
            for k, kind in enumerate(EVERY_KIND)
            if counts["found"][i, k] != NONE
        }
        rows.append(Row(**values, error=errors[i], events=events))
    return rows

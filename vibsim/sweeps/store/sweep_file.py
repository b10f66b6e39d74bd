"""A sweep as an HDF5 file: written whole beside its name and renamed, so that it opens at every moment."""

from collections.abc import Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vibsim.results.errors import ResultFileError
from vibsim.results.hdf5_file import damage_named, open_hdf5
from vibsim.results.hdf5_image import write_hdf5
from vibsim.results.structure import check_values
from vibsim.sweeps.computations.impact_velocity import QUANTILES
from vibsim.sweeps.plan.members import Members
from vibsim.sweeps.plan.sweep_plan import DIRECTION_FLAGS, Plan
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.statistics.columns import STATUS_FLAGS, Column
from vibsim.sweeps.store.sweep_structure import datasets_of

COMPRESSED = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
DIRECTION_SCALE = "direction"
FURTHER_SCALES = {
    "section": "stroboscopic points, counted back from the last",
    "contact": "beginnings of contact, counted back from the last",
    "quantile": "share of the impacts that are not faster",
    "exponent": "number of the exponent, the largest first",
}


def write_sweep(path: Path, plan: Plan, table: Table, attrs: Mapping[str, Any]) -> None:
    """Write a sweep to `path`, replacing what is there in one instant. Raises ResultFileError."""

    def fill(file: h5py.File) -> None:
        for name, value in attrs.items():
            file.attrs[name] = value
        _write_datasets(file, plan, table)

    write_hdf5(path, fill)


def _write_datasets(file: h5py.File, plan: Plan, table: Table) -> None:
    scales = _write_scales(file, plan)
    further = _write_further_scales(file, plan)
    for name, array in table.numbers.items():
        column = plan.columns[name]
        if array.size:
            _attach(_number(file, name, array, column), [*scales, *further.get(column.dimension, [])])
    status = file.create_dataset("status", data=table.status, **COMPRESSED)
    _flags(status, "whether the point was computed", STATUS_FLAGS)
    _attach(status, scales)
    for name, long_name in (("sha256", "SHA-256 of the point's case"), ("error", "why a point failed")):
        texts = file.create_dataset(name, data=getattr(table, name), dtype=h5py.string_dtype())
        texts.attrs["long_name"] = long_name
        _attach(texts, scales)


def _write_scales(file: h5py.File, plan: Plan) -> list[h5py.Dataset]:
    """The dimension scales in the order of the dimensions: axes, direction."""
    scales = []
    for axis in plan.axes:
        scale = _number(file, axis.name, axis.numbers(), Column(axis.unit or "1", axis.key))
        scale.attrs["key"] = axis.key
        scales.append(scale)
        if isinstance(axis, Members):
            scale.attrs["long_name"] = "number of the member of the ensemble"
            _write_drawn(file, axis, scale)
    direction = file.create_dataset(DIRECTION_SCALE, data=np.array(plan.directions, dtype="i1"))
    _flags(direction, f"direction in which {plan.axes[0].name} was swept", DIRECTION_FLAGS)
    scales.append(direction)
    for scale in scales:
        scale.make_scale(scale.name.lstrip("/"))
    return scales


def _write_drawn(file: h5py.File, members: Members, scale: h5py.Dataset) -> None:
    """What was drawn for each member, by its key."""
    for spread, values in zip(members.spreads, members.drawn.values(), strict=True):
        column = Column(spread.unit or "1", f"{spread.key}: {spread}")
        _attach(_number(file, f"{members.name}_{spread.name}", values, column), [scale])


def _write_further_scales(file: h5py.File, plan: Plan) -> dict[str, list[h5py.Dataset]]:
    """The scale of each further dimension that the plan has and that is not empty, in a list."""
    scales = {}
    for dimension in dict.fromkeys(column.dimension for column in plan.columns.values() if column.dimension):
        count = plan.length_of(dimension)
        values = _scale_values(dimension, count)
        if not count:
            continue
        scale = file.create_dataset(dimension, data=values)
        scale.attrs["long_name"] = FURTHER_SCALES[dimension]
        scale.attrs["units"] = "1"
        scale.make_scale(dimension)
        scales[dimension] = [scale]
    return scales


def _scale_values(dimension: str, count: int) -> np.ndarray:
    if dimension == "quantile":
        return QUANTILES
    return (
        np.arange(1, count + 1, dtype="i4")
        if dimension == "exponent"
        else np.arange(1 - count, 1, dtype="i4")
    )


def _number(file: h5py.File, name: str, array: np.ndarray, column: Column) -> h5py.Dataset:
    dataset = file.create_dataset(name, data=array, **COMPRESSED)
    dataset.attrs["long_name"] = column.long_name
    dataset.attrs["units"] = column.units
    if column.flags:
        _flags(dataset, column.long_name, column.flags)
    return dataset


def _flags(dataset: h5py.Dataset, long_name: str, flags: Mapping[str, int]) -> None:
    dataset.attrs["long_name"] = long_name
    dataset.attrs["flag_values"] = np.array(list(flags.values()), dataset.dtype)
    dataset.attrs["flag_meanings"] = " ".join(flag.replace(" ", "_") for flag in flags)


def _attach(dataset: h5py.Dataset, scales: list[h5py.Dataset]) -> None:
    for dimension, scale in zip(dataset.dims, scales, strict=False):
        dimension.attach_scale(scale)


@contextmanager
def opened(path: Path):
    """The open HDF5 file of a sweep; ResultFileError for everything that is not one."""
    with damage_named(path), open_hdf5(path) as file:
        kind = file.attrs.get("vibsim_kind")
        if kind != "sweep":
            raise ResultFileError(f"{path}: holds a {kind or 'trajectory'}, not a sweep")
        yield file


def read_column(path: Path, plan: Plan, name: str) -> np.ndarray:
    """One column of the checked file of a sweep, or its status, sha256 or error; NaN where it has no room."""
    with opened(path) as file:
        if name in ("sha256", "error"):
            return file[name].asstr()[...]
        declared = next((each for each in datasets_of(plan) if each.name == name), None)
        if declared is None:
            return np.full(plan.shape_of(name), np.nan)
        values = file[name][...]
        check_values(path, declared, values)
        return values

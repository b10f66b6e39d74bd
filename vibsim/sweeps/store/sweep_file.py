"""A sweep as an HDF5 file: written whole beside its name and renamed, so that it opens at every moment."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from vibsim.files.checking import check_values
from vibsim.files.reading import damage_named, read_values
from vibsim.files.writing import write_hdf5
from vibsim.sweeps.computations.impact_velocity import QUANTILES
from vibsim.sweeps.plan.members import Members
from vibsim.sweeps.plan.sweep_plan import Plan
from vibsim.sweeps.points.table import Table
from vibsim.sweeps.store.sweep_structure import (
    DIRECTION,
    QUANTILE,
    TEXTS,
    datasets_of,
    drawn_name,
    further_dimensions,
)

KIND = "sweep"
NUMBERED = ("exponent", "multiplier")  # further dimensions that count from 1


def write_sweep(path: Path, plan: Plan, table: Table, attrs: Mapping[str, Any]) -> None:
    """Write a sweep to `path`, replacing what is there in one instant. Raises ResultFileError."""
    points = {**table.numbers, "status": table.status, "sha256": table.sha256, "error": table.error}
    write_hdf5(path, attrs, datasets_of(plan), {**coordinates(plan), **points})


def coordinates(plan: Plan) -> dict[str, np.ndarray]:
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


def read_column(path: Path, file: h5py.File, plan: Plan, name: str) -> np.ndarray:
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

"""The plan in a sweep file, and the check of the file against it."""

import json
from collections.abc import Mapping
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from vibsim.analysis.discard import parse_discard
from vibsim.cases.schema.keys import measured_at
from vibsim.cases.values.quantities import parse_quantity
from vibsim.files.checking import check_datasets, damaged
from vibsim.files.reading import check_kind, damage_named, open_hdf5, read_attributes
from vibsim.files.signals import ended_at_once
from vibsim.files.stored_case import stored_case, understood
from vibsim.sweeps.plan.members import axis_from_plain
from vibsim.sweeps.plan.sweep_plan import DIRECTION_FLAGS, Plan
from vibsim.sweeps.store.sweep_file import KIND
from vibsim.sweeps.store.sweep_structure import (
    ATTRIBUTES,
    COUNTS,
    datasets_of,
    dimensions,
    lengths_of,
)

if TYPE_CHECKING:
    from vibsim.cases import Case

SETTINGS = "the attribute sweep_settings_json"


@ended_at_once()
def read_sweep(path: Path) -> tuple[dict[str, Any], Plan, h5py.File]:
    """Root attributes and plan of a sweep file, the file checked and left open. Raises ResultFileError."""
    file = open_hdf5(path)
    try:
        with damage_named(path):
            check_kind(path, file, KIND)
            return *_checked(path, file), file
    except BaseException:
        file.close()
        raise


def _checked(path: Path, file: h5py.File) -> tuple[dict[str, Any], Plan]:
    attrs = read_attributes(path, file, ATTRIBUTES)
    settings = _settings(path, attrs)
    _check_count(path, file, settings["axes"])
    case = stored_case(path, attrs)
    with understood(path, f"{SETTINGS} describes no sweep of its case"):
        plan = _plan(case, settings)
        _check_axes(case, plan)
    check_datasets(path, file, datasets_of(plan), lengths_of(plan))
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
        raise damaged(path, f"{SETTINGS} names {expected} points, and status has {there}")


def _plan(case: "Case", settings: Mapping[str, Any]) -> Plan:
    """The plan that a file describes."""
    every, section = settings["every"], settings["section"]
    if not isinstance(section, int) or section < 0:
        raise ValueError("section")
    return Plan(
        case=case,
        axes=tuple(map(axis_from_plain, settings["axes"])),
        directions=tuple(DIRECTION_FLAGS[name] for name in settings["direction"]),
        carry=bool(settings["carry_state"]),
        discard=parse_discard(settings["discard"]),
        section=section,
        every=None if every == "auto" else parse_quantity(every, "time").value,
        compute=tuple(settings.get("compute", ())),
    )


def _check_axes(case: "Case", plan: Plan) -> None:
    """Raise one of WRONG unless the axes vary numbers of the case, in units of theirs."""
    for axis in plan.axes:
        for key, text in axis.changes(0).items():
            measured = measured_at(key)
            if measured is None or case.values[key] is None:
                raise ValueError(key)
            parse_quantity(text, measured.dimension)


def _check_scales(path: Path, file: h5py.File, plan: Plan) -> None:
    """The scales must say what the settings say."""
    values = [*(axis.numbers() for axis in plan.axes), np.array(plan.directions)]
    for name, expected in zip(dimensions(plan), values, strict=True):
        if not np.array_equal(file[name][...], expected):
            raise damaged(path, f"{name} and {SETTINGS} name different values")

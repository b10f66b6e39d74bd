"""Several sweep files read as one sweep: the parts of a large one, or ranges that were swept one by one."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from os import PathLike
from pathlib import Path

import numpy as np

from vibsim.files.errors import ResultFileError
from vibsim.sweeps.plan.axis import Axis
from vibsim.sweeps.plan.members import Members
from vibsim.sweeps.plan.sweep_plan import Plan
from vibsim.sweeps.store.provenance import origin
from vibsim.sweeps.sweep_result import SweepResult, open_sweep

AnyAxis = Axis | Members


def join(paths: Iterable[str | PathLike[str]]) -> SweepResult:
    """The sweeps in several files as one, along the one axis in which they differ, in any order.

    A column is read when it is asked for, from all files; `save` writes one file. Raises ResultFileError
    where the files are not parts of one sweep.

    >>> import vibsim
    >>> case = vibsim.load_case("II-B", {"run.t_end": "5 s"})
    >>> for speeds, path in (("3,4 Hz", "slow.h5"), ("5,6 Hz", "fast.h5")):
    ...     part = vibsim.sweep(case, {"Omega0": speeds}, section=0, jobs=1, out=path)
    >>> vibsim.join(["fast.h5", "slow.h5"])["omega0"]
    array([3., 4., 5., 6.])
    """
    files = [Path(path) for path in paths]
    if not files:
        raise ResultFileError("nothing to join: no files are given")
    parts = [open_sweep(path) for path in files]
    along = _dimension(files, parts)
    order = _order([part.axes[along] for part in parts])
    files, parts = [files[i] for i in order], [parts[i] for i in order]
    plan = _whole(files, parts, along)

    def read(name: str) -> np.ndarray:
        return np.concatenate([part[name] for part in parts], axis=along)

    attrs = origin(plan, parts[0].attrs["engine"])
    counted = ("points", "points_done", "points_failed", "wall_time_s")
    attrs |= {name: sum(part.attrs[name] for part in parts) for name in counted}
    attrs["complete"] = min(part.attrs["complete"] for part in parts)
    return SweepResult(attrs, plan, read)


def _dimension(files: Sequence[Path], parts: Sequence[SweepResult]) -> int:
    """Position of the axis along which the parts differ."""
    first = parts[0].axes
    differing = set()
    for file, part in zip(files, parts, strict=True):
        if [axis.key for axis in part.axes] != [axis.key for axis in first]:
            raise ResultFileError(f"{file}: sweeps other axes than {files[0]}")
        differing |= {i for i, axis in enumerate(part.axes) if axis != first[i]}
    if len(differing) > 1:
        names = " and ".join(first[i].name for i in sorted(differing))
        raise ResultFileError(f"{files[-1]}: differs from {files[0]} in {names}; parts differ in one axis")
    return differing.pop() if differing else 0


def _whole(files: Sequence[Path], parts: Sequence[SweepResult], along: int) -> Plan:
    """The plan of the whole; every part must be a part of it."""
    axes = list(parts[0].axes)
    axes[along] = _joined(files, [part.axes[along] for part in parts])
    wholes = [replace(part.plan, axes=tuple(axes)) for part in parts]
    for file, whole in zip(files, wholes, strict=True):
        if whole.fingerprint != wholes[0].fingerprint:
            raise ResultFileError(f"{file}: its case or its settings are not those of {files[0]}")
    return wholes[0]


def _way(axes: Sequence[AnyAxis]) -> int:
    """Which way the values of all parts run: 1 up, -1 down, 0 neither."""
    ways = {axis.way for axis in axes if len(axis) > 1} or {1}
    return ways.pop() if len(ways) == 1 else 0


def _order(axes: Sequence[AnyAxis]) -> list[int]:
    """Positions of the parts the way that their values run; as they are given where they run neither way."""
    way = _way(axes)
    return sorted(range(len(axes)), key=lambda i: way * axes[i].numbers()[0])


def _overlap(axis: AnyAxis, follower: AnyAxis, way: int) -> bool:
    """Whether a part does not follow on another."""
    values, later = axis.numbers(), follower.numbers()
    return bool(set(values.tolist()) & set(later.tolist()) or way * values[-1] > way * later[0])


def _joined(files: Sequence[Path], axes: Sequence[AnyAxis]) -> AnyAxis:
    """The axes one after another."""
    for (one, axis), (other, follower) in pairwise(zip(files, axes, strict=True)):
        if _overlap(axis, follower, _way(axes)):
            raise ResultFileError(f"{one} and {other} overlap in {axis.name}")
    first = axes[0]
    if isinstance(first, Members):
        whole = replace(first, count=sum(map(len, axes)))
        if whole.numbers().tolist() != [n for axis in axes for n in axis.numbers().tolist()]:
            raise ResultFileError(f"members are missing between {files[0]} and {files[-1]}")
        return whole
    return replace(first, values=tuple(v for axis in axes if isinstance(axis, Axis) for v in axis.values))

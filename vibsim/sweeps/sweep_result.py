"""A sweep as users meet it: arrays by name over its axes, and the case of each point."""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache, cached_property, partial
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases import Case
from vibsim.cases.problems import counted, one_line
from vibsim.cases.quantities import decimal_text
from vibsim.results.file_contents import Column
from vibsim.results.hdf5_reading import ResultFileError
from vibsim.results.labelled import Arrays, Labelled, few
from vibsim.results.output_files import check_result_output
from vibsim.results.store import Waiting
from vibsim.sweeps.axes import Axis, Members
from vibsim.sweeps.points import TEXTS_AND_STATUS, Share, Summary, SweepPoint, Table, share, summary
from vibsim.sweeps.quantities import DONE, MISSING, NAME, last_points
from vibsim.sweeps.sweep_file import (
    DERIVED,
    coordinates,
    datasets_of,
    dimensions,
    origin,
    outcome,
    read_attractors,
    read_column,
    read_sweep,
    write_sweep,
)
from vibsim.sweeps.sweep_plan import DIRECTION_NAMES, Index, PlanError, Start, SweepPlan

if TYPE_CHECKING:
    from vibsim.sweeps.attractors import Attractors


class SweepResult(Labelled):
    """A sweep, in memory or from a file.

    `sweep["mean_speed"]` is an array over the axes and, last, the direction; `sweep["section_displacement"]`
    has the stroboscopic points as one more dimension. What was not computed, or does not apply, is NaN.
    `sweep.attrs` says where it comes from and what came of it. What lies on file is read, column by column,
    when it is asked for.

    >>> import vibsim
    >>> sweep = vibsim.sweep("II-B", {"Omega0": "3:4:0.5 Hz"}, overrides={"run.t_end": "5 s"})
    >>> sweep["mean_speed"].shape  # values of Omega0, directions
    (3, 1)
    """

    def __init__(
        self,
        attrs: dict[str, Any],
        plan: SweepPlan,
        read: Callable[[str], np.ndarray],
        table: Table | None = None,
        stored: Callable[[], Any] | None = None,
    ):
        self.attrs, self.plan = attrs, plan
        self._read = cache(read)
        if table is not None:
            self.table = table
        self._stored = stored

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle: with all points, so that what comes out needs no file."""
        return SweepResult, (self.attrs, self.plan, self.table.column, self.table)

    @cached_property
    def table(self) -> Table:
        """All points at once."""
        table = Table(self.plan)
        table.fill(self._read)
        return table

    def __getitem__(self, name: str) -> np.ndarray:
        for axis in self.plan.axes:
            if axis.name == name:
                return axis.numbers()
        drawn = self._drawn()
        if name in drawn:
            return drawn[name]
        if name in self._derived():
            return self.attractors.labels if name == NAME else self.attractors.mirrored
        if name not in (*self.plan.columns, *TEXTS_AND_STATUS):
            raise KeyError(f"no {name}; this sweep has {', '.join(self.keys())}")
        return self._read(name)

    def __contains__(self, name: object) -> bool:
        return name in self.keys()

    def __iter__(self) -> Iterator[str]:
        return iter(self.keys())

    def keys(self) -> list[str]:
        """Names of the axes and of what is known per point."""
        names = [axis.name for axis in self.axes]
        return [*names, *self._drawn(), *self.plan.columns, *self._derived(), *TEXTS_AND_STATUS]

    def _derived(self) -> list[str]:
        """Columns that follow from the labels of all points."""
        return list(DERIVED) if NAME in self.plan.compute else []

    @cached_property
    def attractors(self) -> "Attractors":
        """The attractors on which the points end. Raises PlanError where the sweep did not ask for them."""
        if NAME not in self.plan.compute:
            raise PlanError(f"this sweep has no attractors (sweep with compute={NAME!r})")
        if self._stored is not None:
            found: Attractors = self._stored()
            return found
        from vibsim.sweeps.attractors import gather

        return gather(self.plan, self.table)

    @property
    def axes(self) -> tuple[Axis | Members, ...]:
        """The axes, in the order of the dimensions."""
        return self.plan.axes

    @property
    def members(self) -> Members | None:
        """The ensemble, where the sweep has one: its last axis."""
        last = self.axes[-1]
        return last if isinstance(last, Members) else None

    def _drawn(self) -> dict[str, np.ndarray]:
        """Numbers drawn for the members, such as `member_phi`."""
        members = self.members
        if members is None:
            return {}
        return {f"{members.name}_{s.name}": members.drawn[s.key] for s in members.spreads}

    def verdict(self, name: str) -> np.ndarray:
        """The verdicts of that name as words, such as "captured" of "capture"; empty where there is none.

        Raises KeyError for a name that is no verdict of this sweep.
        """
        flags = self.plan.columns[name].flags if name in self.plan.columns else {}
        if not flags:
            verdicts = [key for key, column in self.plan.columns.items() if column.flags]
            raise KeyError(
                f"{name} is no verdict of this sweep; its verdicts are {', '.join(verdicts) or 'none'}"
            )
        codes = self[name]
        return np.select([codes == code for code in flags.values()], list(flags), "")

    def over_members(self, name: str) -> Summary:
        """Summary over the members of the ensemble of the column of that name; shapes without the member
        axis.

        Raises ValueError for a sweep without ensemble.
        """
        return summary(self[name], self._member_dimension())

    def probability(self, condition: np.ndarray) -> Share:
        """Share of the members for which `condition` (shape of the sweep) holds, with its interval of 95 %.

        Only the points that were computed count. Raises ValueError for a sweep without ensemble.
        """
        return share(condition, self["status"] == DONE, self._member_dimension())

    def _member_dimension(self) -> int:
        if self.members is None:
            raise ValueError("this sweep has no ensemble")
        return len(self.axes) - 1

    @property
    def directions(self) -> tuple[int, ...]:
        """Codes of the directions, +1 up and -1 down: the last dimension of a point's number."""
        return self.plan.directions

    @property
    def case(self) -> Case:
        """The case that the axes vary."""
        return self.plan.case

    @property
    def complete(self) -> bool:
        """Whether every point was computed."""
        return bool((self["status"] != MISSING).all())

    def column(self, name: str) -> Column:
        """Unit and definition of what `self[name]` holds."""
        return self.plan.columns[name]

    def case_at(self, index: Index) -> Case:
        """The case of one point: its values and, where a state was carried, the state that it began from."""
        return self.plan.point_case(index, self._start(index))

    def _start(self, index: Index) -> Start | None:
        """The end of the last point before `index` in its chain that did not fail."""
        start = None
        if self.plan.carry:
            chain = next(chain for chain in self.plan.chains() if index in chain)
            for before in chain[: chain.index(index)]:
                point = self.table.point(before)
                start = self.plan.point_settings.start_after(point.values) if point.done else start
        return start

    def save(self, path: str | Path, force: bool = False) -> Path:
        """Write the sweep to an HDF5 file; its absolute path.

        Raises ResultFileError where it cannot be written, or is there and `force` is not given.
        """
        target = check_result_output(path, force)
        write_sweep(target, self.plan, self.table, self.attrs)
        return target

    def arrays(self) -> Arrays:
        """The columns over the axes and the direction; coordinates are the axes' values in their units.

        >>> import vibsim
        >>> case = vibsim.load_case("II-B", {"run.t_end": "2 s"})
        >>> vibsim.sweep(case, {"c": [0.01, 0.02]}, section=3, jobs=1).arrays().lengths
        {'c': 2, 'direction': 1, 'section': 3}
        """
        scales = coordinates(self.plan)
        declared = tuple(datasets_of(self.plan))
        return Arrays(
            declared, lambda name: scales[name] if name in scales else self[name], dimensions(self.plan),
            self.attrs,
        )  # fmt: skip

    def heading(self) -> str:
        """Name of the case, axes, and how many points were computed."""
        axes = " x ".join(str(a) if isinstance(a, Members) else f"{len(a)} {a}" for a in self.axes)
        points = counted(self.attrs["points"], "point")
        return f"{self.case.name}: {axes}, {self.attrs['points_done']} of {points}"

    def lines(self) -> list[tuple[str, str]]:
        """Axes, points, how they begin, what was computed, and the first columns."""

        computed = [("computed", ", ".join(self.plan.compute))] if self.plan.compute else []
        return [
            *((axis.name, axis_text(axis)) for axis in self.axes),
            ("points", points_text(self.attrs)),
            ("start", start_text(self)),
            *computed,
            ("columns", few(self.plan.columns)),
        ]


def open_sweep(path: str | Path) -> SweepResult:
    """The SweepResult in an HDF5 file, with the points that wait in its journal.

    Raises ResultFileError where it holds none.
    """
    waiting = Waiting(path)
    attrs, plan, file = read_sweep(Path(path))
    read = partial(read_column, Path(path), file, plan)
    points = waiting.records(plan.fingerprint, SweepPoint)
    if not points:
        return SweepResult(attrs, plan, read, stored=partial(read_attractors, Path(path), file, plan))
    table = Table(plan)
    table.fill(read)
    for point in points:
        table.put(point)
    return SweepResult({**attrs, **outcome(table)}, plan, table.column, table)


# What a sweep file holds, in labelled lines for people and as a dict for programs.


Lines = list[tuple[str, str]]


def describe(path: str | Path) -> tuple[Lines, dict[str, Any]]:
    """Lines (label, text) and facts of a sweep file. Raises ResultFileError where it holds none."""
    result = open_sweep(path)
    return [*sweep_lines(result), ("written", _written(result.attrs))], facts(result)


def sweep_lines(result: SweepResult) -> Lines:
    """Summary of a sweep: its axes, its settings, its results."""
    attrs, plan = result.attrs, result.plan
    name, title = one_line(attrs["case_name"]), one_line(attrs["title"])
    lines = [("case", title if title == name else f"{name}  {title}")]
    lines += [(axis.name, axis_text(axis)) for axis in plan.axes]
    lines.append(("points", points_text(attrs)))
    lines.append(("start", start_text(result)))
    lines.append(("run", f"{_ends(plan)}, transient of {plan.discard} left out of the statistics"))
    if plan.compute:
        lines.append(("computed", ", ".join(plan.compute)))
    lines.append(("section", f"{last_points(plan.section)} of each"))
    if NAME in plan.compute:
        from vibsim.sweeps.basin_measures import attractor_lines

        lines += attractor_lines(result)
    failures = list(result.table.failures())
    lines += [("failed", f"{place_text(result, index)}: {reason}") for index, reason in failures[:5]]
    if len(failures) > 5:
        lines.append(("failed", f"and {len(failures) - 5} more"))
    return lines


def _ends(plan: SweepPlan) -> str:
    """Duration of the runs: 300 s, or the values of an axis."""
    for axis in plan.axes:
        if isinstance(axis, Axis) and "run.t_end" in (axis.key, *axis.also):
            return axis_text(axis)
    return str(plan.case.quantity("run.t_end"))


def facts(result: SweepResult) -> dict[str, Any]:
    """The attributes as plain data, the case as an object."""
    attrs = {name: value for name, value in result.attrs.items() if name != "case_yaml"}
    case, settings = json.loads(attrs.pop("case_resolved_json")), json.loads(attrs.pop("sweep_settings_json"))
    failed = [{"at": place_text(result, index), "error": reason} for index, reason in result.table.failures()]
    of_attractors: dict[str, Any] = {}
    if NAME in result.plan.compute:
        from vibsim.sweeps.basin_measures import attractor_facts

        of_attractors = attractor_facts(result)
    return {**attrs, "case": case, "sweep": settings, **of_attractors, "failed": failed}


def axis_text(axis: Axis | Members) -> str:
    """The values of an axis: 3 to 7 Hz in steps of 0.05, 81 values."""
    if isinstance(axis, Members):
        return str(axis)
    values, count = axis.values, counted(len(axis), "value")
    steps = {after - before for before, after in pairwise(values)}
    if len(values) > 2 and len(steps) == 1:
        span = f"{decimal_text(values[0])} to {decimal_text(values[-1])} {axis.unit}".strip()
        return f"{span} in steps of {decimal_text(abs(steps.pop()))}, {count}"
    if axis.by_ratio:
        return (
            f"{decimal_text(values[0])} to {decimal_text(values[-1])} {axis.unit}".strip()
            + f" by ratio, {count}"
        )
    shown = [decimal_text(value) for value in values]
    listed = shown if len(shown) <= 6 else [*shown[:3], "...", shown[-1]]
    return f"{', '.join(listed)} {axis.unit}".strip() + f", {count}"


def points_text(attrs: dict[str, Any]) -> str:
    """Numbers of points computed, failed and missing."""
    total, done, failed = attrs["points"], attrs["points_done"], attrs["points_failed"]
    parts = [f"{done} of {total} done"]
    parts += [f"{failed} failed"] if failed else []
    parts += [f"{total - done - failed} missing"] if total > done + failed else []
    return ", ".join(parts)


def start_text(result: SweepResult) -> str:
    """Starts of the points, in words."""
    plan = result.plan
    if not plan.carry:
        return "every point from the state of its case"
    axis = plan.axes[0]
    if axis.way:
        way = " and back ".join(DIRECTION_NAMES[code] for code in plan.directions)
    else:
        way = "as listed" + (" and back" if len(plan.directions) > 1 else "")
    return f"every point from the end of the one before, {axis.name} {way}"


def place_text(result: SweepResult, index: tuple[int, ...]) -> str:
    """Place of a point: omega0 = 3.05 Hz, down."""
    places = [f"{axis.name} = {axis.text(i)}" for axis, i in zip(result.axes, index, strict=False)]
    direction = [DIRECTION_NAMES[result.directions[index[-1]]]] if result.plan.carry else []
    return ", ".join([*places, *direction])


def _written(attrs: dict[str, Any]) -> str:
    versions = (
        f"vibsim {attrs['vibsim_version']}, Python {attrs['python_version']}, numpy {attrs['numpy_version']}"
    )
    took = f"{attrs['wall_time_s']:.3g} s"
    return f"{attrs['date_created']}, {took}; {versions}; {attrs['platform']}"


# Several sweep files read as one sweep: the parts of a large one, or ranges that were swept one by one.


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

    attrs = origin(plan)
    summed = ("points", "points_done", "points_failed", "wall_time_s")
    attrs |= {name: sum(part.attrs[name] for part in parts) for name in summed}
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


def _whole(files: Sequence[Path], parts: Sequence[SweepResult], along: int) -> SweepPlan:
    """The plan of the whole; every part must be a part of it."""
    axes = list(parts[0].axes)
    axes[along] = _joined(files, [part.axes[along] for part in parts])
    wholes = [replace(part.plan, axes=tuple(axes)) for part in parts]
    for file, whole in zip(files, wholes, strict=True):
        if whole.fingerprint != wholes[0].fingerprint:
            raise ResultFileError(f"{file}: its case or its settings are not those of {files[0]}")
    return wholes[0]


def _way(axes: Sequence[AnyAxis]) -> int:
    """Direction of the values of all parts: 1 up, -1 down, 0 neither."""
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

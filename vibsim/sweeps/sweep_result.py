"""A sweep as users meet it: arrays by name over its axes, and the case of each point."""

from collections.abc import Callable, Iterator
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases import Case
from vibsim.files.declarations import Column
from vibsim.files.journal import Waiting
from vibsim.files.output_file import check_result_output
from vibsim.labelled.arrays import Arrays
from vibsim.labelled.labelled import Labelled, few
from vibsim.sweeps.ensemble import Share, Summary, share, summary
from vibsim.sweeps.plan.axis import Axis
from vibsim.sweeps.plan.members import Members
from vibsim.sweeps.plan.recipe import Start
from vibsim.sweeps.plan.sweep_plan import Index, Plan
from vibsim.sweeps.points.table import TEXTS_AND_STATUS, Table
from vibsim.sweeps.statistics.columns import DONE, MISSING
from vibsim.sweeps.store.journal import point_from
from vibsim.sweeps.store.provenance import outcome
from vibsim.sweeps.store.stored_plan import read_sweep
from vibsim.sweeps.store.sweep_file import coordinates, read_column, write_sweep
from vibsim.sweeps.store.sweep_structure import datasets_of, dimensions


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
        plan: Plan,
        read: Callable[[str], np.ndarray],
        table: Table | None = None,
    ):
        self.attrs, self.plan = attrs, plan
        self._read = cache(read)
        if table is not None:
            self.table = table

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
        return [*names, *self._drawn(), *self.plan.columns, *TEXTS_AND_STATUS]

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
        """What was drawn for the members, such as `member_phi`."""
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
        """What the members of the ensemble have of that name, summed up; shapes without the member axis.

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
                start = self.plan.recipe.start_after(point.values) if point.done else start
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
        return f"{self.case.name}: {axes}, {self.attrs['points_done']} of {self.attrs['points']} points"

    def lines(self) -> list[tuple[str, str]]:
        """Axes, points, how they begin, what was computed, and the first columns."""
        from vibsim.sweeps.description import axis_text, points_text, start_text

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
    points = waiting.records(plan.fingerprint)
    if not points:
        return SweepResult(attrs, plan, read)
    table = Table(plan)
    table.fill(read)
    for point in map(point_from, points):
        table.put(point)
    return SweepResult({**attrs, **outcome(table)}, plan, table.column, table)

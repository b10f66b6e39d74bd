"""A locus: a bifurcation along two parameters, arrays by name."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.branches.along import Along
from vibsim.branches.curve.node import Node
from vibsim.branches.loci.locus import WATCHED, LocusStep, PlanePoint, walk
from vibsim.branches.loci.locus_plan import LocusPlan
from vibsim.branches.tracing.records import OrbitRecord, orbit_record
from vibsim.labelled.arrays import Arrays
from vibsim.labelled.labelled import Labelled, few
from vibsim.orbits.multipliers import nearest_to_circle

MOST_POINTS = 2000
WAYS = (1, -1)
FIRST = 0.01  # scaled length of the first step


@dataclass(frozen=True)
class LocusRecord:
    """A point of a locus; way, number, step, ended: as of `vibsim.branches.tracing.records.PointRecord`.

    orbit : at the bifurcation; second : value of the second parameter
    index : number of the other multipliers outside the unit circle
    """

    way: int
    number: int
    orbit: OrbitRecord
    second: float
    index: int
    unknowns: tuple[float, ...]
    tangent: tuple[float, ...]
    step: float
    ended: str = ""


class Locus(Along, Labelled):
    """A locus: `locus["parameter"]`, `locus["second"]` and so on along it.

    plan : what was followed
    attrs : of its file

    >>> import vibsim
    >>> orbit = vibsim.orbit("I-C", {"omega": "4.2 Hz"}, period=1)
    >>> branch = vibsim.continue_branch(orbit, "omega", "4:4.3 Hz")
    >>> locus = vibsim.continue_locus(branch, "PD1", "c", "0.001:0.003 N s/m", max_points=4)
    >>> bool(float(locus.case_at(0).quantity("c").value) == locus["second"][0])
    True
    """

    noun = "locus"

    def __init__(
        self, plan: LocusPlan, points: Sequence[LocusRecord], attrs: Mapping[str, Any] | None = None
    ):
        self.plan, self.attrs = plan, dict(attrs or {})
        back = sorted((p for p in points if p.way < 0), key=lambda p: -p.number)
        self.points = [*back, *sorted((p for p in points if p.way > 0), key=lambda p: p.number)]

    @property
    def case(self) -> Any:
        return self.plan.branch.case

    @property
    def kind(self) -> str:
        """Of the bifurcation."""
        return self.plan.kind

    @property
    def ends(self) -> tuple[str, str]:
        """Why it ends, at its first and its last point; empty where it was not followed further."""
        return (self.points[0].ended, self.points[-1].ended) if self.points else ("", "")

    def arrays(self) -> Arrays:
        """What its file holds, by point and multiplier."""
        from vibsim.branches.store.locus_file import values_of
        from vibsim.branches.store.structure import POINT, locus_datasets

        declared = locus_datasets(self.plan.branch.unit, self.plan.unit)
        shown = ("parameter", "second", "period")
        return Arrays.of_values(declared, values_of(self), (POINT,), self.attrs, shown)

    def heading(self) -> str:
        """Name of the case, which bifurcation in which two parameters, and how many points."""
        from vibsim.branches.description import locus_lines

        return f"{locus_lines(self)[0][1]}, {len(self)} points"

    def lines(self) -> list[tuple[str, str]]:
        """Points, ends, and the names of the arrays."""
        from vibsim.branches.description import locus_lines

        return [*locus_lines(self)[1:], ("arrays", few(self.keys()))]

    def case_at(self, point: int) -> Any:
        """The case that runs one period on the orbit of a point."""
        return self.plan.plane().family_at(self.points[point].second).case_on(self.points[point].orbit)

    def save(self, path: str | PathLike[str], force: bool = False) -> Path:
        """Write the locus to an HDF5 file, which every command takes; its absolute path.

        force : replace what is there. Raises ResultFileError where it cannot be written.

        `vibsim continue BRANCH --locus LABEL ... -o path` goes on with it where it did not come to its ends.
        """
        from vibsim.branches.store.locus_file import origin, write_locus
        from vibsim.files.output_file import check_result_output

        target = check_result_output(Path(path), force)
        write_locus(target, self, self.attrs or origin(self.plan), all(self.ends))
        return target

    @cached_property
    def _arrays(self) -> dict[str, np.ndarray]:
        orbits = [point.orbit for point in self.points]
        return {
            "parameter": np.array([orbit.parameter for orbit in orbits]),
            "second": np.array([point.second for point in self.points]),
            "period": np.array([orbit.period for orbit in orbits]),
            "state": np.array([orbit.state for orbit in orbits]),
            "multipliers": np.array([orbit.multipliers for orbit in orbits]),
            "index": np.array([point.index for point in self.points]),
        }


def trace_locus(
    plan: LocusPlan, add: Any, points: Sequence[LocusRecord], most: int, engine: str, watch: Any
) -> bool:
    """Follow a locus both ways from where `points` know it; `add` is given each new point.

    watch : told the number of points; whether to go on. Returns whether it came to its ends or `most`
    points. Raises ContinuationError where the bifurcation is not found again.
    """
    plane = plan.plane(engine)
    start, along = plan.start(plane)
    known, pair = list(points), plane.pair
    if not known:
        known.append(_record(start, along, 1, 0, FIRST))
        add(known[-1])
    for way in WAYS:
        done = [point for point in known if point.way == way or point.number == 0]
        last, plane.pair = done[-1], pair
        room = (most + 1) // 2 - len(done) if way == WAYS[0] else most - len(known)
        if last.ended or room <= 0:
            continue
        here, direction = start, way * along
        if plane.kind in WATCHED:
            plane.watch(np.array(last.unknowns))
        if last.number:
            here, direction = plane(np.array(last.unknowns)), np.array(last.tangent)
            plane.pair = nearest_to_circle(last.orbit.multipliers)
        for number, step in enumerate(walk(plane, here, direction, last.step, plan.spans), last.number + 1):
            known.append(_record_of(step, way, number))
            add(known[-1])
            if watch is not None and not watch(len(known)):
                return False
            if number == last.number + room:
                break
    return True


def _record_of(step: LocusStep, way: int, number: int) -> LocusRecord:
    return _record(step.point, step.tangent, way, number, step.next, step.ended)


def _record(
    point: PlanePoint, along: np.ndarray, way: int, number: int, step: float, ended: str = ""
) -> LocusRecord:
    orbit = orbit_record(Node(point.point, along[:-1], 0))
    places = tuple(point.z.tolist()), tuple(along.tolist())
    return LocusRecord(way, number, orbit, point.second, point.index, *places, step, ended)

"""A locus: a bifurcation along two parameters, its plan, arrays by name, its file and its store."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.orbits.branches.branch import Branch, SpecialPoint
from vibsim.orbits.branches.correction import correct, tangent
from vibsim.orbits.branches.curve import (
    LOCUS_ATTRIBUTES,
    POINT,
    CurveStore,
    OrbitCurve,
    attributes_and_plan,
    locus_datasets,
    points_on_file,
)
from vibsim.orbits.branches.locus import KINDS, WATCHED, ParameterPlane, PlanePoint, follow_pair, walk
from vibsim.orbits.branches.node import Node
from vibsim.orbits.branches.plan import FIRST_STEP, BranchError, BranchPlan, CurvePlan, must_matter, value_in
from vibsim.orbits.branches.special_points import BRANCHING, CONTACTS, GRAZING, NAMES, STICKING, TORUS, held
from vibsim.orbits.branches.tracing import OrbitRecord, Watch, orbit_record
from vibsim.orbits.stability import nearest_to_circle
from vibsim.orbits.words import changes
from vibsim.results.file_contents import Dataset
from vibsim.results.hdf5_reading import opened, read_datasets, understood
from vibsim.results.labelled import few
from vibsim.results.store import stored

# Which bifurcation is to be followed, and over what.


WHY_NOT = {  # why no locus of a kind is followed, and what to do
    BRANCHING: ". Two branches cross there, which only a symmetry of the scene keeps up when a second "
    "parameter varies, and along such points the equations of a locus are singular; continue the branch at "
    "several values of the second parameter",
}


@dataclass(frozen=True)
class LocusPlan(CurvePlan):
    """A bifurcation of a branch to be followed in its parameter and a second one.

    branch : plan of the branch; label, kind : of the special point
    keys, unit, span, value : of the second parameter, its range and its value on the branch
    state, period, parameter, pair : of the special point; pair: its multiplier, for a Neimark-Sacker point
    part : number of the stop that is grazed, or of the friction that begins to hold
    """

    branch: BranchPlan
    label: str
    kind: str
    keys: tuple[str, ...]
    unit: str
    span: tuple[float, float]
    value: float
    state: tuple[float, ...]
    period: float
    parameter: float
    pair: complex
    part: int = field(default=-1, metadata=stored("stop"))  # as files call it since they knew of stops alone

    noun = "locus"

    @property
    def case(self) -> Any:
        """That of the branch."""
        return self.branch.case

    @property
    def title(self) -> str:
        return f"{self.kind} {self.label} of {self.case.name} over {self.keys[0]}"

    def plane(self) -> ParameterPlane:
        """The orbits over both parameters."""
        scale = max(abs(self.value), abs(self.span[1] - self.span[0]) / 4)
        family = self.branch.family()
        return ParameterPlane(family, self.keys, self.unit, scale, self.kind, self.pair, self.part)

    def start(self, plane: ParameterPlane) -> tuple[PlanePoint, np.ndarray]:
        """The first point, and the tangent there towards larger values of the second parameter.

        Raises ContinuationError.
        """
        family = plane.family_at(self.value)
        z = np.append(
            family.unknowns(np.array(self.state), self.period, self.parameter), self.value / plane.scale[-1]
        )
        along = np.eye(len(z))[-1]
        if self.kind in WATCHED:
            plane.watch(z)
        point = correct(plane, z, along, FIRST_STEP).point
        if self.kind == TORUS:
            follow_pair(plane, point)
        return point, tangent(point.jacobian(), along)

    @property
    def spans(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ranges of both parameters: of the first all that has a sense."""
        return self.first_span, self.span

    @property
    def first_span(self) -> tuple[float, float]:
        """Of the first parameter: that of the branch, widened to where the locus may lead."""
        low, high = self.branch.span
        return min(low, 0.25 * low), max(high, 4 * high)


def locus_plan(
    branch: Branch, label: str, keys: Sequence[str], unit: str, span: tuple[float, float]
) -> LocusPlan:
    """The plan of following the special point `label` of a branch over a second parameter.

    Raises BranchError for a label that is none or cannot be followed, a key that is the branch's own or
    that no orbit depends on, and a range without the value of the case.
    """
    try:
        special = branch.special(label)
    except KeyError as error:
        raise BranchError(str(error.args[0])) from None
    if special.kind not in KINDS:
        why = WHY_NOT.get(special.kind, "")
        raise BranchError(
            f"{label} is {NAMES[special.kind]}; loci are followed of {', '.join(KINDS)} points{why}"
        )
    if set(keys) & set(branch.plan.keys):
        raise BranchError(f"{keys[0]} is the parameter of the branch; a locus needs another")
    value = value_in(branch.case.quantity(keys[0]), unit)
    must_matter(branch.case, keys)
    low, high = sorted(span)
    if not low <= value <= high or low == high:
        raise BranchError(
            f"the branch is at {keys[0]} = {number(value, 6)} {unit}, outside the range "
            f"{number(low, 6)}:{number(high, 6)}"
        )
    pair = nearest_to_circle(special.orbit.multipliers)
    orbit = special.orbit
    where = orbit.state, orbit.period, orbit.parameter
    part = {GRAZING: touched, STICKING: holding}.get(special.kind, lambda _: -1)(special)
    of = branch.plan, label, special.kind, tuple(keys), unit, (low, high), value
    return LocusPlan(*of, *where, pair, part)


def touched(special: SpecialPoint) -> int:
    """Number of the stop that is grazed at a special point. Raises BranchError where there are several."""
    gone, come = changes(special.before, special.after)
    stops = {part for kind, part in gone + come if kind in CONTACTS}
    if len(stops) != 1:
        raise BranchError(f"{special.label}: {len(stops)} stops are grazed at once; a locus follows one")
    return stops.pop()


def holding(special: SpecialPoint) -> int:
    """Number of the friction that begins to hold at a reversal at a special point. Raises BranchError where
    sticks come or go in another way.
    """
    friction = held(special.before, special.after)
    if friction is None:
        raise BranchError(
            f"{special.label}: loci are followed where a reversal of one friction becomes a stick phase; "
            "here a sliding velocity touches zero, a stop comes to rest, or several things happen at once"
        )
    return friction


MOST_POINTS = 2000
WAYS = (1, -1)
FIRST = 0.01  # scaled length of the first step


@dataclass(frozen=True)
class LocusRecord:
    """A point of a locus; way, number, step, ended: as of `vibsim.orbits.branches.tracing.PointRecord`.

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


class Locus(OrbitCurve):
    """A locus: `locus["parameter"]`, `locus["second"]` and so on along it.

    plan : what was followed
    attrs : of its file

    >>> import vibsim
    >>> orbit = vibsim.orbit("I-C", {"omega": "4.2 Hz"}, period=1)
    >>> branch = vibsim.continue_branch(orbit, "omega", "4:4.3 Hz")
    >>> locus = vibsim.continue_locus(branch, {"c": "0.001:0.003 N s/m"}, label="PD1", max_points=4)
    >>> bool(float(locus.case_at(0).quantity("c").value) == locus["second"][0])
    True
    """

    plan: LocusPlan
    noun, _record = "locus", LocusRecord
    _shown = ("parameter", "second", "period")

    def __init__(
        self, plan: LocusPlan, points: Sequence[LocusRecord], attrs: Mapping[str, Any] | None = None
    ):
        self._place(plan, points, attrs)

    @cached_property
    def _scene(self) -> Any:
        return self.case.scene()

    @property
    def _followed(self) -> bool:
        return all(self.ends)

    def _declared(self) -> list[Dataset]:
        return locus_datasets(self.plan.branch.unit, self.plan.unit)

    @property
    def kind(self) -> str:
        """Of the bifurcation."""
        return self.plan.kind

    @property
    def ends(self) -> tuple[str, str]:
        """Reasons why it ends, at its first and its last point; empty where it was not followed further."""
        return (self.points[0].ended, self.points[-1].ended) if self.points else ("", "")

    def heading(self) -> str:
        """Name of the case, which bifurcation in which two parameters, and how many points."""
        return f"{locus_lines(self)[0][1]}, {counted(len(self), 'point')}"

    def lines(self) -> list[tuple[str, str]]:
        """Points, ends, and the names of the arrays."""
        return [*locus_lines(self)[1:], ("arrays", few(self.keys()))]

    def case_at(self, point: int) -> Any:
        """The case that runs one period on the orbit of a point."""
        return self.plan.plane().family_at(self.points[point].second).case_on(self.points[point].orbit)

    @cached_property
    def _arrays(self) -> dict[str, np.ndarray]:
        known = self._orbit_arrays
        return {
            "parameter": known["parameter"],
            "second": np.array([point.second for point in self.points]),
            **{name: known[name] for name in ("period", "state", "multipliers")},
            "index": np.array([point.index for point in self.points]),
        }


# A locus in words and as plain data.


def locus_lines(locus: Locus) -> list[tuple[str, str]]:
    """Lines (name, text) about a locus."""
    plan = locus.plan
    first, second = locus["parameter"], locus["second"]
    low, high = (end or "not followed further" for end in locus.ends)
    return [
        (
            "locus",
            f"{locus.case.name}: {locus.kind} {plan.label} in {plan.branch.keys[0]} and {plan.keys[0]}",
        ),
        ("points", str(len(locus))),
        ("from", _place(plan, first[0], second[0], low)),
        ("to", _place(plan, first[-1], second[-1], high)),
    ]


def _place(plan: LocusPlan, first: float, second: float, end: str) -> str:
    place = (
        f"{number(first, 8)} {plan.branch.unit}".rstrip()
        + f", {plan.keys[0]} = {number(second, 8)} {plan.unit}".rstrip()
    )
    return f"{place} ({end})"


def locus_facts(locus: Locus) -> dict[str, Any]:
    """A locus as plain data for JSON."""
    plan = locus.plan
    return {
        "case": locus.case.name,
        "kind": locus.kind,
        "label": plan.label,
        "keys": [plan.branch.keys[0], plan.keys[0]],
        "units": [plan.branch.unit, plan.unit],
        "periods": plan.branch.n,
        "ends": list(locus.ends),
        "points": [
            [float(one), float(other)] for one, other in zip(locus["parameter"], locus["second"], strict=True)
        ],
    }


# A locus followed both ways.


def trace_locus(plan: LocusPlan, keeper: Any, most: int = MOST_POINTS, watch: Any = None) -> bool:
    """Follow a locus both ways from where the `points` of `keeper` know it; its `add` is given each new one.

    watch : told the number of points; whether to go on. Returns whether it came to its ends or `most`
    points. Raises ContinuationError where the bifurcation is not found again.
    """
    plane = plan.plane()
    start, along = plan.start(plane)
    known, pair = keeper.points, plane.pair
    if not known:
        keeper.add([_record(start, along, 1, 0, FIRST)])
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
        for i, step in enumerate(walk(plane, here, direction, last.step, plan.spans), last.number + 1):
            keeper.add([_record(step.point, step.tangent, way, i, step.next, step.ended)])
            if watch is not None and not watch(len(known)):
                return False
            if i == last.number + room:
                break
    return True


def _record(
    point: PlanePoint, along: np.ndarray, way: int, number: int, step: float, ended: str = ""
) -> LocusRecord:
    orbit = orbit_record(Node(point.point, along[:-1], 0))
    places = tuple(point.z.tolist()), tuple(along.tolist())
    return LocusRecord(way, number, orbit, point.second, point.index, *places, step, ended)


# A locus in its file, and its store while it is followed.


def read_locus(path: str | Path) -> Locus:
    """The locus in a file, in which everything has been checked, with the points that wait in its journal.

    Raises ResultFileError.
    """
    return LocusStore.read(path)


def stored_locus(path: str | Path) -> Locus:
    """The locus in a file as it stands there. Raises ResultFileError."""
    path = Path(path)
    with opened(path, "locus") as file:
        attrs, plan = attributes_and_plan(path, file, LOCUS_ATTRIBUTES, LocusPlan)
        declared = locus_datasets(plan.branch.unit, plan.unit)
        values = read_datasets(path, file, declared, {POINT: attrs["points"]})
    with understood(path, "its points make no sense"):
        return Locus(plan, points_on_file(LocusRecord, values, attrs["points"]), attrs)


class LocusStore(CurveStore[LocusRecord, Locus]):
    """Points of a locus."""

    what, record, most = "locus", LocusRecord, MOST_POINTS
    stored = staticmethod(stored_locus)

    def take(self, record: LocusRecord) -> None:
        self.points.append(record)

    @property
    def curve(self) -> Locus:
        return Locus(self.plan, self.points, self.attrs)

    def trace(self, most: int, watch: Watch | None) -> bool:
        return trace_locus(self.plan, self, most, watch)

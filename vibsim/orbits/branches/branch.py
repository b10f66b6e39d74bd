"""A branch of periodic orbits: arrays by name along it, its special points, its file and its store."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vibsim.cases.problems import counted
from vibsim.cases.quantities import number
from vibsim.orbits.branches.curve import (
    ATTRIBUTES,
    POINT,
    SPECIAL,
    CurveStore,
    OrbitCurve,
    attributes_and_plan,
    columns_of,
    datasets_of,
    in_order,
    points_on_file,
    record_of,
)
from vibsim.orbits.branches.node import ENERGY
from vibsim.orbits.branches.plan import BranchPlan
from vibsim.orbits.branches.special_points import BIFURCATIONS, LABELS, UNRESOLVED
from vibsim.orbits.branches.tracing import (
    CLOSED,
    MOST_POINTS,
    BranchStep,
    OrbitRecord,
    PointRecord,
    SpecialRecord,
    Watch,
    trace,
)
from vibsim.orbits.stability import length_of
from vibsim.orbits.words import Word
from vibsim.results.file_contents import Column, Dataset
from vibsim.results.hdf5_reading import opened, read_datasets, understood
from vibsim.results.labelled import Arrays, few

# told of every point beside what its file holds
STABILITY = (
    Dataset("index", Column("1", "multipliers outside the unit circle", dtype="i1"), (POINT,)),
    Dataset("stable", Column(None, "stability", dtype="i1", flags={"unstable": 0, "stable": 1}), (POINT,)),
)
LEAVES = "leaves another branch"


@dataclass(frozen=True, repr=False)
class SpecialPoint:
    """A special point of a branch.

    Attributes
    ----------
    label : such as PD1, numbered along the branch
    kind : fold, doubling, neimark-sacker, grazing, ...
    between : numbers of the points of the branch on both sides
    before, after : words there, along the branch
    jump : how many more multipliers are outside the unit circle behind it
    """

    label: str
    kind: str
    orbit: OrbitRecord
    unknowns: tuple[float, ...]
    tangent: tuple[float, ...]
    between: tuple[int, int]
    before: Word
    after: Word
    jump: int

    @property
    def parameter(self) -> float:
        return self.orbit.parameter

    @property
    def period(self) -> float:
        """[s]"""
        return self.orbit.period

    @property
    def multipliers(self) -> np.ndarray:
        return np.array(self.orbit.multipliers)

    def __repr__(self) -> str:
        where = f"{self.kind} at {number(self.parameter, 10)}, period {self.period:.8g} s"
        return f"<SpecialPoint {self.label}: {where}, between points {self.between[0]} and {self.between[1]}>"


class Branch(OrbitCurve):
    """A branch: `branch["period"]` and so on along it, `branch.specials` on it.

    Attributes
    ----------
    plan : what was continued
    attrs : of its file

    >>> import vibsim
    >>> branch = vibsim.continue_branch("gallery/friction-oscillator", "drive.omega", "0.88:0.92 rad/s")
    >>> branch.key, branch.specials, bool(branch["period"].max() > 6.98)
    ('forces.drive.omega', [], True)
    """

    plan: BranchPlan
    noun, _record = "branch", PointRecord
    _shown = ("parameter", "period", "multiplier_re")

    def __init__(
        self,
        plan: BranchPlan,
        points: Sequence[PointRecord],
        specials: Sequence[SpecialRecord],
        attrs: Mapping[str, Any] | None = None,
    ):
        self._place(plan, points, attrs)
        self._records = (list(points), list(specials))

    @property
    def records(self) -> tuple[list[PointRecord], list[SpecialRecord]]:
        """Points and special points in the order in which they came."""
        return self._records

    @property
    def unit(self) -> str:
        """Of the parameter."""
        return self.plan.unit

    @property
    def key(self) -> str:
        """The key of the case that is varied."""
        return self.plan.keys[0]

    @cached_property
    def map(self) -> Any:
        """The return map at the start, which names the unknowns."""
        return self.plan.family().map(self.plan.parameter)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns on the section."""
        return tuple(self.map.coordinates.names)

    @property
    def closed(self) -> bool:
        """Whether it came back to its start."""
        return any(point.ended == CLOSED for point in self.points)

    @property
    def ends(self) -> tuple[str, str]:
        """Reasons why it ends, at its first and its last point; empty where it was not followed further."""
        forwards = [p for p in self.points if p.way > 0]
        backwards = [p for p in self.points if p.way < 0]
        last = forwards[-1].ended if forwards else ""
        first = backwards[0].ended if backwards else CLOSED if last == CLOSED else ""
        return (LEAVES if self.plan.heading else first), last

    @property
    def _scene(self) -> Any:
        return self.map.scene

    @property
    def _followed(self) -> bool:
        return self.closed or all(self.ends)

    def _declared(self) -> list[Dataset]:
        return datasets_of(self.unit)

    def _counts(self) -> dict[str, int]:
        unresolved = sum(one.kind == UNRESOLVED for one in self.specials)
        return {**super()._counts(), "special_points": len(self.specials), "unresolved": unresolved}

    def _file_attributes(self, complete: bool) -> dict[str, Any]:
        return {"names_json": json.dumps(self.names), "complete": int(complete), **self._counts()}

    def _file_values(self) -> dict[str, Any]:
        """Values of the datasets of its file, by name."""
        by_place = {record.unknowns: record for record in self._records[1]}
        records = [by_place[one.unknowns] for one in self.specials]
        return {
            **super()._file_values(),
            SPECIAL: np.arange(len(records)),
            **columns_of(SpecialRecord, records, self.spelled, "special_"),
            "special_label": [one.label for one in self.specials],
        }

    def arrays(self) -> Arrays:
        """Arrays of its file, by point, special point and multiplier; and the stability of each point."""
        declared = [*self._declared(), *STABILITY]
        values = self._file_values() | {each.name: self[each.name].astype("i1") for each in STABILITY}
        return Arrays.of_values(declared, values, (POINT,), self.attrs, self._shown)

    def heading(self) -> str:
        """Name of the case, what was continued over what, and how many points."""
        what = branch_lines(self)[0][1]
        special = counted(len(self.specials), "special point")
        return f"{what}, {counted(len(self), 'point')}, {special}"

    def lines(self) -> list[tuple[str, str]]:
        """Points, ends, special points, and the names of the arrays."""
        special = few(
            f"{one.label} at {number(one.parameter, 6)} {self.unit}".strip() for one in self.specials
        )
        return [*branch_lines(self)[1:], ("special", special or "none"), ("arrays", few(self.keys()))]

    def case_at(self, point: int) -> Any:
        """The case that runs one period on the orbit of a point."""
        return self.plan.family().case_on(self.points[point].orbit)

    @cached_property
    def _arrays(self) -> dict[str, np.ndarray]:
        known, orbits = self._orbit_arrays, [point.orbit for point in self.points]
        arrays = {
            **{name: known[name] for name in ("parameter", "period", "multipliers")},
            "index": np.array([orbit.index for orbit in orbits]),
            "stable": np.array([self._stable(orbit) for orbit in orbits]),
            "word": np.array([self.spelled(orbit.word) for orbit in orbits], dtype=object),
            "arclength": self._arclength(),
            "dp_ds": np.array([point.way * point.tangent[-1] for point in self.points]),
            **{name: known[name] for name in ("drift", "fold", "doubling", "margin", "residual")},
        }
        states = known["state"].reshape(len(orbits), -1)
        return arrays | {name: states[:, i] for i, name in enumerate(self.names)}

    def _stable(self, orbit: OrbitRecord) -> bool:
        """Whether nothing grows; where energy is kept nothing decays either."""
        return orbit.index == 0 if self.key == ENERGY else orbit.stable

    def _arclength(self) -> np.ndarray:
        places = np.array([point.unknowns for point in self.points])
        steps = np.array([length_of(step) for step in np.diff(places, axis=0)])
        return np.concatenate([[0.0], np.cumsum(steps)])

    @cached_property
    def specials(self) -> list[SpecialPoint]:
        """The special points along the branch."""
        place = {(point.way, point.number): i for i, point in enumerate(self.points)}
        place[-1, 0] = place[1, 0]
        backwards = [record for record in reversed(self._records[1]) if record.way < 0]
        forwards = [record for record in self._records[1] if record.way > 0]
        backwards.sort(key=lambda record: -record.number)
        forwards.sort(key=lambda record: record.number)
        counts: Counter[str] = Counter()
        specials = []
        for record in (*backwards, *forwards):
            counts[record.kind] += 1
            ends = sorted((place[record.way, record.number - 1], place[record.way, record.number]))
            before, after = (record.before, record.after)[:: record.way]
            specials.append(
                SpecialPoint(
                    f"{LABELS[record.kind]}{counts[record.kind]}",
                    record.kind,
                    record.orbit,
                    record.unknowns,
                    record.tangent,
                    (ends[0], ends[1]),
                    before,
                    after,
                    record.way * record.jump,
                )
            )
        return specials

    def special(self, label: str) -> SpecialPoint:
        """The special point of a label. Raises KeyError with the labels that there are."""
        for one in self.specials:
            if one.label == label:
                return one
        listed = ", ".join(one.label for one in self.specials) or "none"
        raise KeyError(f"{label} is not on this branch; its special points are {listed}")


# A branch in words and as plain data: what it is, and its special points.


DIGITS = 12  # of a parameter: special points are located to 1e-11 of it


def branch_lines(branch: Branch) -> list[tuple[str, str]]:
    """Lines (name, text) about a branch."""
    low, high = reach(branch)
    span = f"{branch.key} from {number(low, 6)} to {number(high, 6)} {branch.unit}".rstrip()
    count = int(branch["stable"].sum())
    stable = "without a multiplier outside the unit circle" if branch.key == ENERGY else "stable"
    turns = counted(branch.plan.n, branch.map.section.of_return.partition(" ")[0])
    lines = [
        ("branch", f"{branch.case.name}: orbits of {turns} over {span}"),
        ("points", f"{len(branch)}, {count} of them {stable}"),
        ("ends", _ends(branch)),
    ]
    if branch.key == ENERGY:
        lines.append(("frequency", frequencies(branch)))
    unresolved = [one for one in branch.specials if one.kind == UNRESOLVED]
    where = ", ".join(f"{number(one.parameter, 8)}" for one in unresolved)
    held = "holds everywhere" if not unresolved else f"does not hold at {where} {branch.unit}".rstrip()
    return [*lines, ("index check", held)]


def frequencies(branch: Branch) -> str:
    """Of its first and its last orbit."""
    rates = 1.0 / branch["period"]
    return f"{number(rates[0], 8)} Hz at the least energy, {number(rates[-1], 8)} Hz at the greatest"


def reach(branch: Branch) -> tuple[float, float]:
    """Least and greatest parameter of a branch, its folds included."""
    values = [*branch["parameter"].tolist(), *(one.parameter for one in branch.specials)]
    return min(values), max(values)


def _ends(branch: Branch) -> str:
    if branch.closed:
        return "none: it is closed"
    first, last = (end or "not followed further" for end in branch.ends)
    return first if first == last else f"{first}; {last}"


def special_table(branch: Branch) -> list[tuple[str, ...]]:
    """A row of texts per special point: label, kind, parameter, period, change of the index, word."""
    return [
        (
            one.label,
            one.kind,
            f"{one.parameter:.{DIGITS}g} {branch.unit}".rstrip(),
            f"{one.period:.8g} s",
            f"{one.jump:+d} outside" if one.kind in BIFURCATIONS or one.jump else "",
            _words(branch, one),
        )
        for one in branch.specials
    ]


def _words(branch: Branch, one: SpecialPoint) -> str:
    before, after = branch.spelled(one.before), branch.spelled(one.after)
    return before if before == after else f"{before} > {after}"


def facts(branch: Branch) -> dict[str, Any]:
    """A branch as plain data for JSON."""
    return {
        "case": branch.case.name,
        "key": branch.key,
        "unit": branch.unit,
        "periods": branch.plan.n,
        "points": len(branch),
        "stable_points": int(branch["stable"].sum()),
        "closed": branch.closed,
        "ends": list(branch.ends),
        "parameter_from": reach(branch)[0],
        "parameter_to": reach(branch)[1],
        "unresolved": [one.parameter for one in branch.specials if one.kind == UNRESOLVED],
        "special_points": [special_facts(branch, one) for one in branch.specials],
    }


def special_facts(branch: Branch, one: SpecialPoint) -> dict[str, Any]:
    """A special point as plain data for JSON."""
    return {
        "label": one.label,
        "kind": one.kind,
        "parameter": branch.key,
        "value": one.parameter,
        "period": one.period,
        "word": branch.spelled(one.orbit.word),
        "before": branch.spelled(one.before),
        "after": branch.spelled(one.after),
        "jump": one.jump,
        "state": dict(zip(branch.names, one.orbit.state, strict=True)),
        "multipliers": [[mu.real, mu.imag] for mu in one.orbit.multipliers],
    }


# A branch in its file, and its store while it is followed.


def read_branch(path: str | Path) -> Branch:
    """The branch in a file, in which everything has been checked, with the points that wait in its journal.

    Raises ResultFileError.
    """
    return BranchStore.read(path)


def stored_branch(path: str | Path) -> Branch:
    """The branch in a file as it stands there. Raises ResultFileError."""
    path = Path(path)
    with opened(path, "branch") as file:
        attrs, plan = attributes_and_plan(path, file, ATTRIBUTES, BranchPlan)
        lengths = {POINT: attrs["points"], SPECIAL: attrs["special_points"]}
        values = read_datasets(path, file, datasets_of(plan.unit), lengths)
    with understood(path, "its points make no sense"):
        points = points_on_file(PointRecord, values, attrs["points"])
        specials = [record_of(SpecialRecord, values, i, "special_") for i in range(attrs["special_points"])]
        branch = Branch(plan, points, in_order(specials), attrs)
        len(branch.specials)
    return branch


class BranchStore(CurveStore[BranchStep, Branch]):
    """Points of a branch, and its special points."""

    what, record, most = "branch", BranchStep, MOST_POINTS
    stored = staticmethod(stored_branch)

    def make_memory(self) -> None:
        super().make_memory()
        self.specials: list[SpecialRecord] = []

    def take(self, record: BranchStep) -> None:
        self.points.append(record.point)
        self.specials += record.specials

    def take_curve(self, there: Branch) -> None:
        super().take_curve(there)
        self.specials = there.records[1]

    def difference(self, there: Branch) -> str:
        ours, theirs = self.plan.settings, there.plan.settings
        named = [name for name in ours if ours[name] != theirs[name]]
        named += ["case"] if there.case.sha256 != self.plan.case.sha256 else []
        return f". It differs in {', '.join(named)}"

    @property
    def curve(self) -> Branch:
        return Branch(self.plan, self.points, self.specials, self.attrs)

    def trace(self, most: int, watch: Watch | None) -> bool:
        return trace(self.plan, self, most, watch)

"""The attractors of a sweep: labels of its points gathered, numbered, counted, and followed over parameters.

At every combination of the parameters (all that is swept but initial values) runs that end on one orbit have
one attractor: whichever of its points the section shows, and whether it is the orbit or its mirror image.
Sets that are not periodic are one where their observables agree, see `_joined_sets`. Attractors of a
combination are numbered by their shares, the largest first. From one value of a parameter to the next an
orbit is followed by Newton's method: what is found again has the same branch.

All follows from the labels of the points and their order on the grid alone, not from the order in which they
were computed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import nan, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.analysis.attractor import is_mirrored, lies_on
from vibsim.engine.errors import EngineError
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.coordinates import OrbitError, placed
from vibsim.orbits.newton import solve
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.return_map import ReturnMap
from vibsim.orbits.search import least
from vibsim.orbits.words import spelled
from vibsim.physics.parts import GROUND
from vibsim.results.file_contents import Column, Dataset
from vibsim.sweeps.attractor_labels import coordinates_of, orbit_of_label
from vibsim.sweeps.quantities import DONE, INITIAL, KINDS, NAME, NONE
from vibsim.sweeps.sweep_plan import is_of_starts

if TYPE_CHECKING:
    from vibsim.sweeps.points import Table
    from vibsim.sweeps.sweep_plan import Index, SweepPlan

SAME_SET = 7.0  # standard errors between observables of one set, at most: Student's t at 1e-6 with 18 degrees
ALIKE = 0.01  # of an observable: sets that differ by less in all of them are not told apart
REST_REACH = 8.0  # half widths of what is left of two motions that come to one rest
STEPS_BETWEEN = (1, 4, 16)  # to the next value of a parameter: more where Newton does not get there
GROUP = "attractors"
NUMBER, UNKNOWN, BODY = "number", "unknown_of_orbit", "body"
COLUMNS = {
    "kind": Column("1", "what it is", dtype="i1", flags=KINDS),
    "period": Column("1", "source periods, turns or swings; 0 at rest, -1 not periodic", dtype="i8"),
    "largest_multiplier": Column("1", "greatest modulus of its multipliers; NaN where it is no orbit"),
    "count": Column("1", "points that end on it", dtype="i8"),
    "share": Column("1", "share of the points at its parameters that were computed"),
    "share_error": Column("1", "standard error of the share, sqrt(s (1 - s) / n)"),
    "share_mirror": Column("1", "share of those that end on its mirror image"),
    "point": Column("1", "number of its combination of parameters, in the order of the axes", dtype="i8"),
    "branch": Column("1", "what its orbit belongs to over the parameter, from 0", dtype="i8"),
    "word": Column(None, "events of its orbit, in letters", dtype="text"),
}
OVER_UNKNOWNS = Column("1", "a state of it on the section, by the unknowns of its orbits, SI")
OVER_BODIES = "half of the way from the least to the greatest displacement of each body"


@dataclass(frozen=True, eq=False)
class Attractors:
    """The attractors of a sweep.

    labels : number of the attractor of each point (shape of the sweep); -1: undecided, or not computed
    mirrored : 1 where it is the mirror image (shape)
    columns : by name of COLUMNS (k), and `state` (k, unknowns), `amplitude` (k, bodies)
    """

    labels: np.ndarray
    mirrored: np.ndarray
    columns: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.columns["kind"])

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    def words(self, i: int) -> str:
        """Kind, period and largest multiplier of one."""
        kind = next(name for name, code in KINDS.items() if code == self["kind"][i])
        if kind != "periodic":
            return kind
        return f"period {self['period'][i]}, multiplier {self['largest_multiplier'][i]:.3g}"


def datasets_of_attractors(unknowns: tuple[str, ...], units: Sequence[str]) -> list[Dataset]:
    """Datasets of the group of attractors; unknowns : names; units : of the displacement of each body."""
    path = GROUP + "/"
    unit, of_each = (units[0], "") if len(set(units)) == 1 else ("1", f", SI: in {', '.join(units)}")
    amplitudes = Column(unit, f"{OVER_BODIES}{of_each}")
    scales = {
        NUMBER: Column("1", "number of the attractor", dtype="i8"),
        BODY: Column("1", "number of the body", dtype="i8"),
    }
    datasets = [Dataset(path + name, column, (name,)) for name, column in scales.items()]
    datasets += [Dataset(path + name, column, (NUMBER,), gaps=True) for name, column in COLUMNS.items()]
    datasets.append(Dataset(path + "amplitude", amplitudes, (NUMBER, BODY), gaps=True))
    if unknowns:
        named = Column(None, "unknown of the orbits", dtype="text")
        datasets.insert(0, Dataset(path + UNKNOWN, named, (UNKNOWN,)))
        datasets.append(Dataset(path + "state", OVER_UNKNOWNS, (NUMBER, UNKNOWN), gaps=True))
    return datasets


def values_of_group(found: Attractors, unknowns: tuple[str, ...], bodies: int) -> dict[str, Any]:
    """Values of the group of attractors, by path."""
    values = {NUMBER: np.arange(len(found)), BODY: np.arange(bodies), **found.columns}
    if unknowns:
        values[UNKNOWN] = np.array(unknowns, dtype=object)
    return {f"{GROUP}/{name}": value for name, value in values.items()}


# The attractors at one combination of parameters.


@dataclass(eq=False)
class _Found:
    """One attractor while it is gathered: rows of points among those of its combination, by which side."""

    kind: str
    rows: list[int]
    mirrored: list[int] = field(default_factory=list)
    state: np.ndarray = field(default_factory=lambda: np.empty(0))
    period: float = nan
    multiplier: float = nan
    orbit: Orbit | None = None

    @property
    def count(self) -> int:
        return len(self.rows) + len(self.mirrored)


class _Combination:
    """Points of one combination of parameters, in the order of the grid.

    scene : theirs, whatever its start; columns : of labels, by name (n, ...)
    """

    def __init__(self, scene: Any, columns: Mapping[str, np.ndarray]) -> None:
        self._scene, self._columns = scene, columns
        self._kinds = columns["attractor_kind"]

    def found(self) -> list[_Found]:
        """Its attractors, that of the largest share first."""
        every = [*self._orbits(), *self._rests(), *self._sets()]
        return sorted(every, key=lambda one: (-one.count, min(one.rows + one.mirrored)))

    def _rows(self, kind: str) -> np.ndarray:
        return np.flatnonzero(self._kinds == KINDS[kind])

    def _orbits(self) -> list[_Found]:
        rows = self._rows("periodic")
        states = self._columns["attractor_state"][rows]
        periods = self._columns["attractor_period"][rows]
        keys = np.column_stack([periods, states]) if len(rows) else np.empty((0, 1))
        _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        found: list[_Found] = []
        for group in np.argsort(first, kind="stable").tolist():
            members = rows[np.ravel(inverse) == group].tolist()
            self._take(found, members, states[first[group]], float(periods[first[group]]))
        return found

    def _take(self, found: list[_Found], members: list[int], state: np.ndarray, period: float) -> None:
        """Add points of one label to the attractor that it belongs to, or as a new one."""
        for one in found:
            if one.period != period or one.orbit is None:
                continue
            if lies_on(one.orbit, state):
                one.rows += members
                return
            if is_mirrored(one.orbit, state):
                one.mirrored += members
                return
        try:
            orbit = orbit_of_label(self._scene, state, period)
        except (OrbitError, EngineError):
            orbit = None
        multiplier = float(self._columns["attractor_multiplier"][members[0]])
        found.append(_Found("periodic", members, [], state, period, multiplier, orbit))

    def _rests(self) -> list[_Found]:
        """Rests apart from each other by more than what is left of the motions; one where friction holds.
        Those whole turns apart, as of a pendulum, are one.
        """
        rows = self._rows("rest")
        at = coordinates_of(self._scene) if len(rows) else None
        found: list[tuple[_Found, np.ndarray]] = []
        for row in rows.tolist():
            state, width = (self._columns[name][row] for name in ("attractor_state", "attractor_errors"))
            width = width[-len(state) :] if len(state) else width[:0]
            if at is not None and len(state):
                state = at.in_turn_of(state.copy(), np.zeros(len(state)))
            near = (
                one
                for one, other in found
                if np.all(np.abs(one.state - state) <= REST_REACH * (width + other) + 1e-9)
            )
            one = next(near, None)
            if one is None:
                found.append((_Found("rest", [row], [], state, 0.0), width))
            else:
                one.rows.append(row)
        return [one for one, _ in found]

    def _sets(self) -> list[_Found]:
        found = []
        for kind in ("quasi-periodic", "chaotic", "turning", "running away"):
            rows = self._rows(kind)
            groups = [rows.tolist()] if len(rows) else []
            if kind != "running away":
                groups = self._joined_sets(rows)
            found += [
                _Found(kind, group, [], self._columns["attractor_state"][group[0]], float(NONE))
                for group in groups
            ]
        return found

    def _joined_sets(self, rows: np.ndarray) -> list[list[int]]:
        """Rows of runs on one set each: the observables of each are those of the first of them, within
        SAME_SET standard errors of the difference or a share ALIKE of their size.
        """
        means, errors = (self._columns[f"attractor_{name}"] for name in ("means", "errors"))
        groups = []
        while len(rows):
            first = rows[0]
            apart = np.abs(means[rows] - means[first])
            doubt = SAME_SET * np.sqrt(errors[rows] ** 2 + errors[first] ** 2)
            alike = ALIKE * (np.abs(means[rows]) + np.abs(means[first]))
            same = np.all(apart <= np.maximum(doubt, alike), axis=1)
            same[0] = True
            groups.append(rows[same].tolist())
            rows = rows[~same]
        return groups


# All combinations, and what of them goes on from one value of a parameter to the next.


def gather(plan: SweepPlan, table: Table) -> Attractors:
    """The attractors of a sweep, from the labels of its points."""
    labels = np.full(plan.shape, NONE, dtype="i8")
    mirrored = np.zeros(plan.shape, dtype="i8")
    rows: list[tuple[int, _Found, int, Any]] = []
    following: dict[int, list[int]] = {}
    for number, (indices, scene) in enumerate(_combinations(plan)):
        where = tuple(np.array(indices).T)
        columns = {name: table.column(name)[where] for name in plan.columns if name.startswith(NAME)}
        done = int(np.count_nonzero(table.status[where] == DONE))
        following[number] = []
        for one in _Combination(scene, columns).found():
            for members, side in ((one.rows, 0), (one.mirrored, 1)):
                for member in members:
                    labels[indices[member]], mirrored[indices[member]] = len(rows), side
            following[number].append(len(rows))
            rows.append((number, one, done, scene))
    branches = _branches(plan, following, rows)
    return Attractors(labels, mirrored, _columns(plan, rows, branches))


def parameter_axes(plan: SweepPlan) -> list[int]:
    """Positions of the axes along which more than initial values change."""
    return [i for i, axis in enumerate(plan.axes) if not is_of_starts(axis)]


def _combinations(plan: SweepPlan) -> Iterator[tuple[list[Index], Any]]:
    """Indices of the points of each combination, in order, and the scene of one of them."""
    parameters = parameter_axes(plan)
    others = [i for i in range(len(plan.shape)) if i not in parameters]
    for fixed in np.ndindex(*(plan.shape[i] for i in parameters)):
        indices = []
        for free in np.ndindex(*(plan.shape[i] for i in others)):
            place = [0] * len(plan.shape)
            for i, k in (*zip(parameters, fixed, strict=True), *zip(others, free, strict=True)):
                place[i] = k
            indices.append(tuple(place))
        yield indices, _scene_at(plan, indices[0])


def _scene_at(plan: SweepPlan, index: Index) -> Any:
    """The scene of a combination; None where its case is not allowed."""
    changes = {k: v for k, v in plan.changes(index).items() if not k.startswith(INITIAL)}
    try:
        return plan.case.with_values(changes).scene()
    except ValueError:
        return None


def _branches(
    plan: SweepPlan,
    following: Mapping[int, list[int]],
    rows: list[tuple[int, _Found, int, Any]],
) -> list[int]:
    """Number of the branch of every attractor; each its own where not exactly one parameter is swept."""
    parameters = parameter_axes(plan)
    branches = list(range(len(rows)))
    if len(parameters) != 1:
        return branches
    order = np.argsort(plan.axes[parameters[0]].numbers(), kind="stable").tolist()
    for before, after in pairwise(order):
        free = list(following[after])
        for i in following[before]:
            j = _continued(plan, (before, after), rows[i][1], [(k, rows[k][1]) for k in free])
            if j is not None:
                branches[j] = branches[i]
                free.remove(j)
    return [sorted(set(branches)).index(branch) for branch in branches]


def _continued(
    plan: SweepPlan, ends: tuple[int, int], one: _Found, others: list[tuple[int, _Found]]
) -> int | None:
    """Number of the attractor behind a step of the parameter that goes on an attractor before it."""
    if one.orbit is None:
        alike = [k for k, other in others if other.kind == one.kind]
        return alike[0] if len(alike) == 1 and one.kind != "periodic" else None
    for steps in STEPS_BETWEEN:
        orbit = _followed(plan, ends, one.orbit, steps)
        found = next((k for k, other in others if orbit and _is_one(orbit, other.orbit)), None)
        if found is not None:
            return found
    return None


def _is_one(orbit: Orbit, other: Orbit | None) -> bool:
    """Whether two orbits of a scene, or one and the mirror image of the other, are one."""
    if other is None or other.n != orbit.n:
        return False
    return lies_on(other, orbit.X) or is_mirrored(other, orbit.X)


def _followed(plan: SweepPlan, ends: tuple[int, int], orbit: Orbit, steps: int) -> Orbit | None:
    """An orbit at the next value of the parameter, by Newton's method in so many steps, as long as it stays
    stable; None where it does not get there.
    """
    there: Orbit | None = orbit
    for step in range(1, steps + 1):
        there = _moved(plan, ends, step / steps, there) if there and there.stable else None
    return there


def _moved(plan: SweepPlan, ends: tuple[int, int], share: float, orbit: Orbit) -> Orbit | None:
    """The orbit near another at a share of the way between two values of the parameter."""
    axis = plan.axes[parameter_axes(plan)[0]]
    first, last = (axis.numbers()[end] for end in ends)
    value = f"{float(first + share * (last - first))!r} {axis.unit}".strip()
    changes = axis.changes(ends[1]) if share == 1.0 else dict.fromkeys(axis.keys, value)
    try:
        return_map = ReturnMap(plan.case.with_values(changes).scene(), orbit.n)
        T = None if return_map.section.timed else orbit.period
        return least(Orbit(return_map, solve(return_map, orbit.X, T)))
    except (ValueError, EngineError):
        return None


def _columns(
    plan: SweepPlan, rows: list[tuple[int, _Found, int, Any]], branches: list[int]
) -> dict[str, np.ndarray]:
    """The columns of the group."""
    unknowns, bodies = plan.length_of("unknown"), len(plan.case.scene().line)
    columns: dict[str, list[Any]] = {name: [] for name in (*COLUMNS, "state", "amplitude")}
    for (number, one, done, scene), branch in zip(rows, branches, strict=True):
        share = one.count / done
        values = {
            "kind": KINDS[one.kind],
            "period": int(one.period),
            "largest_multiplier": one.multiplier,
            "count": one.count,
            "share": share,
            "share_error": sqrt(max(share * (1 - share), 0.0) / done),
            "share_mirror": len(one.mirrored) / done,
            "point": number,
            "branch": branch,
            "word": spelled(scene, one.orbit.word) if one.orbit else "",
            "state": one.state,
            "amplitude": _amplitudes(one.orbit, bodies),
        }
        for name, value in values.items():
            columns[name].append(value)
    arrays = {name: np.array(columns[name], dtype=_dtype(column)) for name, column in COLUMNS.items()}
    arrays["state"] = np.array(columns["state"], dtype="f8").reshape(len(rows), unknowns)
    arrays["amplitude"] = np.array(columns["amplitude"], dtype="f8").reshape(len(rows), bodies)
    return arrays


def _dtype(column: Column) -> Any:
    return object if column.dtype == "text" else column.dtype


def _amplitudes(orbit: Orbit | None, bodies: int) -> list[float]:
    """Half of the peak-to-peak displacement of each body over an orbit [m]; NaN of anything else."""
    if orbit is None:
        return [nan] * bodies
    scene = placed(orbit.scene, orbit.state, orbit.period).without_samples()
    run = open_trajectory(scene, extremes=([(i, GROUND) for i in range(bodies)], 0.0))
    for _ in run.blocks():
        pass
    least_places, greatest, _ = run.extremes
    return [(high - low) / 2 for low, high in zip(least_places[:bodies], greatest[:bodies], strict=True)]

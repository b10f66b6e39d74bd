"""Births and deaths of the attractors of a sweep over a parameter, and the bifurcations behind them.

An attractor is followed from point to point of the parameter (`branch` of `vibsim.sweeps.attractors`).
Between the last point that has it and the next that has not, the cause is located: of an orbit by the
continuation of its branch (`vibsim.orbits.branches`), up to where it loses its stability; of a state of
rest by bisection of the greatest growth rate; of a chaotic or quasi-periodic set by bisection of runs that
begin on it, and then the saddle on the boundary of its basin is found. A boundary crisis is where the set
meets that saddle (C. Grebogi, E. Ott and J. A. Yorke, Crises, sudden changes in chaotic attractors, and
transient chaos, Physica D 7 (1983) 181-200): its distance to the saddle is told. Births are deaths in the
other direction.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.cases.quantities import decimal_text, number
from vibsim.engine.errors import EngineError
from vibsim.orbits.branches.branch import Branch
from vibsim.orbits.branches.continuing import continue_branch
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.interpolant import JOINS
from vibsim.orbits.branches.special_points import NAMES
from vibsim.orbits.branches.walk import END
from vibsim.orbits.coordinates import Coordinates, OrbitError, placed
from vibsim.orbits.newton import course_of
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.stability import eigenvalues
from vibsim.sweeps.attractor_labels import coordinates_of, orbit_of_label
from vibsim.sweeps.attractors import parameter_axes
from vibsim.sweeps.axes import Axis
from vibsim.sweeps.basin_edges import BasinEdge, edge_between, rest_near, stretched
from vibsim.sweeps.basin_starts import NOWHERE, Basins, Stepping
from vibsim.sweeps.quantities import KINDS
from vibsim.sweeps.sweep_plan import PlanError

if TYPE_CHECKING:
    from vibsim.cases import Case
    from vibsim.sweeps.sweep_result import SweepResult

HALVINGS = 12  # of the interval of the parameter in which a set vanishes
FINE = 40  # of that in which a state of rest loses its stability
NEAR_REST = 0.5  # of its size: how far a state of rest may move from one value to the next
BEFORE = 0.01  # of the way between two values of the sweep: where the set is still sure to be there
RETURNS = 256  # of a set, among which the nearest to the saddle is looked for


@dataclass(frozen=True)
class AttractorChange:
    """The birth or death of one attractor.

    attractor : number of it at the last point that has it; branch : its branch
    birth : whether the parameter rises into it, not out of it
    present, absent : values of the parameter of the last point with it and the next one without
    cause : what happens there, in words; parameter : where, NaN where that is not known
    """

    attractor: int
    branch: int
    birth: bool
    present: float
    absent: float
    cause: str
    parameter: float
    unit: str

    def line(self, words: str) -> tuple[str, str]:
        """Label and text of it; words : of its attractor."""
        low, high = sorted((self.present, self.absent))
        where = f"between {number(low, 6)} and {number(high, 6)} {self.unit}".strip()
        if isfinite(self.parameter):
            where = f"at {number(self.parameter, 10)} {self.unit}".strip()
        return "born" if self.birth else "dies", f"branch {self.branch}, {words}, {where}: {self.cause}"

    def plain(self) -> dict[str, Any]:
        """As plain data for JSON."""
        facts = asdict(self)
        return facts | {"parameter": self.parameter if isfinite(self.parameter) else None}


def attractor_changes(sweep: SweepResult) -> list[AttractorChange]:
    """Births and deaths of the attractors of a sweep over one parameter, from its least value upwards.

    Raises PlanError for a sweep over anything else.
    """
    parameters = parameter_axes(sweep.plan)
    axis = sweep.axes[parameters[0]] if len(parameters) == 1 else None
    if not isinstance(axis, Axis):
        raise PlanError("births and deaths of attractors are those of a sweep over one parameter")
    changes = _Changes(sweep, axis)
    found = [
        change for branch in sorted(set(sweep.attractors["branch"])) for change in changes.of(int(branch))
    ]
    return sorted(found, key=lambda change: (min(change.present, change.absent), change.attractor))


class _Changes:
    """The changes of one sweep."""

    def __init__(self, sweep: SweepResult, axis: Axis) -> None:
        self.sweep, self.axis = sweep, axis
        self.attractors = sweep.attractors
        self.order = np.argsort(axis.numbers(), kind="stable").tolist()

    def of(self, branch: int) -> Iterator[AttractorChange]:
        """Those of one branch."""
        rows = np.flatnonzero(self.attractors["branch"] == branch).tolist()
        at = {self.order.index(int(self.attractors["point"][i])): i for i in rows}
        for place, i in sorted(at.items()):
            for step in (-1, 1):
                beside = place + step
                if beside not in at and 0 <= beside < len(self.order):
                    yield self._change(branch, i, self.order[place], self.order[beside], step < 0)

    def _change(self, branch: int, i: int, present: int, absent: int, birth: bool) -> AttractorChange:
        kind = next(name for name, code in KINDS.items() if code == self.attractors["kind"][i])
        where, cause = (
            nan,
            "motions that run away: see the attractors that end or begin there",
        )
        try:
            if kind == "periodic":
                where, cause = self._of_orbit(i, present, absent)
            elif kind == "rest":
                where, cause = self._of_rest(i, present, absent)
            elif kind in ("chaotic", "quasi-periodic"):
                where, cause = self._of_set(i, kind, present, absent)
        except (OrbitError, EngineError, ContinuationError, ValueError) as error:
            cause = f"not located: {error}"
        numbers = self.axis.numbers()
        ends = float(numbers[present]), float(numbers[absent])
        return AttractorChange(i, branch, birth, *ends, cause, where, self.axis.unit)

    def _case(self, value: float) -> Case:
        """The case at a value of the parameter, whatever its start."""
        text = f"{value!r} {self.axis.unit}".strip()
        return self.sweep.case.with_values(dict.fromkeys(self.axis.keys, text))

    # Orbits: continuation of the branch.

    def _of_orbit(self, i: int, present: int, absent: int) -> tuple[float, str]:
        case = self.sweep.case.with_values(self.axis.changes(present))
        state, period = self.attractors["state"][i], float(self.attractors["period"][i])
        orbit = orbit_of_label(case.scene(), state, period, case)
        assert orbit is not None
        low, high = sorted(self.axis.values[k] for k in (present, absent))
        span = f"{decimal_text(low)}:{decimal_text(high)} {self.axis.unit}".strip()
        branch = continue_branch(orbit, "=".join(self.axis.keys), span)
        return _first_loss(branch, orbit)

    # Rest: the greatest growth rate.

    def _of_rest(self, i: int, present: int, absent: int) -> tuple[float, str]:
        numbers = self.axis.numbers()
        low, high = float(numbers[present]), float(numbers[absent])
        state = np.array(self.attractors["state"][i])
        growth, oscillates = nan, False
        at_end = self._growth(high, state)
        if at_end is not None and at_end[0] <= 0:
            return nan, "the state of rest is stable on: no start of the sweep ends on it there"
        for _ in range(FINE):
            middle = (low + high) / 2
            there = self._growth(middle, state)
            if there is not None:
                growth, oscillates = there[:2]
            if there is None or growth > 0:
                high = middle
            else:
                low, state = middle, there[2]
        if not isfinite(growth):
            return (low + high) / 2, "the state of rest goes"
        word = "a Hopf point" if oscillates else "a growth rate that passes 0"
        return (low + high) / 2, word

    def _growth(self, value: float, state: np.ndarray) -> tuple[float, bool, np.ndarray] | None:
        """Greatest |multiplier| less 1 over a stretch, whether it oscillates, and where the state of rest
        near a state is, by the unknowns; None where there is none.
        """
        stepping = Stepping(self._case(value).scene())
        start = stepping.at.lifted(state)
        rest = rest_near(stepping, start, max(stepping.size(start), 1e-9), NEAR_REST)
        if rest is None:
            return None
        first = max(eigenvalues(stretched(stepping, rest)[1]), key=abs)
        return abs(first) - 1, abs(first.imag) > 1e-9 * abs(first), stepping.at.of(rest)

    # Sets: runs that begin on them.

    def _of_set(self, i: int, kind: str, present: int, absent: int) -> tuple[float, str]:
        numbers = self.axis.numbers()
        low, high = float(numbers[present]), float(numbers[absent])
        at = coordinates_of(self.sweep.case.scene())
        assert at is not None
        state = np.array(self.attractors["state"][i])
        goes_to: np.ndarray | None = None
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            basins = Basins(self._case(middle))
            end = basins.end_of(at.state(state))
            if end == NOWHERE or basins.ends[end].label.kind == kind:
                low = middle
                state = basins.ends[end].label.state if end != NOWHERE else state
            else:
                high, goes_to = middle, basins.ends[end].label.state
        if goes_to is None:
            return nan, f"the {kind} set is there on: no start of the sweep ends on it there"
        first = np.array(self.attractors["state"][i])
        before = low + BEFORE * (float(numbers[present]) - float(numbers[absent]))
        met = self._crisis(before, (state, first), goes_to)
        cause = f"a boundary crisis ({met})" if met else f"runs on the {kind} set leave it"
        return (low + high) / 2, cause

    def _crisis(self, value: float, states: tuple[np.ndarray, ...], goes_to: np.ndarray) -> str:
        """Distance of the set from the saddle of its boundary, in words; empty where none is found.

        value : of the parameter, a little before the set goes; states : on the set
        """
        case = self._case(value)
        at = coordinates_of(case.scene())
        assert at is not None
        for state in states:
            try:
                edge = edge_between(Basins(case), at.state(state), at.state(goes_to))
            except (OrbitError, EngineError):
                continue
            return self._met(case, at, state, edge)
        return ""

    def _met(self, case: Case, at: Coordinates, state: np.ndarray, edge: BasinEdge) -> str:
        """The saddle, and the distance to it of the returns of a set."""
        saddle = edge.orbit
        if saddle is None:
            return "on its boundary is a state of rest"
        course = course_of(placed(case.scene(), at.state(state), 0.0), at, more=RETURNS)
        apart = np.abs((course.points[:, None, :] - saddle.points[None, :, :]) * at.weights).max(axis=2).min()
        size = float((np.ptp(course.points, axis=0) * at.weights).max())
        share = float(apart) / size if size else nan
        text = f"the set comes within {number(share, 2)} of its size to the saddle"
        return f"{text} of period {saddle.n}, multiplier {number(float(saddle.multipliers[0].real), 4)}"


def _first_loss(branch: Branch, orbit: Orbit) -> tuple[float, str]:
    """Parameter and words of the first special point at which a branch loses its stability, from a stable
    orbit of it on.
    """
    stable = branch["stable"]
    apart = [float(np.abs(np.array(point.orbit.state) - orbit.X).max()) for point in branch.points]
    begin = int(np.argmin(apart))
    forwards = begin < len(stable) / 2
    way = range(begin, len(stable)) if forwards else range(begin, -1, -1)
    lost = next((k for k in way if not stable[k]), None)
    if lost is None:
        end = branch.ends[1 if forwards else 0]
        if end.startswith(JOINS):
            last = float(branch["parameter"][-1 if forwards else 0])
            return last, f"a doubling, where its branch {end}"
        if end == END:
            return nan, "the orbit stays stable, and no start of the sweep ends on it there"
        return nan, f"its branch ends: {end}"
    near = [
        one
        for one in branch.specials
        if min(one.between) <= max(lost, lost - 1) and max(one.between) >= lost - 1
    ]
    near.sort(key=lambda one: (one.jump == 0, abs(min(one.between) - lost)))
    if not near:
        return float(branch["parameter"][lost]), "the orbit loses its stability"
    return near[0].parameter, NAMES.get(near[0].kind, near[0].kind)

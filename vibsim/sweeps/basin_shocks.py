"""Minimal fatal shock: the smallest sudden change of the state that takes a motion out of its basin.

    L. Halekotte and U. Feudel, Minimal fatal shocks in multistable complex networks, Scientific Reports 10
    (2020) 11783

A shock changes the state at an instant; here at a return to the section, of an orbit of n returns at each of
them. It is fatal where the motion from there ends on another attractor, be it the mirror image. In one
coordinate both ways are looked at. In all, the size of a shock is the length of its unknowns as velocities:
displacements count by a natural rate, as in all measures of states here. The boundary is met by looking
outwards in steps, then by bisection of runs; directions are drawn evenly, then the best is turned as long as
that makes the shock smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.orbits.stability import dot, length_of
from vibsim.physics.elementary import sine_cosine_of_arrays
from vibsim.results.columns import starts_of
from vibsim.sweeps.basin_edges import EdgeError, rest_near
from vibsim.sweeps.basin_starts import LONGER, NOWHERE, BasinEnd, Basins, Stepping, basins_and_starts
from vibsim.sweeps.sweep_plan import PlanError

if TYPE_CHECKING:
    from vibsim.cases import Case

FIRST, WIDE = 1e-6, 1e-2  # of the size of the motion [m/s], or of 1 m/s at rest in 0: shocks tried first
WIDER = 1.03  # from the second on by so much at a time: a basin's edge that is thinner is not seen
LARGEST = 1e6  # of the size: up to where the boundary is looked for
FINER = 1e-10  # of the shock: where bisection ends
DIRECTIONS = 32  # that are drawn evenly; in more than two unknowns, besides the axes, at random
LOOKS = 12  # along each of them, within the smallest shock so far
TURN, LEAST_TURN = 0.15, 1e-4  # [rad] by which the best direction is turned: the first, and the last
SMALLER = 1e-9  # share by which a turned direction must shorten the shock
SEED = 1


@dataclass(frozen=True, eq=False)
class FatalShock:
    """The smallest shock that takes a motion out of its basin.

    case : its case; end : the attractor that is left
    along : column of the one coordinate that was changed, or None of a shock in all; unit : its unit
    change : by column [SI]; size : its length, displacements as velocities [m/s]
    other_way : the smallest shock of the other sign in the one coordinate [SI]; None where none is fatal
    point : number of the return to the section at which it acts
    destination : the attractor on which the motion then ends
    runs : starts that were run to their ends

    >>> import vibsim
    >>> shock = vibsim.fatal_shock("gallery/cantilever", {"x_tip": 0.0, "v_tip": 0.0}, along="v_tip")
    >>> shock.end.orbit.spelled, shock.destination.orbit.spelled, shock.along
    ('', 'be', 'v_tip')
    """

    case: Case
    end: BasinEnd
    along: str | None
    unit: str
    change: dict[str, float]
    size: float
    other_way: float | None
    point: int
    destination: BasinEnd
    runs: int


def fatal_shock(
    source: Any,
    motion: Any,
    along: str | None = None,
    overrides: Mapping[str, Any] | None = None,
    ask: Callable[[], None] = lambda: None,
) -> FatalShock:
    """The minimal fatal shock of the attractor on which a start ends.

    source, motion, overrides : as `source`, `one` and `overrides` of `vibsim.sweeps.basin_edges.edge`
    along : the one coordinate that the shock changes, as a key of an initial value (tip.v) or a column
        (v_tip); None: all unknowns of the orbits

    Raises EdgeError where no shock is fatal, or the start ends on no orbit and no rest; PlanError for what
    is not there, OrbitError, CaseError, EngineError.

    >>> import vibsim
    >>> shock = vibsim.fatal_shock("gallery/cantilever", {"x_tip": 0.0, "v_tip": 0.0}, along="tip.v")
    >>> round(shock.change["v_tip"], 6), round(shock.other_way, 6)
    (0.089745, -0.252863)
    """
    basins, (start,) = basins_and_starts(source, [motion], overrides, ask)
    column, unit = (None, "m/s") if along is None else _column(basins, along)
    number = basins.end_of(start)
    if number == NOWHERE:
        raise EdgeError(
            "on which attractor the start ends is not decided within "
            f"{LONGER[-1] * basins.scene.t_end:.6g} s; give the case a longer end (run.t_end)"
        )
    end = basins.ends[number]
    if not len(end.points):
        raise EdgeError(f"the start ends on what is {end.words}; shocks are for orbits and states of rest")
    return _Search(basins, end, column, unit).smallest()


def _column(basins: Basins, along: str) -> tuple[str, str]:
    """Column and unit of an initial value by its key or its column. Raises PlanError."""
    starts = starts_of(basins.scene, basins.case.is_long)
    for column, (key, unit) in starts.items():
        if along in (column, key, key.removeprefix("initial.")):
            return column, unit
    keys = ", ".join(key.removeprefix("initial.") for key, _ in starts.values())
    raise PlanError(f"a shock along {along!r}: no such initial value; this case has {keys}")


@dataclass(frozen=True, eq=False)
class _Exit:
    """Exit of a ray from the basin: direction of length 1 (weighed), distance [m/s], where it leads."""

    point: int
    direction: np.ndarray
    distance: float
    end: int


class _Search:
    """The search for the smallest shock of one attractor."""

    def __init__(self, basins: Basins, end: BasinEnd, along: str | None, unit: str) -> None:
        self.basins, self.end, self.along, self.unit = basins, end, along, unit
        self.stepping = Stepping(basins.scene)
        at = self.stepping.at
        self.states = [at.lifted(X) for X in end.points]
        self.size = max(map(self.stepping.size, self.states)) or 1.0
        if end.orbit is None and self.stepping.free:
            self.states = [self._at_rest(state) for state in self.states]

    def _at_rest(self, state: np.ndarray) -> np.ndarray:
        """The state of rest near where a run is still on its way to it."""
        rest = rest_near(self.stepping, state, self.size)
        return state if rest is None else rest

    def smallest(self) -> FatalShock:
        """The smallest shock. Raises EdgeError where none is fatal."""
        if self.along is not None:
            return self._in_one(self.along)
        best: _Exit | None = None
        for point in range(len(self.states)):
            for direction in self._directions():
                best = self._nearer(point, direction, best)
        if best is None:
            raise self._none()
        return self._shock(self._turned(best), None)

    def _in_one(self, column: str) -> FatalShock:
        """The same in one coordinate."""
        direction = np.zeros(len(self.states[0]))
        component = self.stepping.at.components.index(column)
        direction[component] = 1.0
        if component not in self.stepping.moving:
            raise PlanError(
                f"a shock along {column}: the section holds it, or no force of this case feels it"
            )
        ways: dict[int, _Exit] = {}
        for point in range(len(self.states)):
            for sign in (1, -1):
                leaving = self._first_exit(point, sign * direction)
                if leaving is not None and leaving.distance < ways.get(sign, _NEVER).distance:
                    ways[sign] = leaving
        if not ways:
            raise self._none()
        best = min(ways.values(), key=lambda leaving: leaving.distance)
        others = [leaving for leaving in ways.values() if leaving is not best]
        return self._shock(best, self._change(others[0])[component] if others else None)

    def _none(self) -> EdgeError:
        return EdgeError(
            f"no shock of up to {LARGEST:.0g} times the size of the motion is seen to take it "
            f"out of its basin ({self.end.words})"
        )

    def _shock(self, leaving: _Exit, other_way: float | None) -> FatalShock:
        change = self._change(leaving)
        named = self.stepping.by_column(change)
        moving = {self.stepping.at.components[i] for i in self.stepping.moving}
        return FatalShock(
            self.basins.case,
            self.end,
            self.along,
            self.unit,
            {name: value for name, value in named.items() if name in moving},
            leaving.distance,
            None if other_way is None else float(other_way),
            leaving.point,
            self.basins.ends[leaving.end],
            self.basins.runs,
        )

    def _change(self, leaving: _Exit) -> np.ndarray:
        return self.stepping.changed(leaving.distance * leaving.direction)

    # One ray.

    def _end_at(self, point: int, direction: np.ndarray, distance: float) -> int:
        """Number of the attractor behind a shock; that of the motion where it is undecided."""
        state = self.states[point] + self.stepping.changed(distance * direction)
        end = self.basins.end_of(self.stepping.by_column(state))
        return self.end.number if end == NOWHERE else end

    def _first_exit(self, point: int, direction: np.ndarray) -> _Exit | None:
        """First exit of a ray from the basin, as far as steps by WIDER see."""
        inside, outside = 0.0, FIRST * self.size
        while outside <= LARGEST * self.size:
            if self._end_at(point, direction, outside) != self.end.number:
                return self._bisected(point, direction, inside, outside)
            inside, outside = outside, outside * (2 if outside < WIDE * self.size else WIDER)
        return None

    def _exit_within(self, point: int, direction: np.ndarray, within: float) -> _Exit | None:
        """The first of the exits within a distance that LOOKS even steps see."""
        for k in range(1, LOOKS + 1):
            if self._end_at(point, direction, within * k / LOOKS) != self.end.number:
                return self._bisected(point, direction, within * (k - 1) / LOOKS, within * k / LOOKS)
        return None

    def _bisected(self, point: int, direction: np.ndarray, inside: float, outside: float) -> _Exit:
        there = self._end_at(point, direction, outside)
        while outside - inside > FINER * outside:
            middle = (inside + outside) / 2
            end = self._end_at(point, direction, middle)
            if end == self.end.number:
                inside = middle
            else:
                outside, there = middle, end
        return _Exit(point, direction, outside, there)

    # All directions.

    def _directions(self) -> Iterator[np.ndarray]:
        """Directions of length 1: even angles in a plane, the axes and random ones in more unknowns."""
        moving = self.stepping.moving
        if len(moving) == 2:
            sines, cosines = sine_cosine_of_arrays(2 * pi * np.arange(DIRECTIONS) / DIRECTIONS)
            rows = np.stack([cosines, sines], axis=1)
        elif len(moving) == 1:
            rows = np.array([[1.0], [-1.0]])
        else:
            axes = np.eye(len(moving))
            drawn = np.random.default_rng(SEED).random((DIRECTIONS, len(moving))) - 0.5
            rows = np.concatenate([axes, -axes, drawn])
        for row in rows:
            direction = np.zeros(len(self.states[0]))
            direction[moving] = row / length_of(row)
            yield direction

    def _nearer(self, point: int, direction: np.ndarray, best: _Exit | None) -> _Exit | None:
        """The exit along a direction where it is nearer than the best so far."""
        if best is None:
            return self._first_exit(point, direction)
        return self._exit_within(point, direction, best.distance) or best

    def _turned(self, best: _Exit) -> _Exit:
        """The exit nearest to the motion, by turning the direction as long as that brings it nearer."""
        turn = TURN
        while turn >= LEAST_TURN and len(self.stepping.moving) > 1:
            nearer = self._turned_once(best, turn)
            if nearer is None:
                turn /= 2
            else:
                best = nearer
        return best

    def _turned_once(self, best: _Exit, turn: float) -> _Exit | None:
        for sideways in _across(best.direction, self.stepping.moving):
            direction = best.direction + turn * sideways
            direction = direction / length_of(direction)
            within = best.distance * (1 - SMALLER)
            if self._end_at(best.point, direction, within) != self.end.number:
                return self._bisected(best.point, direction, 0.5 * within, within)
        return None


_NEVER = _Exit(0, np.empty(0), inf, NOWHERE)


def _across(direction: np.ndarray, moving: np.ndarray) -> Iterator[np.ndarray]:
    """Both ways along each of the axes, as far as it is across a direction."""
    for i in moving.tolist():
        axis = np.zeros(len(direction))
        axis[i] = 1.0
        across = axis - dot(axis, direction) * direction
        size = sqrt(dot(across, across))
        if size > 1e-6:
            yield across / size
            yield -across / size

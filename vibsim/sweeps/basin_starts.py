"""Starts, the attractors on which they end, the names by which both are asked for, and steps from a start.

A start is a state on the section, or anywhere where nothing drives the scene. Attractors are numbered here as
starts come to them; mirror images of an orbit are two.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite, nan
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.analysis.attractor import KnownOrbits, Label, lies_on
from vibsim.cases.quantities import number
from vibsim.engine.errors import EngineError
from vibsim.orbits.coordinates import Coordinates, OrbitError, component_names, placed, start_by_column
from vibsim.orbits.newton import first_point
from vibsim.orbits.orbit import Orbit
from vibsim.orbits.return_map import ReturnMap, returns, slowest_period
from vibsim.orbits.search import opened
from vibsim.orbits.search import start_of as state_of_start
from vibsim.physics.connections import whole_turn_angles
from vibsim.physics.formula_values import gap_of
from vibsim.physics.parts import RigidStop, Scene
from vibsim.results.simulation import kind_of, names_a_result
from vibsim.sweeps.attractor_labels import coordinates_of, label_of_failure, orbit_of_label, run_label
from vibsim.sweeps.attractors import ALIKE, REST_REACH, SAME_SET
from vibsim.sweeps.axes import Members
from vibsim.sweeps.quantities import quantities_of
from vibsim.sweeps.statistics import TooFineError, sampled_for_statistics
from vibsim.sweeps.sweep_plan import PlanError
from vibsim.sweeps.sweep_result import SweepResult, open_sweep

if TYPE_CHECKING:
    from vibsim.cases import Case

StartState = Mapping[str, float]  # by name of the column, SI
LONGER = (1, 4)  # times the end of the case that a start is run until it is decided
TOUCHING = 1e-9  # [m]: nearer to a rigid stop, or in it, a state lies at it
SHOWN = 2  # unknowns of an attractor that are told
NOWHERE = -1  # the end of an undecided start


# Which attractor a start ends on.


@dataclass(frozen=True, eq=False)
class BasinEnd:
    """An attractor on which starts of a case end.

    number : in the order in which they were met
    label : of the first start that ended there
    orbit : where it is one
    names : of the unknowns of its state
    """

    number: int
    label: Label
    orbit: Orbit | None = None
    names: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """Its kind and its points on the section, in words."""
        shown = list(zip(self.names, self.label.state.tolist(), strict=False))[:SHOWN]
        place = ", ".join(f"{name} {number(value, 4)}" for name, value in shown if isfinite(value))
        where = f" (at {place})" if place and self.label.kind in ("periodic", "rest") else ""
        kind = f"period {self.label.period:g}" if self.label.kind == "periodic" else self.label.kind
        return kind + where

    @property
    def points(self) -> np.ndarray:
        """Its unknowns at its returns to the section (n, m); none of a set that is not periodic."""
        if self.orbit is not None:
            return self.orbit.points
        at_rest = self.label.kind == "rest" and len(self.label.state)
        return self.label.state[np.newaxis] if at_rest else np.empty((0, len(self.label.state)))

    def has(self, label: Label) -> bool:
        """Whether a start with that label ends here. Mirror images of an orbit are two ends."""
        own = self.label
        if label.kind != own.kind:
            return False
        if label.kind == "periodic":
            return label.period == own.period and self.orbit is not None and lies_on(self.orbit, label.state)
        if label.kind == "running away" or not len(own.means):
            return True
        apart, doubt = np.abs(label.means - own.means), label.errors + own.errors
        if label.kind == "rest":
            return bool(np.all(apart <= REST_REACH * doubt + 1e-9))
        doubt = SAME_SET * np.sqrt(label.errors**2 + own.errors**2)
        return bool(np.all(apart <= np.maximum(doubt, ALIKE * (np.abs(label.means) + np.abs(own.means)))))


@dataclass(eq=False)
class Basins:
    """The attractors of a case as its starts meet them, whatever its own start is.

    ask : called between blocks, what it raises ends the run
    runs : how many starts were run
    """

    case: Case
    ask: Callable[[], None] = lambda: None
    ends: list[BasinEnd] = field(default_factory=list)
    runs: int = 0

    def __post_init__(self) -> None:
        self.scene = self.case.scene()
        self.of = quantities_of(self.case)
        self.known = KnownOrbits()

    def inside(self, state: StartState) -> str | None:
        """Name of a rigid stop in which a state lies, as no motion does; None where there is none."""
        components = np.array([0.0 if name is None else state[name] for name in component_names(self.scene)])
        for i, stop in enumerate(self.scene.stops):
            if isinstance(stop, RigidStop) and gap_of(self.scene, i, 0.0, components)[0] < -TOUCHING:
                return stop.name
        return None

    def end_of(self, state: StartState) -> int:
        """Number of the attractor on which the start of a state (by name of the column) ends; NOWHERE where
        that is undecided, as after a failure, and of a state inside a rigid stop.
        """
        if self.inside(state) is not None:
            return NOWHERE
        label = self._label(state)
        if label is None or label.kind == "undecided":
            return NOWHERE
        for end in self.ends:
            if end.has(label):
                return end.number
        return self._taken(label)

    def _label(self, state: StartState) -> Label | None:
        label = None
        for factor in LONGER:
            scene = placed(self.scene, state, factor * self.scene.t_end)
            scene = sampled_for_statistics(replace(scene, stop_on_violation=False))
            self.runs += 1
            try:
                label = run_label(scene, self.of, scene.t_end / 2, self.ask, self.known)
            except EngineError as error:
                return label_of_failure(error)
            except TooFineError:
                return None
            if label.kind != "undecided":
                break
        return label

    def _taken(self, label: Label) -> int:
        """A new attractor."""
        orbit = None
        if label.kind == "periodic":
            try:
                orbit = orbit_of_label(self.scene, label.state, label.period, self.case)
            except (OrbitError, EngineError):
                return NOWHERE
        at = coordinates_of(self.scene)
        self.ends.append(BasinEnd(len(self.ends), label, orbit, at.names if at is not None else ()))
        if orbit is not None and orbit.stable:
            self.known.add(orbit)
        return len(self.ends) - 1


# States on the section and between its returns. Where nothing drives the scene there is no section that every
# motion meets, and motions are looked at after equal times.


SWINGS = 8  # slowest periods that a free motion is followed to see it turn round
STRETCH = 0.25  # of the slowest period between two looks at a free motion


class Stepping:
    """From a state to the next, along motions of a scene.

    A state has all components; bodies of a set that may be shifted count from its reference.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.map = scene, ReturnMap(scene, 1)
        self.at: Coordinates = self.map.coordinates
        section = self.map.section
        self.free = section.turning
        self.stretch = STRETCH * slowest_period(scene) if self.free else nan
        self._weights = np.zeros(len(self.at.components))
        self._weights[self.at.free] = self.at.weights
        if self.free:
            self._weights[section.component] = 1.0
        self._turning = whole_turn_angles(self.at.scene)
        self.moving = np.flatnonzero(self._weights)  # components that are no shifts

    def of_state(self, state: Mapping[str, float]) -> np.ndarray:
        """The components of a state by name of the column, where its run first meets the section."""
        components = [0.0 if name is None else state[name] for name in self.at.components]
        if self.free:
            return self.plain(np.array(components))
        scene = placed(self.scene, state, self.scene.t_end)
        return self.at.lifted(first_point(scene, self.at))

    def plain(self, components: np.ndarray) -> np.ndarray:
        """The same without shifts of sets that are held nowhere."""
        state = self.at.lifted(self.at.of(components))
        if self.free:
            state[self.map.section.component] = components[self.map.section.component]
        return state

    def by_column(self, components: np.ndarray) -> dict[str, float]:
        """By name of the column."""
        return self.at.by_column(components)

    def size(self, components: np.ndarray) -> float:
        """The largest component, as weighed [m/s]."""
        return float(np.abs(components * self._weights).max())

    def weighed(self, change: np.ndarray) -> np.ndarray:
        """A change of the components as unknowns that are all velocities [m/s], and back by `changed`."""
        return np.asarray(change * self._weights)

    def changed(self, weighed: np.ndarray) -> np.ndarray:
        """The change of components whose weighed one it is."""
        back = np.zeros_like(weighed)
        back[self.moving] = weighed[self.moving] / self._weights[self.moving]
        return back

    def near(self, components: np.ndarray, other: np.ndarray) -> np.ndarray:
        """The same state with angles of rotors less than half a turn from those of another. Bodies that turn,
        as a pendulum, stay where they are: to fall over is to leave a basin.
        """
        moved = self.at.lifted(self.at.in_turn_of(self.at.of(components), self.at.of(other)))
        moved[self._turning] = components[self._turning]
        if self.free:
            moved[self.map.section.component] = components[self.map.section.component]
        return moved

    def after(self, components: np.ndarray) -> np.ndarray:
        """The state at the next return, or after the next stretch. Raises EngineError, OrbitError."""
        if self.free:
            return self.plain(self.map.carrier.carry(components, self.stretch, []).state)
        return self.at.lifted(self.map.plain(self.at.of(components)).image)

    def turns(self, components: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and unknowns (k, m) of the next returns of a free motion."""
        scene = placed(self.scene, self.by_column(components), SWINGS * 4 * self.stretch)
        times, states = returns(scene, self.at)
        return times, self.at.of(states)


# From a case or a sweep, and names of attractors, to starts that end on them.


NUMBERED = re.compile(r"(\d+)(m?)")  # an attractor of a sweep; m: its mirror image
MOST_COMPARED = 1000  # starts of each attractor of which the nearest two are taken


def basins_and_starts(
    source: Any,
    names: Sequence[Any],
    overrides: Mapping[str, Any] | None = None,
    ask: Callable[[], None] = lambda: None,
) -> tuple[Basins, list[StartState]]:
    """The basins of the case of a source, and a start that ends on each attractor that is named.

    source, names, overrides : as of `vibsim.sweeps.basin_edges.edge`; of a sweep and numbers the case is
        that at the parameters of the attractors
    """
    numbers = [NUMBERED.fullmatch(str(name)) for name in names]
    sweep = _sweep_of(source)
    if sweep is not None and all(numbers):
        if overrides:
            raise PlanError(
                "numbers are those of the attractors at the parameters of the sweep; changes go with starts"
            )
        case, starts = _starts_of_sweep(sweep, [(int(m[1]), bool(m[2])) for m in numbers if m])
        return Basins(case, ask), starts
    if any(numbers):
        name = next(name for name, match in zip(names, numbers, strict=True) if match)
        raise PlanError(
            f"{name} is the number of an attractor, which a sweep with the computation attractor has; "
            "of a case give starts: orbits, runs or cases"
        )
    case = sweep.case if sweep is not None else opened(source, None)[0]
    case = case.with_values(overrides) if overrides else case
    basins = Basins(case, ask)
    return basins, [_state_of(name, basins.scene) for name in names]


def _sweep_of(source: Any) -> SweepResult | None:
    """The sweep that a source is or names; None for anything else."""
    if isinstance(source, SweepResult):
        return source
    if (
        isinstance(source, str | PathLike)
        and names_a_result(Path(source))
        and kind_of(Path(source)) == "sweep"
    ):
        return open_sweep(Path(source))
    return None


def _state_of(start: Any, scene: Scene) -> StartState:
    """The state of a start by name of the column of the scene."""
    state: StartState
    if isinstance(start, Mapping):
        state = start
    elif isinstance(start, Orbit):
        state = start.state
    else:
        case, result = opened(start, None)
        if result is not None and result.orbit is not None:
            state = state_of_start(result)[0]
        else:
            state = start_by_column(case.scene())
    names = [name for name in component_names(scene) if name is not None]
    missing = [name for name in names if name not in state]
    if missing:
        raise PlanError(f"the start {start!r:.60} has no {', '.join(missing)}, which the case has")
    return {name: float(state[name]) for name in names}


def _starts_of_sweep(sweep: SweepResult, wanted: Sequence[tuple[int, bool]]) -> tuple[Case, list[StartState]]:
    """The case of the attractors with these numbers, and a start for each: of two the nearest ones."""
    attractors = sweep.attractors
    for i, mirrored in wanted:
        _check_number(sweep, i, mirrored)
    if len({int(attractors["point"][i]) for i, _ in wanted}) > 1:
        listed = " and ".join(str(i) for i, _ in wanted)
        raise PlanError(f"the attractors {listed} are of different values of the parameter; give two of one")
    points = [
        np.argwhere((attractors.labels == i) & (attractors.mirrored == mirrored)) for i, mirrored in wanted
    ]
    chosen = _nearest(sweep, points)
    cases = [sweep.case_at(tuple(index.tolist())) for index in chosen]
    return cases[0], [start_by_column(case.scene()) for case in cases]


def _check_number(sweep: SweepResult, i: int, mirrored: bool) -> None:
    count = len(sweep.attractors)
    if i >= count:
        there = f"its attractors are 0 to {count - 1}" if count else "no start of it is decided"
        raise PlanError(f"no attractor {i} in this sweep: {there}")
    if mirrored and not sweep.attractors["share_mirror"][i]:
        raise PlanError(f"no start of this sweep ends on a mirror image of attractor {i}")
    if not mirrored and sweep.attractors["share_mirror"][i] == 1:
        raise PlanError(f"all starts of attractor {i} end on its mirror image; give {i}m")


def _nearest(sweep: SweepResult, points: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Of the points of each attractor one; of two attractors those nearest to each other, distances in
    shares of the axes.
    """
    if len(points) == 1:
        return [points[0][0]]
    fewer = [each[:: 1 + len(each) // MOST_COMPARED] for each in points]
    places = [np.stack([_along(sweep, each, k) for k in range(len(sweep.axes))], axis=1) for each in fewer]
    best, chosen = inf, (0, 0)
    for i, place in enumerate(places[0]):
        squares = np.zeros(len(places[1]))
        for k in range(len(place)):
            squares = squares + (places[1][:, k] - place[k]) ** 2
        k = int(np.argmin(squares))
        if squares[k] < best:
            best, chosen = float(squares[k]), (i, k)
    return [fewer[0][chosen[0]], fewer[1][chosen[1]]]


def _along(sweep: SweepResult, points: np.ndarray, k: int) -> np.ndarray:
    """Places of points along an axis, from 0 to 1; the first of the drawn values of members."""
    axis = sweep.axes[k]
    if isinstance(axis, Members):
        values = axis.drawn[axis.spreads[0].key][points[:, k]]
        return np.asarray(values / (np.ptp(values) or 1.0))
    return np.asarray(points[:, k] / len(axis))

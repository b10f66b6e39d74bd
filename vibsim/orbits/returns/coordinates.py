"""The unknowns of an orbit: the state on the section without what no force feels.

A set of bodies that springs and stops join to each other, but not to ground or base, may be shifted as a
whole. Displacements of its bodies count from its last body, and the orbit may drift by a shift per period.
What the section fixes (the angle of a motor) is no unknown either.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vibsim.engine.tangent.carried import Carried
from vibsim.engine.tangent.tangent_space import length, plainly_weighed_alike, weights
from vibsim.once import once
from vibsim.orbits.errors import OrbitError
from vibsim.orbits.returns.section import Section, section_of
from vibsim.physics.arithmetic.numbers import Doubles
from vibsim.physics.body_sets import body_sets
from vibsim.physics.parts import Scene, columns_of


class Coordinates:
    """The m unknowns X of the orbits of a scene, and how they make its N state components (x of each body, v
    of each body, then phi and phidot with a motor).

    names, units : of the unknowns, e.g. "x1-x2" in m
        self.reference = reference
        self.count = len(free)
    weights : of the unknowns; each is measured as a velocity [m/s], displacements by a natural rate
    """

    def __init__(self, scene: Scene, section: Section) -> None:
        self.scene, self.section = scene, section
        self.columns = component_names(scene)
        reference = _references(scene)
        free = [i for i in range(length(scene)) if i != section.pinned and reference.get(i) != i]
        self.take = np.eye(length(scene))[free]
        for row, i in enumerate(free):
            if i in reference:
                self.take[row, reference[i]] = -1.0
        self.put = np.ascontiguousarray(np.eye(length(scene))[:, free])
        self.free = np.array(free, dtype=int)
        shifted = [(row, reference[i]) for row, i in enumerate(free) if i in reference]
        self._shifted = np.array(shifted, dtype=int).reshape(-1, 2).T
        self.names = tuple(self._name(i, reference.get(i)) for i in free)
        self.units = tuple(self._unit(i) for i in free)
        self.references = sorted(set(reference.values()))
        self.reference = reference
        self.count = len(free)
        self.one = np.eye(self.count)
        self._weigh(weights(scene, Doubles))
        self.none = np.empty((0, length(scene)))  # no disturbance

    def _weigh(self, squares: list[float]) -> None:
        self._squares = squares
        self.weights = np.sqrt([squares[i] for i in self.free])
        # by which entries of a matrix of unknowns are weighed
        self.ratios = self.weights[:, None] / self.weights

    def of_scene(self, scene: Scene) -> Coordinates:
        """Those of another scene with the same bodies, of which the same are joined."""
        if plainly_weighed_alike(self.scene, scene):
            return self
        squares = weights(scene, Doubles)
        if squares == self._squares:
            return self
        other = object.__new__(Coordinates)
        vars(other).update(vars(self), scene=scene)
        other._weigh(squares)
        return other

    def of(self, state: ArrayLike) -> np.ndarray:
        """Unknowns of state components, the last axis of `state`: sums and differences, rounded once."""
        components = np.asarray(state, dtype="f8")
        unknowns: np.ndarray = components[..., self.free]
        rows, references = self._shifted
        if len(rows):
            unknowns[..., rows] -= components[..., references]
        return unknowns

    def lifted(self, X: np.ndarray) -> np.ndarray:
        """State components on the section, references at x = 0."""
        state = np.zeros(len(self.columns))
        state[self.free] = X
        return state

    def between(self, part: Any, speed: bool) -> np.ndarray:
        """The velocity of the ends of a part against each other, or their distance, by the unknowns (m)."""
        first = len(self.scene.bodies) if speed else 0
        ends = [self.put[first + end] if end >= 0 else np.zeros(self.count) for end in (part.P, part.Q)]
        return np.asarray(ends[0] - ends[1])

    @once
    def disturbances(self) -> np.ndarray:
        """A disturbance of the state for each unknown, one per row."""
        return np.ascontiguousarray(self.put.T)

    def drift(self, state: np.ndarray) -> dict[str, float]:
        """By name of the body: how far each set that is held nowhere has moved from the start at 0 [m]."""
        return {self.scene.bodies[r].name: float(state[r]) for r in self.references}

    def state(self, X: np.ndarray) -> dict[str, float]:
        """The state on the section by name of the column [m, m/s, rad, rad/s]."""
        return dict(zip(self.columns, self.lifted(X).tolist(), strict=True))

    def named(self, X: ArrayLike) -> dict[str, float]:
        """The unknowns by name."""
        return dict(zip(self.names, np.asarray(X).tolist(), strict=True))

    def size(self, X: np.ndarray) -> float:
        """The largest of the unknowns, as weighed [m/s]."""
        return float(np.abs(X * self.weights).max())

    def travel(self, carried: Carried) -> float:
        """The largest of the unknowns at the events of a motion, as weighed [m/s]."""
        return self.size(self.of(carried.states)) if len(carried.states) else 0.0

    def _name(self, i: int, reference: int | None) -> str:
        return self.columns[i] if reference is None else f"{self.columns[i]}-{self.columns[reference]}"

    def _unit(self, i: int) -> str:
        n = len(self.scene.bodies)
        return "m" if i < n else "m/s" if i < 2 * n else ("rad", "rad/s")[i - 2 * n]


def unknown_count(scene: Scene) -> int:
    """Number of unknowns of the orbits of a scene, and of their multipliers. Raises NoSection."""
    return Coordinates(scene, section_of(scene)).count


def component_names(scene: Scene) -> list[str]:
    """Columns in the order of state components."""
    pairs = [columns_of(body.name) for body in scene.bodies]
    rotor = ["phi", "phidot"] if scene.motor is not None else []
    return [x for x, _ in pairs] + [v for _, v in pairs] + rotor


def _references(scene: Scene) -> dict[int, int]:
    """By body of each set that may be shifted: the body that its displacements count from."""
    springs = [link for link in scene.links if link.k]
    sets = [one for one in body_sets(scene, [*springs, *scene.stops]) if not one.held]
    return {body: one.reference for one in sets for body in one.bodies}


def components_of(state: Any, columns: Sequence[str], left_out: float | None = None) -> list[float]:
    """The components of a state, by name of the column or all in their order.

    left_out : what those are that are not named, and nothing else may be; None: each must be named, but the
    angle of a motor. Raises OrbitError.
    """
    words = f"the components of this scene are {', '.join(columns)}"
    if isinstance(state, Mapping):
        unknown = [str(name) for name in state if name not in columns]
        missing = [name for name in columns if name not in state and name != "phi"]
        if unknown and left_out is not None:
            raise OrbitError(f"no column {', '.join(unknown)}; {words}")
        if missing and left_out is None:
            raise OrbitError(f"the state misses {', '.join(missing)}; {words}")
        state = [state.get(name, left_out or 0.0) for name in columns]
    try:
        components = [float(each) for each in state]
    except (TypeError, ValueError):
        components = []
    if len(components) != len(columns) or not all(map(isfinite, components)):
        raise OrbitError(f"a state is a finite number for each component, got {state!r:.60}; {words}")
    return components

"""The section that an orbit crosses, and its unknowns there: the state without what no force feels.

A set of bodies that springs and stops join to each other, but not to ground or base, may be shifted as a
whole. Displacements of its bodies count from its last body, and the orbit may drift by a shift per period.
What the section fixes (the angle of a motor) is no unknown either, nor is the angle of a rotor that no force
feels. The angle of any other rotor, and of a body that whole turns bring back to where it was, as a pendulum,
is an unknown up to whole turns; a state is one unknown.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vibsim.engine.errors import start_of
from vibsim.engine.tangent.carried import Carried
from vibsim.engine.tangent.tangent_space import length, plainly_weighed_alike, weights
from vibsim.lazy import once
from vibsim.physics.connections import body_sets, felt_angles, reads_time, whole_turn_angles
from vibsim.physics.formulas import TIME, derivative, reads
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import BODY, ROTOR, STATE, Body, Scene, columns_of
from vibsim.physics.rates import Period, common_period, is_driven, springs_of, turning_rotor
from vibsim.results.columns import starts_of

if TYPE_CHECKING:
    from vibsim.cases.case import Case


class Coordinates:
    """The m unknowns X of the orbits of a scene, and how they make its N state components (x of each body, v
    of each body, then phi and phidot with a motor).

    columns : names of the components that are shown: all but what would be the x of a state
    names, units : of the unknowns, e.g. "x1-x2" in m; angles : which of them are angles up to whole turns
        self.reference = reference
        self.count = len(free)
    weights : of the unknowns; each is measured as a velocity [m/s], displacements by a natural rate
    """

    def __init__(self, scene: Scene, section: PoincareSection) -> None:
        self.scene, self.section = scene, section
        self.components = component_names(scene)
        self.columns = [name for name in self.components if name is not None]
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
        line = len(scene.line)
        self.references = sorted({r for r in reference.values() if r < line})
        self.reference = reference
        bodies = scene.bodies
        turning = {i for i, body in enumerate(bodies) if body.kind == ROTOR} | set(whole_turn_angles(scene))
        self.angles = np.array(
            [row for row, i in enumerate(free) if i in turning and i not in reference], dtype=int
        )
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
        state = np.zeros(len(self.components))
        state[self.free] = X
        return state

    def gathered(self, table: Mapping[str, np.ndarray]) -> np.ndarray:
        """State components (n, N) of columns by name, each (n); 0 of what is not shown."""
        nothing = np.zeros(len(table[self.columns[0]])) if len(self.columns) < len(self.components) else None
        rows = [nothing if name is None else table[name] for name in self.components]
        return np.stack(rows, axis=1)  # type: ignore[arg-type]

    def in_turn_of(self, image: np.ndarray, X: np.ndarray) -> np.ndarray:
        """Unknowns whose angles are less than half a turn from those of others."""
        if len(self.angles):
            apart = image[..., self.angles] - X[..., self.angles]
            image[..., self.angles] -= 2 * pi * np.round(apart / (2 * pi))
        return image

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

    def turns(self, X: np.ndarray, state: np.ndarray) -> dict[str, int]:
        """By column of the angles that are unknowns up to whole turns: how many turns a motion from X to a
        state made, those left out that made none.
        """
        rows = self.angles.tolist()
        made = np.round((self.of(state) - X)[rows] / (2 * pi)).astype(int).tolist()
        return {self.names[row]: turns for row, turns in zip(rows, made, strict=True) if turns}

    def state(self, X: np.ndarray) -> dict[str, float]:
        """The state on the section by name of the column [m, m/s, rad, rad/s]."""
        return self.by_column(self.lifted(X))

    def by_column(self, state: Iterable[Any]) -> dict[str, Any]:
        """Components by name of the column, those left out that are not shown."""
        pairs = zip(self.components, np.asarray(state).tolist(), strict=True)
        return {name: value for name, value in pairs if name is not None}

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
        name = self.components[i]
        assert name is not None  # what is not shown is no unknown
        return name if reference is None else f"{name}-{self.components[reference]}"

    def _unit(self, i: int) -> str:
        bodies = self.scene.bodies
        n = len(bodies)
        if i >= 2 * n:
            return ("rad", "rad/s")[i - 2 * n]
        if bodies[i % n].kind == STATE:
            return dict(self.scene.state_units).get(bodies[i % n].name) or "1"
        unit = self.scene.unit_of(bodies[i % n])
        return unit + ("" if i < n else "/s")


def coordinates_of_rest(scene: Scene) -> Coordinates:
    """The unknowns of orbits, and of states of rest, of a scene.

    Where nothing drives it and nothing brings a body back near its own start, as on top of a hill between two
    wells, they are those that it has elsewhere. Raises NoSection.
    """
    try:
        return Coordinates(scene, section_of(scene))
    except NoSection:
        if is_driven(scene) or not scene.line:
            raise
        section = PoincareSection(pinned=len(scene.bodies), body=scene.line[0].name)
        return Coordinates(scene, section)


def unknown_count(scene: Scene) -> int:
    """Number of unknowns of the orbits of a scene, and of their multipliers. Raises NoSection."""
    return Coordinates(scene, section_of(scene)).count


def component_names(scene: Scene) -> list[str | None]:
    """Columns in the order of state components; None for what is not shown."""
    pairs = [body.columns for body in scene.bodies]
    rotor = ["phi", "phidot"] if scene.motor is not None else []
    return [x for x, _ in pairs] + [v for _, v in pairs] + rotor


def _references(scene: Scene) -> dict[int, int]:
    """By body of each set that may be shifted: the body that its displacements count from; a rotor whose
    angle nothing feels counts from itself, as a state does.
    """
    springs = [link for link in scene.links if link.k]
    sets = [one for one in body_sets(scene, [*springs, *scene.stops]) if not one.held]
    felt = felt_angles(scene)
    others = [i for i, body in enumerate(scene.bodies) if body.kind != BODY and i not in felt]
    return {body: one.reference for one in sets for body in one.bodies} | {i: i for i in others}


def components_of(state: Any, components: Sequence[str | None], left_out: float | None = None) -> list[float]:
    """The components of a state, by name of the column or all in their order, but for those not shown.

    left_out : what those are that are not named, and nothing else may be; None: each must be named, but the
    angle of a motor. Raises OrbitError.
    """
    columns = [name for name in components if name is not None]
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
        values = [float(each) for each in state]
    except (TypeError, ValueError):
        values = []
    if len(values) != len(columns) or not all(map(isfinite, values)):
        raise OrbitError(f"a state is a finite number for each component, got {state!r:.60}; {words}")
    by_column = dict(zip(columns, values, strict=True))
    return [0.0 if name is None else by_column[name] for name in components]


# A scene, or a case, that starts on an orbit.


SAMPLES = 400  # of a stored orbit, about


def placed(scene: Scene, state: Mapping[str, float], t_end: float) -> Scene:
    """The scene from a state, by name of the column, to `t_end` [s]."""
    bodies = []
    for body in scene.bodies:
        x, v = body.columns
        bodies.append(replace(body, x=0.0 if x is None else state[x], v=state[v]))
    motor = scene.motor
    if motor is not None:
        motor = replace(motor, phi=state["phi"], phidot=state["phidot"])
    stops = tuple(replace(stop, at_start=False) for stop in scene.stops)
    return replace(scene, bodies=tuple(bodies), motor=motor, stops=stops, t_end=t_end)


def start_by_column(scene: Scene) -> dict[str, float]:
    """The initial state of a scene by name of the column [SI]; what is not shown is left out."""
    start = start_of(scene, Doubles)
    spin = [start.phase, start.w] if scene.motor is not None else []
    named = zip(component_names(scene), (*start.x, *start.v, *spin), strict=True)
    return {name: float(value) for name, value in named if name is not None}


def case_on_orbit(
    case: Case, state: Mapping[str, float], period: float, values: Mapping[str, str] | None = None
) -> Case:
    """The case from a state by name of the column over one period [s]; every number as the double it is.

    values : other values of its keys, which may be ones that its own start does not allow
    """
    return case.with_values({**(values or {}), **_initial(case, state), **_span(period), **_freely(case)})


def _initial(case: Case, state: Mapping[str, float]) -> dict[str, str]:
    starts = starts_of(case.scene(), case.is_long)
    return {key: f"{state[name]!r} {unit}".rstrip() for name, (key, unit) in starts.items()}


def _span(period: float) -> dict[str, str]:
    """Samples lie on decimals; the end of the period is in the table of events."""
    return {"run.t_end": f"{period!r} s", "run.every": f"{period / SAMPLES:.3g} s"}


def _freely(case: Case) -> dict[str, str]:
    """A limit that is watched ends no orbit."""
    if case.is_long:
        return {"run.on_violation": "warn"}
    return {"rest_distance.on_violation": "warn"} if case.scene().clearances else {}


# The section on which the orbits of a scene are looked at.
#
# Ideal sources: phase 0 of the common period of all forces and the base, so the time of return is known. A
# motor, or the first rotor that its torque drives: its angle phi = 0 mod 2 pi, so phi is known and the time
# of return is not; the angles of other rotors close up to whole turns. Neither: the velocity of a body that
# springs bring back is 0, at its least or its greatest displacement, where fewer stops act.


@dataclass(frozen=True)
class PoincareSection:
    """The section on which an orbit begins and ends.

    period : the common period of ideal sources, or None
    pinned : number of the component of the state that the section fixes at 0, or None; such a section is met
        again where the component has advanced by `advance`, after a time that is not known beforehand
    speed : number of the component that is the rate of an angle that is pinned
    rotor : name of the rotor whose angle is pinned; empty of a motor
    body : name of the body at whose turn it is, where nothing drives the scene, or empty; `advance` is 0 then
    sense : 1 at the least displacement of the body, -1 at the greatest
    """

    period: Period | None = None
    pinned: int | None = None
    advance: float = 0.0
    speed: int = 0
    rotor: str = ""
    body: str = ""
    sense: int = 1

    @property
    def timed(self) -> bool:
        """Whether the time between two returns is known."""
        return self.pinned is None

    @property
    def turning(self) -> bool:
        """Whether it is where a body turns round, as nothing drives the scene."""
        return bool(self.body)

    @property
    def of_return(self) -> str:
        """Unit counted from one return to the next."""
        if self.body:
            return f"swing of {self.body}"
        return "period of the source" if self.timed else f"turn of {self.rotor or 'the motor'}"

    @property
    def place(self) -> str:
        """Its place, in words."""
        if self.body:
            side = "least" if self.sense > 0 else "greatest"
            return f"{columns_of(self.body)[1]} = 0, at the {side} displacement of {self.body}"
        if self.timed:
            return "phase 0 of the source"
        return f"{Body(self.rotor, 1.0, 0.0, 0.0, ROTOR).columns[0]} = 0" if self.rotor else "phi = 0"

    @property
    def component(self) -> int:
        """The pinned component, of sections whose time of return is not known."""
        assert self.pinned is not None
        return self.pinned

    def time(self, n: int) -> float:
        """Time of n periods of the source [s]; of timed sections only."""
        assert self.period is not None
        return float(self.period.end(n))


def section_of(scene: Scene) -> PoincareSection:
    """The section of a scene. Raises NoSection where there is none."""
    n = len(scene.bodies)
    if scene.motor is not None:
        vibrates = any(term.amplitude != 0 and term.cycles != 0 for term in scene.harmonics)
        if vibrates or reads_time(scene):
            raise NoSection(
                "a motor whose speed is free and a force or base of its own frequency have no common period, "
                "so the scene has no periodic orbit; leave out one of them"
            )
        return PoincareSection(pinned=2 * n, advance=2 * pi, speed=2 * n + 1)
    period = common_period(scene)
    if period is not None:
        return PoincareSection(period)
    if _base_moves_evenly(scene):
        raise NoSection(
            "the base moves on evenly, so nothing comes back: describe the scene from the base, which then "
            "rests (ground in its place), and give the frictions of the ground a belt that runs the other way"
        )
    if reads_time(scene):
        raise NoSection(
            "a formula reads the time otherwise than in sin, cos and mod of a multiple of it, or their "
            "frequencies have no exact ratio: the scene has no period; if it pulls a body at a constant "
            "velocity W (k*(d - W*t)), write the case in the frame that moves with W: leave W*t out, and "
            "give each friction on the ground a belt of velocity -W"
        )
    if any(term.amplitude != 0 and term.cycles != 0 for term in scene.harmonics):
        raise NoSection(
            "the frequencies of forces and base have no common period (no exact ratio of whole numbers), "
            "so the motion is at best quasi-periodic"
        )
    rotor = turning_rotor(scene)
    if rotor is not None:
        return PoincareSection(pinned=rotor, advance=2 * pi, speed=n + rotor, rotor=scene.bodies[rotor].name)
    springs = springs_of(scene)
    for i, body in enumerate(scene.line):
        if any(i in (part.P, part.Q) for part in springs):
            return PoincareSection(pinned=n + i, body=body.name, sense=_freer_side(scene, i))
    raise NoSection(
        "an orbit needs a periodic source (a harmonic force, a moving base or a motor), or a spring that "
        "brings a body back; the scene has neither"
    )


def _base_moves_evenly(scene: Scene) -> bool:
    """Whether the displacement of the base grows in proportion to the time."""
    base = scene.base_formula
    if base is None or scene.base_is_rate or not reads([base], ("t",)):
        return False
    return not reads([derivative(base, TIME)], ("t",))


def _freer_side(scene: Scene, body: int) -> int:
    """1 where no more stops act at the least displacement of a body than at the greatest, else -1: an orbit
    that just grazes a stop does so where its body turns.
    """
    sides = [
        stop.sense if body == stop.P else -stop.sense for stop in scene.stops if body in (stop.P, stop.Q)
    ]
    return -1 if sum(sides) > 0 else 1


# Why there is no orbit.


class OrbitError(ValueError):
    """An orbit that cannot be looked for, or was not found: cause and remedy in one sentence.

    >>> import vibsim
    >>> try:
    ...     vibsim.orbit("gallery/three-balls")
    ... except vibsim.OrbitError as error:
    ...     print(str(error).partition(" (")[0])
    an orbit needs a periodic source
    """


class NoSection(OrbitError):
    """A scene whose motion has no section that it comes back to."""


class NotConverged(OrbitError):
    """Newton's method found no orbit near its start; `residual` [m/s], as weighed: the least of its way."""

    def __init__(self, message: str, residual: float) -> None:
        super().__init__(message)
        self.residual = residual

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle, as between processes."""
        return type(self), (str(self), self.residual)


def check_count(name: str, value: object, least: int = 1) -> None:
    """Raise OrbitError unless an argument is a whole number, no less than `least`."""
    if isinstance(value, bool) or not hasattr(value, "__index__") or int(value.__index__()) < least:
        words = "one" if least == 1 else str(least)
        raise OrbitError(f"{name} must be a whole number, {words} or more, got {value!r}")

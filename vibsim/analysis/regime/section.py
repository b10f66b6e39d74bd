"""The stroboscopic section of a run: its exact state at the end of every cycle, made comparable.

Drift is left out: a point has y = x_P - x_Q and u = v_P - v_Q of every pair of ends that links and stops
join; the velocity of one body of each set that they join to each other, but not to ground or base; the speed
of the rotor, and with a rotor cosine and sine of the phases of forces and base, which its turns do not fix.
Of two blocks that is (y, u, v2, w). Lengths are divided by the amplitude of y in the span, speeds of bodies
by that of u, the speed of the rotor by its mean; so a distance of 1e-3 between points is a thousandth of the
vibration. What moves less than the share LEAST of the largest vibration is measured by that.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from vibsim.analysis.cycles import ROWS, TURN, cycle_ends
from vibsim.analysis.event_rows import events_within
from vibsim.analysis.span import Span
from vibsim.physics.arithmetic.sines import sine_cosine
from vibsim.physics.arithmetic.sums import mean
from vibsim.physics.body_sets import body_sets, joined_pairs
from vibsim.physics.parts import Scene, columns_of
from vibsim.results.motion.relative_motion import RelativeMotion
from vibsim.results.restart import states_at
from vibsim.results.result import Result
from vibsim.results.windows import pieces, rows_within

MOST = 5000  # points, the last ones of the span
NEWTON_STEPS = 2  # from an error of 1e-4 rad, which the line between two samples leaves
LEAST = 1e-3  # amplitude relative to the largest of its unit: ten times what a point may stray

Table = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Section:
    """Points (n, d) at ascending `times` [s], without unit.

    states : the same by name of the column, SI, and `time`; sizes : by which their coordinates were divided
    """

    times: np.ndarray
    points: np.ndarray
    states: dict[str, np.ndarray] = field(default_factory=dict)
    sizes: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.times)


class Coordinates:
    """The coordinates of the motion of a scene without its drift.

    They are the relative motions of pairs of ends, (y, u) each, and the velocities of what moves as a whole.
    """

    def __init__(self, scene: Scene):
        pairs = joined_pairs(scene)
        free = [one for one in body_sets(scene, pairs) if not one.held]
        self._scene = scene
        self._motions = [RelativeMotion(scene, pair) for pair in pairs]
        self._free = [columns_of(scene.bodies[one.reference].name)[1] for one in free]
        self._pairs_of_free = [
            [i for i, pair in enumerate(pairs) if {pair.P, pair.Q} & set(one.bodies)] for one in free
        ]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Columns of states that they need."""
        columns = [name for motion in self._motions for name in motion.columns]
        return tuple(dict.fromkeys([*columns, *self._free]))

    def of(self, states: Table) -> np.ndarray:
        """y [m] of every pair, u [m/s] of every pair, v [m/s] of what moves as a whole: shape (d, n).

        states : columns by name, among them `time`
        """
        motions = [motion(states, "time") for motion in self._motions]
        rows = [motion[1] for motion in motions] + [motion[2] for motion in motions]
        rows += [np.asarray(states[name]) for name in self._free]
        return np.stack(rows) if rows else np.empty((0, len(states["time"])))

    def sizes(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """By what each of `of` is divided, from its extremes (d): see above."""
        amplitude = (high - low) / 2
        count = len(self._motions)
        lengths, speeds, whole = amplitude[:count], amplitude[count : 2 * count], amplitude[2 * count :]
        own = [
            max(speeds[pairs]) if pairs else one
            for pairs, one in zip(self._pairs_of_free, whole, strict=True)
        ]
        speeds = np.concatenate([speeds, own])
        sizes = np.concatenate(
            [np.maximum(part, LEAST * part.max(initial=0.0)) for part in (lengths, speeds)]
        )
        sizes[~(sizes > 0)] = 1.0
        return sizes

    def points(self, states: Table, sizes: np.ndarray) -> np.ndarray:
        """Points (n, d) of the states by name, each (n)."""
        columns = [row / size for row, size in zip(self.of(states), sizes, strict=True)]
        if self._scene.has_motor:
            columns += [states["phidot"] / (mean(states["phidot"]) or 1.0), *self._phases(states["time"])]
        return np.stack(columns, axis=1)

    def _phases(self, time: np.ndarray) -> Iterator[np.ndarray]:
        """Cosine and sine of the phase of every frequency of forces and base."""
        terms = [term for term in self._scene.harmonics if term.amplitude]
        for cycles in dict.fromkeys(term.cycles for term in terms):
            sine, cosine = sine_cosine(TURN * np.fmod(cycles * time, 1.0))
            yield cosine
            yield sine


def section_of(result: Result, span: Span) -> Section:
    """The section of a run within the span; empty without a source."""
    times = cycle_ends(result, span.window)[-MOST:]
    if not len(times):
        return Section(times, np.empty((0, 0)))
    times, states = _turned(result, span, times)
    coordinates = Coordinates(result.case.scene())
    sizes = coordinates.sizes(*extremes(result, span, coordinates))
    states = {**states, "time": times}
    return Section(times, coordinates.points(states, sizes), states, sizes)


def extremes(result: Result, span: Span, coordinates: Coordinates) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest of each coordinate among the samples of the span; 0 without samples."""
    rows = rows_within(result.column("time"), span.window)
    turns = []
    for piece in pieces(rows, ROWS):
        values = coordinates.of(
            {name: np.asarray(result.column(name)[piece]) for name in ("time", *coordinates.names)}
        )
        turns.append((values.min(axis=1), values.max(axis=1)))
    if not turns:
        nothing = np.zeros(len(coordinates.of({name: np.empty(0) for name in ("time", *coordinates.names)})))
        return nothing, nothing
    low, high = (np.array(part) for part in zip(*turns, strict=True))
    return low.min(axis=0), high.max(axis=0)


def _turned(result: Result, span: Span, times: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Exact ends of the cycles and the states there."""
    scene = result.case.scene()
    window = float(times[0]) - 1.0, float(times[-1]) + 1.0
    events = events_within(result, window, before=1)
    states = states_at(scene, events, times, result.t_reached)
    for _ in range(NEWTON_STEPS if scene.has_motor else 0):
        apart = states["phi"] - TURN * np.round(states["phi"] / TURN)
        step = np.divide(apart, states["phidot"], out=np.zeros_like(apart), where=states["phidot"] > 0)
        times = np.clip(times - step, span.begin, span.end)
        states = states_at(scene, events, times, result.t_reached)
    return times, states

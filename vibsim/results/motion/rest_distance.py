"""The distances that a run needs: the largest x1 - x2, or x_P - x_Q of each clearance, in continuous time.

The blocks do not overlap as long as x1 - x2 stays below their distance at rest. The paper gives none, so a
run reports what it needs. Between two rows (samples and events in time order) x1 - x2 is the cubic that has
the displacements and velocities of both; so a maximum between samples is not missed.
"""

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibsim.physics.parts import COMPRESSION, EXTENSION, RigidStop, Scene, Stop
from vibsim.physics.rates import fastest_rate
from vibsim.results.motion.relative_motion import RelativeMotion

if TYPE_CHECKING:
    from vibsim.cases import Case

REST_DISTANCE = "rest_distance"
Relative = Callable[[Mapping[str, np.ndarray], str], np.ndarray]

# A cubic over h misses at most h^4/384 max|y''''| (Hermite remainder), that is (w h)^4/384 of an amplitude at
# w rad/s: 0.5 % at w h = 1.18. Rows further apart say nothing about the maximum between them.
LARGEST_STEP = 1.18


class Largest:
    """Running maximum of a relative displacement over blocks of samples and events.

    relative : (rows by column name, name of their clock) -> rows t, y, v (shape 3 x n)
    known : whether the samples are close enough to tell
    """

    def __init__(self, relative: Relative, known: bool):
        self._relative, self._known = relative, known
        self._largest = -math.inf
        self._last: np.ndarray | None = None

    @property
    def needed(self) -> float | None:
        """Largest relative displacement so far [m], or None if not known."""
        return self._largest if self._known and math.isfinite(self._largest) else None

    def update(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take the next block of samples (`time`, states) and events (`t`, states)."""
        if not self._known:
            return
        rows = _merge(self._relative(samples, "time"), self._relative(events, "t"))
        if self._last is not None:
            rows = np.concatenate([self._last, rows], axis=1)
        if rows.shape[1]:
            self._largest = max(self._largest, largest_of_cubics(*rows))
            self._last = rows[:, -1:]


class Distances:
    """The distances that a run of `case` needs: those of its clearances, and x1 - x2 of the short form."""

    def __init__(self, case: "Case", scene: Scene):
        watched = {clearance.name: clearance for clearance in scene.clearances}
        pair = {} if case.is_long else {REST_DISTANCE: scene.links[0]}
        self._distances = {name: _largest(scene, part) for name, part in {**pair, **watched}.items()}
        self._clearances = tuple(watched) if case.is_long else ()

    def update(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take the next block of samples and events."""
        for distance in self._distances.values():
            distance.update(samples, events)

    @property
    def attrs(self) -> dict[str, Any]:
        """Attributes of the file, in m: rest_distance_needed of the short form; clearances_needed of the
        long one, in the order of its clearances, all or none.
        """
        if REST_DISTANCE in self._distances and not self._clearances:
            needed = self._distances[REST_DISTANCE].needed
            return {} if needed is None else {"rest_distance_needed": needed}
        all_needed = [self._distances[name].needed for name in self._clearances]
        known = bool(all_needed) and None not in all_needed
        return {"clearances_needed": np.array(all_needed, dtype="f8")} if known else {}


def _largest(scene: Scene, part: Any) -> Largest:
    """The largest x_P - x_Q of a part; stops that it opens are open near it."""
    opened = [stop for stop in scene.stops if _acts_against(stop, part)]
    rate = fastest_rate(scene, [stop for stop in scene.stops if stop not in opened])
    return Largest(RelativeMotion(scene, part), scene.every_num / scene.every_den * rate <= LARGEST_STEP)


def _acts_against(stop: Stop | RigidStop, part: Any) -> bool:
    """Whether the stop is in contact where x_P - x_Q of the part is small."""
    same, mirrored = (stop.P, stop.Q) == (part.P, part.Q), (stop.Q, stop.P) == (part.P, part.Q)
    return (same and stop.sense == EXTENSION) or (mirrored and stop.sense == COMPRESSION)


def largest_of_cubics(t: np.ndarray, y: np.ndarray, v: np.ndarray) -> float:
    """Maximum of the piecewise cubic through `y` with slopes `v` at the ascending times `t` (1-D)."""
    largest = float(y.max())
    h = np.diff(t)
    # a cubic lies below the largest of its four Bezier ordinates: solve only where these are above all rows
    ordinates = np.maximum(y[:-1] + h * v[:-1] / 3, y[1:] - h * v[1:] / 3)
    for i in np.flatnonzero(ordinates > largest):
        largest = max(largest, _largest_inside(y[i], y[i + 1], h[i] * v[i], h[i] * v[i + 1]))
    return largest


def _largest_inside(y0: float, y1: float, d0: float, d1: float) -> float:
    """Maximum of y(s) = y0 + d0 s + b s^2 + a s^3 on 0 <= s <= 1 with y(1) = y1 and y'(1) = d1."""
    rise = y1 - y0
    a, b = d0 + d1 - 2 * rise, 3 * rise - 2 * d0 - d1
    root = b * b - 3 * a * d0
    if root < 0:
        return max(y0, y1)
    # highest where d0 + 2 b s + 3 a s^2 falls through zero; of the two forms, the one without cancellation
    above, below = (d0, math.sqrt(root) - b) if b <= 0 else (-b - math.sqrt(root), 3 * a)
    if not below or not 0 < above / below < 1:
        return max(y0, y1)
    s = above / below
    return float(max(y0, y1, y0 + s * (d0 + s * (b + s * a))))


def _merge(samples: np.ndarray, events: np.ndarray) -> np.ndarray:
    """Rows t, y, v of both, each ascending, in the order of time; a sample before the events there."""
    places = np.searchsorted(samples[0], events[0], side="right") + np.arange(events.shape[1])
    of_sample = np.ones(samples.shape[1] + events.shape[1], dtype=bool)
    of_sample[places] = False
    rows = np.empty((3, len(of_sample)))
    for row, sampled, happened in zip(rows, samples, events, strict=True):
        row[of_sample] = sampled
        row[places] = happened
    return rows

"""The distances that a run needs: the largest x1 - x2, or x_P - x_Q of each clearance, in continuous time.

The blocks do not overlap as long as x1 - x2 stays below their distance at rest. The paper gives none, so a
run reports what it needs. Between two rows (samples and events in time order) x1 - x2 is the cubic that has
the displacements and velocities of both; so a maximum between samples is not missed.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibsim.physics.parts import Scene as PartsScene
from vibsim.physics.rates import fastest_rate
from vibsim.physics.sampling import Sampled
from vibsim.physics.scene import Scene as TwoBlocks
from vibsim.results.relative_motion import RelativeMotion

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


class RestDistance(Largest):
    """Running maximum of x1 - x2 (x1 alone if block 2 is fixed) over blocks of samples and events.

    `needed` is None while nothing was seen, and always when the output interval is too long to tell.
    """

    def __init__(self, scene: TwoBlocks):
        super().__init__(_relative_motion, _is_close(scene, _fastest_rate(scene)))

    @property
    def attrs(self) -> dict[str, Any]:
        """Attributes of the file."""
        return {} if self.needed is None else {"rest_distance_needed": self.needed}


class Clearances:
    """The same for every clearance of a scene made of parts: the distance that it needs."""

    def __init__(self, scene: PartsScene):
        known = _is_close(scene, fastest_rate(scene))
        self._distances = [Largest(RelativeMotion(scene, part), known) for part in scene.clearances]

    def update(self, samples: Mapping[str, np.ndarray], events: Mapping[str, np.ndarray]) -> None:
        """Take the next block of samples and events."""
        for distance in self._distances:
            distance.update(samples, events)

    @property
    def attrs(self) -> dict[str, Any]:
        """Attributes of the file: distances needed [m], in the order of the clearances; all, or none."""
        needed = [distance.needed for distance in self._distances]
        return {} if not needed or None in needed else {"clearances_needed": np.array(needed, dtype="f8")}


def watched_distances(scene: TwoBlocks | PartsScene) -> RestDistance | Clearances:
    """What keeps account of the distances that a run of `scene` needs."""
    return RestDistance(scene) if isinstance(scene, TwoBlocks) else Clearances(scene)


def _is_close(scene: Sampled, rate: float) -> bool:
    """Whether a sample follows another soon enough for motions at `rate` [rad/s]."""
    return scene.every_num / scene.every_den * rate <= LARGEST_STEP


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


def _relative_motion(rows: Mapping[str, np.ndarray], clock: str) -> np.ndarray:
    """Rows t, x1 - x2, v1 - v2 (shape 3 x n)."""
    y, v = rows["x1"], rows["v1"]
    if "x2" in rows:
        y, v = y - rows["x2"], v - rows["v2"]
    return np.stack([rows[clock], y, v])


def _merge(samples: np.ndarray, events: np.ndarray) -> np.ndarray:
    rows = np.concatenate([samples, events], axis=1)
    return rows[:, np.argsort(rows[0], kind="stable")]


def _fastest_rate(scene: TwoBlocks) -> float:
    """Highest angular rate [rad/s] that x1 - x2 shows near its maximum."""
    stiffness = scene.k1
    if scene.has_stop and scene.stop_sign < 0:  # contact is where x1 - x2 is large
        stiffness += scene.k2
    mobility = 1 / scene.m1 + (1 / scene.m2 if scene.has_block2 else 0.0)
    source = {"none": 0.0, "harmonic": scene.omega, "motor": scene.Omega0}[scene.source]
    spin = abs(scene.phidot) if scene.has_motor else 0.0
    return max(math.sqrt(stiffness * mobility), abs(source), spin)

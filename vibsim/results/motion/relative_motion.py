"""The motion of one end of a part against the other, from the columns of a run."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibsim.physics.arithmetic.sines import sine_cosine
from vibsim.physics.parts import BASE, GROUND, Harmonic, Scene, columns_of


class RelativeMotion:
    """x_P - x_Q [m] and v_P - v_Q [m/s] of a part of `scene` with the ends P and Q."""

    def __init__(self, scene: Scene, part: Any):
        self._scene, self._ends = scene, (part.P, part.Q)

    def __call__(self, rows: Mapping[str, np.ndarray], clock: str) -> np.ndarray:
        """Rows t, x_P - x_Q, v_P - v_Q (shape 3 x n); `clock` : name of the column of times [s]."""
        time = np.asarray(rows[clock])
        (x, v), (other_x, other_v) = (self._motion(end, rows, time) for end in self._ends)
        return np.stack([time, x - other_x, v - other_v])

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of states that it needs."""
        bodies = [self._scene.bodies[end].name for end in self._ends if end >= 0]
        return tuple(name for body in bodies for name in columns_of(body))

    def _motion(
        self, end: int, rows: Mapping[str, np.ndarray], time: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        if end == GROUND:
            return np.zeros_like(time), np.zeros_like(time)
        if end == BASE:
            return base_motion(self._scene.base, time)
        x, v = columns_of(self._scene.bodies[end].name)
        return rows[x], rows[v]


def base_motion(terms: tuple[Harmonic, ...], time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement [m] and velocity [m/s] of the base at times [s]."""
    x, v = np.zeros_like(time), np.zeros_like(time)
    for term in terms:
        angle = 2 * np.pi * np.fmod(term.cycles * time, 1.0) + term.phase
        sine, cosine = sine_cosine(angle)
        x += term.amplitude * sine
        v += term.amplitude * term.omega * cosine
    return x, v

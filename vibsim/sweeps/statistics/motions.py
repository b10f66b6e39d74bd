"""Displacements and velocities of motions, from the states of many rows at once."""

from collections.abc import Mapping, Sequence

import numpy as np

from vibsim.physics.parts import BASE, GROUND, Scene, columns_of
from vibsim.results.motion.relative_motion import base_motion
from vibsim.sweeps.statistics.quantities import Motion

States = Mapping[str, np.ndarray]  # time [s] and the states by name, each (n)


def displacements(scene: Scene, motions: Sequence[Motion], states: States) -> np.ndarray:
    """x_P - x_Q [m] of each motion (motions, n)."""
    return np.stack([difference(*(place(scene, end, states) for end in (m.P, m.Q))) for m in motions])


def velocities(scene: Scene, motions: Sequence[Motion], states: States) -> np.ndarray:
    """v_P - v_Q [m/s] of each motion (motions, n)."""
    return np.stack([difference(*(speed(scene, end, states) for end in (m.P, m.Q))) for m in motions])


def place(scene: Scene, end: int, states: States) -> np.ndarray | None:
    """Displacement of an end of a part [m] (n); None for the ground."""
    if end == GROUND:
        return None
    return (
        base_motion(scene.base, states["time"])[0]
        if end == BASE
        else states[columns_of(scene.bodies[end].name)[0]]
    )


def speed(scene: Scene, end: int, states: States) -> np.ndarray | None:
    """Velocity of an end of a part [m/s] (n); None for the ground."""
    if end == GROUND:
        return None
    return (
        base_motion(scene.base, states["time"])[1]
        if end == BASE
        else states[columns_of(scene.bodies[end].name)[1]]
    )


def difference(one: np.ndarray | None, other: np.ndarray | None) -> np.ndarray:
    """What one end of a part has against the other (n); None is the ground, which is not both."""
    if one is None:
        assert other is not None
        return -other
    return one if other is None else one - other

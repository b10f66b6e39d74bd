"""Accelerations of many rows at once, from the equations of motion, for what lies between rows."""

from collections.abc import Mapping

import numpy as np

from vibsim.physics.forces import motor_accelerations, source_force, transmitted_force
from vibsim.physics.sines import sine_cosine
from vibsim.physics.two_blocks import TwoBlocks


def accelerations(
    scene: TwoBlocks, rows: Mapping[str, np.ndarray], contact: np.ndarray, friction: np.ndarray
) -> dict[str, np.ndarray]:
    """Accelerations by the name of the velocity that they belong to: v1, v2 [m/s^2], phidot [rad/s^2].

    Parameters
    ----------
    rows : time and states, each (n)
    contact, friction : the mode that each row moves in, each (n), codes of `vibsim.physics.modes`

    Eqs. (2.1) to (2.10); in stick a2 = 0.
    """
    y, u = rows["x1"], rows["v1"]
    if scene.has_block2:
        y, u = y - rows["x2"], u - rows["v2"]
    force = transmitted_force(scene, y, u, False)
    if scene.has_stop:
        force = np.where(contact == 1, transmitted_force(scene, y, u, True), force)
    found: dict[str, np.ndarray] = {}
    if scene.has_motor:
        sine, cosine = sine_cosine(rows["phi"])
        found["v1"], found["phidot"] = motor_accelerations(scene, force, sine, cosine, rows["phidot"])
    else:
        found["v1"] = (source_force(scene, _sine(scene, rows["time"])) - force) / scene.m1
    if scene.has_block2:
        found["v2"] = _block2(scene, force, friction)
    return found


def _sine(scene: TwoBlocks, time: np.ndarray) -> np.ndarray | float:
    """sin(omega t); the turns are taken off before the multiplication by 2 pi."""
    if scene.source != "harmonic":
        return 0.0
    turns = time * scene.cycles + time * scene.cycles_lo
    return sine_cosine(2 * np.pi * (turns - np.floor(turns)))[0]


def _block2(scene: TwoBlocks, force: np.ndarray, friction: np.ndarray) -> np.ndarray:
    if not scene.has_friction:
        return force / scene.m2
    return np.where(friction == 0, 0.0, (force - friction * scene.N) / scene.m2)

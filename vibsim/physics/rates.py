"""Angular rates at which a scene made of parts vibrates or is driven.

The natural ones are those of M x'' + K x = 0, friction and damping left out; a motor's unbalanced mass moves
with its body. What sets cadences and time scales of results is rounded to three digits: eigenvalues differ by
machine in the last ones.
"""

from collections.abc import Iterable
from math import inf, pi, sqrt

import numpy as np

from vibsim.physics.parts import Link, Scene, Stop

RIGID = 1e-12  # of the largest squared rate, below which one is that of a rigid motion, 0 but for rounding


def natural_rates(scene: Scene, closed: Iterable[Stop] = ()) -> list[float]:
    """Natural angular rates [rad/s], ascending, those of rigid motions left out.

    closed : the stops that are in contact
    """
    springs: list[Link | Stop] = [*scene.links, *closed]
    share = 1 / np.sqrt(masses(scene))  # of each body in coordinates in which all masses are 1
    stiffness = np.zeros((len(share), len(share)))
    for spring in springs:
        row = np.zeros(len(share))
        for end, sign in ((spring.P, 1.0), (spring.Q, -1.0)):
            if end >= 0:
                row[end] = sign * share[end]
        stiffness += spring.k * (row[:, None] * row)
    squares = np.linalg.eigvalsh(stiffness).tolist()
    return [sqrt(square) for square in squares if square > RIGID * max(squares)]


def masses(scene: Scene) -> np.ndarray:
    """Masses of the bodies [kg], the motor's unbalanced mass with its body; shape (bodies,)."""
    values = np.array([body.m for body in scene.bodies])
    if scene.motor is not None:
        values[scene.motor.on] += scene.motor.m3
    return values


def source_rates(scene: Scene) -> list[float]:
    """Angular rates [rad/s] of forces, base and motor (its no-load speed); those that are 0 left out."""
    terms = [term for force in scene.forces for term in force.terms] + list(scene.base)
    found = [abs(term.omega) for term in terms if term.amplitude]
    found += [abs(scene.motor.Omega0)] if scene.motor is not None else []
    return [rate for rate in found if rate]


def longest_period(scene: Scene) -> float:
    """The longest of the periods of sources and free vibration [s]; infinite without any."""
    rates = [*source_rates(scene), *natural_rates(scene)]
    return _rounded(max((2 * pi / rate for rate in rates), default=inf))


def fastest_rate(scene: Scene, closed: Iterable[Stop] | None = None) -> float:
    """The fastest of sources, rotor at the start and vibration with stops closed, all unless told [rad/s];
    0 without any.
    """
    closed = scene.stops if closed is None else closed
    spin = [abs(scene.motor.phidot)] if scene.motor is not None else []
    return _rounded(max([*source_rates(scene), *spin, *natural_rates(scene, closed)], default=0.0))


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")

"""The free bilinear oscillator in closed form: two blocks, a spring, and a stop at the rest position.

y = x1 - x2 swings with w1 = sqrt(k1 (1/m1 + 1/m2)) while y > 0 and with w2, of k1 + k2, in contact: half a
period of each in turn. The centre of mass rests.
"""

from math import pi, sqrt

import numpy as np

from vibsim.results import Result

M1, M2, K1, K2 = 0.297, 2.94, 200.0, 12400.0
FREE_RATE, CONTACT_RATE = (sqrt(k * (1 / M1 + 1 / M2)) for k in (K1, K1 + K2))
PERIOD = pi / FREE_RATE + pi / CONTACT_RATE


def relative_displacement(t: np.ndarray) -> np.ndarray:
    """y at the times t [s], released from y = 1 at rest."""
    phase = np.fmod(t, PERIOD)
    quarter = pi / (2 * FREE_RATE)
    contact = quarter + pi / CONTACT_RATE
    pressed = -FREE_RATE / CONTACT_RATE * np.sin(CONTACT_RATE * (phase - quarter))
    apart = np.cos(FREE_RATE * np.where(phase < contact, phase, PERIOD - phase))
    return np.asarray(np.where((phase < quarter) | (phase > contact), apart, pressed))


def contacts(t_end: float) -> int:
    """How many contacts begin until t_end [s]: the first after a quarter of a free period."""
    return int((t_end - pi / (2 * FREE_RATE)) / PERIOD) + 1


def contact_begin(n: int) -> float:
    """Time [s] at which contact n = 1, 2, ... begins."""
    return pi / (2 * FREE_RATE) + (n - 1) * PERIOD


def energy(result: Result, k2: float = K2) -> np.ndarray:
    """Kinetic and elastic energy [J] at every sample, from the states alone."""
    y = result["x1"] - result["x2"]
    kinetic = (M1 * result["v1"] ** 2 + M2 * result["v2"] ** 2) / 2
    return np.asarray(kinetic + (K1 + np.where(y < 0, k2, 0.0)) * y**2 / 2)

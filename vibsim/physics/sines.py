"""Sine and cosine of many angles, with the same bits on every processor.

numpy's own pick other code for other vector units, with other last bits. These are additions and products
only: whole quarter turns are taken off, and the Taylor series of what is left, at most pi/4, is summed.
"""

from math import factorial, pi

import numpy as np

QUARTERS = 2 / pi  # quarter turns to a radian
# pi/2 in three parts; a whole number below 2^20 times one of the first two is exact
FIRST, SECOND, THIRD = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21
SINE = [(-1) ** n / factorial(2 * n + 1) for n in range(9)]  # left out: (pi/4)^19 / 19! < 1e-19
COSINE = [(-1) ** n / factorial(2 * n) for n in range(9)]  # left out: (pi/4)^18 / 18! < 2e-18


def sine_cosine(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sines and cosines of angles [rad] of any shape, right to 2e-16 up to a million quarter turns.

    Of larger angles n the error is that of n eps, as of the angles themselves.
    """
    quarters = np.rint(np.asarray(angles) * QUARTERS)
    rest = ((angles - quarters * FIRST) - quarters * SECOND) - quarters * THIRD
    square = rest * rest
    sine, cosine = rest * _polynomial(SINE, square), _polynomial(COSINE, square)
    quadrant = quarters - 4 * np.floor(quarters / 4)
    swapped = (quadrant == 1) | (quadrant == 3)
    first, second = np.where(swapped, cosine, sine), np.where(swapped, sine, cosine)
    return (
        np.where(quadrant >= 2, -first, first),
        np.where((quadrant == 1) | (quadrant == 2), -second, second),
    )


def _polynomial(coefficients: list[float], x: np.ndarray) -> np.ndarray:
    """Horner's rule, the lowest coefficient first."""
    value = np.full_like(x, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        value *= x
        value += coefficient
    return value

"""Sine and cosine of many angles: `vibsim.physics.arithmetic.elementary`, operation by operation on arrays.

numpy's own pick other code for other vector units, with other last bits.
"""

import numpy as np

from vibsim.physics.arithmetic.elementary import LARGEST, TWO_PI, off_quarters


def sine_cosine(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sines and cosines of angles [rad] of any shape, right to 2e-16 up to a million radians.

    Of larger angles n the error is that of n eps, as of the angles themselves.
    """
    angles = np.asarray(angles, dtype="f8")
    if np.any(np.abs(angles) >= LARGEST):
        angles = np.where(np.abs(angles) < LARGEST, angles, np.fmod(angles, TWO_PI))
    quarters, sine, cosine = off_quarters(angles)
    quadrant = quarters - 4 * np.floor(quarters / 4)
    swapped = (quadrant == 1) | (quadrant == 3)
    first, second = np.where(swapped, cosine, sine), np.where(swapped, sine, cosine)
    return (
        np.where(quadrant >= 2, -first, first),
        np.where((quadrant == 1) | (quadrant == 2), -second, second),
    )

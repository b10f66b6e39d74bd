"""Sine and cosine of many angles: `vibsim.physics.elementary`, operation by operation on arrays.

numpy's own pick other code for other vector units, with other last bits.
"""

import numpy as np

from vibsim.physics.elementary import (
    COSINE,
    FIRST,
    LARGEST,
    QUARTERS,
    SECOND,
    SINE,
    THIRD,
    TWO_PI,
    WHOLE,
)


def sine_cosine(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sines and cosines of angles [rad] of any shape, right to 2e-16 up to a million radians.

    Of larger angles n the error is that of n eps, as of the angles themselves.
    """
    angles = np.asarray(angles, dtype="f8")
    if np.any(np.abs(angles) >= LARGEST):
        angles = np.where(np.abs(angles) < LARGEST, angles, np.fmod(angles, TWO_PI))
    quarters = (angles * QUARTERS + WHOLE) - WHOLE
    r = ((angles - quarters * FIRST) - quarters * SECOND) - quarters * THIRD
    z = r * r
    z2 = z * z
    z4 = z2 * z2
    a, b = SINE, COSINE
    s = ((a[0] + a[1] * z) + (a[2] + a[3] * z) * z2) + ((a[4] + a[5] * z) + (a[6] + a[7] * z) * z2) * z4
    c = ((b[0] + b[1] * z) + (b[2] + b[3] * z) * z2) + ((b[4] + b[5] * z) + b[6] * z2) * z4
    half = 0.5 * z
    near = 1 - half
    sine, cosine = r + r * (z * s), near + (((1 - near) - half) + z2 * c)
    quadrant = quarters - 4 * np.floor(quarters / 4)
    swapped = (quadrant == 1) | (quadrant == 3)
    first, second = np.where(swapped, cosine, sine), np.where(swapped, sine, cosine)
    return (
        np.where(quadrant >= 2, -first, first),
        np.where((quadrant == 1) | (quadrant == 2), -second, second),
    )

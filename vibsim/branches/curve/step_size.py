"""How long the next step along a branch is: by the angle that the tangent turned, and by Newton's count."""

from dataclasses import dataclass
from math import ldexp, sqrt

import numpy as np

from vibsim.orbits.matrices import length_of
from vibsim.physics.arithmetic.elementary import asin

TURN = 0.15  # angle between two tangents that is aimed at [rad]
SHARP = 0.35  # beyond it a step is taken again, shorter
COUNT = 5  # Newton steps that are aimed at
GROWTH, SHRINK = 1.6, 0.5


@dataclass(frozen=True)
class Pace:
    """Bounds of the step, in scaled length; the largest grows with the unknowns, as at a resonance."""

    first: float = 0.01
    least: float = 1e-9
    most: float = 0.05

    def following(self, step: float, turned: float, iterations: int, size: float = 1.0) -> float:
        """The step behind one that turned the tangent by `turned` [rad] in so many Newton steps, to a point
        of scaled length `size`.
        """
        by_angle = TURN / turned if turned > 0 else GROWTH
        halves, odd = divmod(COUNT - iterations, 2)
        by_count = ldexp(sqrt(2.0) if odd else 1.0, halves)
        return float(
            min(
                self.most * max(1.0, size),
                max(self.least, step * min(GROWTH, max(SHRINK, min(by_angle, by_count)))),
            )
        )


def turn(one: np.ndarray, other: np.ndarray) -> float:
    """Angle between two unit vectors [rad], right where it is small."""
    between = one - other
    return 2.0 * asin(min(1.0, length_of(between) / 2))

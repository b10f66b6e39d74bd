"""Newton's method on a curve whose points are known."""

import numpy as np
import pytest

from vibsim.orbits.branches.correction import correct

ACROSS = np.array([0.6, 0.8])


class OnACircle:
    """x^2 + p^2 = 1; the derivative by p that is handed over is too large."""

    settled = True

    def __init__(self, z):
        self.z = z
        self.residual = np.array([z @ z - 1.0])

    @property
    def narrow_slope(self):
        return 2 * self.z[1:]

    def jacobian(self, slope=None):
        return np.array([[2 * self.z[0], self.narrow_slope[0] if slope is None else slope[0]]])

    def moved(self, step, slope=None):
        return self.z + step


@pytest.mark.parametrize("share", [1.0, 0.8, 0.3, 0.1, 1.2, 1.25])
def test_a_rough_derivative_by_the_parameter_moves_no_point(share):
    """With it the steps grow shorter by a factor only, which looks as if rounding had begun."""
    on_curve = np.array([0.8, 0.6])
    start = on_curve + 2e-8 * ACROSS + 1e-8 * np.array([0.8, -0.6])
    point = correct(OnACircle, start, ACROSS, 1.0, slope=share * 2 * on_curve[1:]).point
    assert abs(point.residual[0]) < 2e-13

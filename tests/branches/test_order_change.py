"""Changes of the order of events, located by what goes to zero there."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from vibsim.branches.curve.way import _newton
from vibsim.branches.special.order_change import _zero


@pytest.mark.parametrize("power", [1.0, 0.5])
def test_a_zero_is_told_from_one_side(power):
    """A contact's time goes like the root of the way to the graze, a stick's like the way itself."""
    zero = 0.731
    doubt, told = _zero([((zero - share) ** power, share) for share in (0.0, 0.5, 0.7)])
    assert told == pytest.approx(zero, abs=1e-13) and doubt < 1e-12


def test_a_zero_with_a_bend_is_doubted_as_much_as_it_is_wrong():
    """The doubt, by which nodes are put beside the place, is no less than the error."""
    zero = 0.731
    doubt, told = _zero([((zero - s) ** 0.5 * (1 + 0.1 * (zero - s)), s) for s in (0.0, 0.5, 0.7)])
    assert 1e-6 < abs(told - zero) < doubt < 0.1


def test_a_polynomial_goes_through_places_and_slopes():
    """Newton's divided differences with places that count twice: the cubic itself, and of a third place."""
    cubics = [Polynomial([0.3, -1.0, 2.0, 0.7]), Polynomial([1.0, 0.5, 0.0, -3.0])]

    def at(share, order=0):
        return np.array([cubic.deriv(order)(share) if order else cubic(share) for cubic in cubics])

    rows = [(share, at(share), at(share, 1)) for share in (0.0, 1.0)]
    np.testing.assert_allclose(_newton(rows, 0.3), at(0.3), atol=1e-15)
    np.testing.assert_allclose(_newton([*rows, (0.6, at(0.6), None)], 0.3), at(0.3), atol=1e-14)

"""The span of a run with digits is the decimal that the case says; its samples are those of doubles."""

from fractions import Fraction

import numpy as np
import pytest

import vibsim


@pytest.mark.parametrize(
    ("t_end", "every", "exact"),
    [
        ("0.1 s", "0.1 s", Fraction(1, 10)),  # the nearest double lies above
        ("0.3 s", "0.1 s", Fraction(3, 10)),  # and below
        ("1.1 s", "10 ms", Fraction(11, 10)),
    ],
)
def test_the_end_is_the_decimal(t_end, every, exact):
    case = vibsim.load_case("I-A", {"run.t_end": t_end, "run.every": every})
    run, doubles = vibsim.simulate(case, digits=40), vibsim.simulate(case)
    end = Fraction(run.digits.events["t"][-1])
    assert abs(end - exact) < Fraction(1, 10**39)
    assert run.t_reached == float(exact) == doubles.t_reached
    np.testing.assert_array_equal(run.time, doubles.time)
    np.testing.assert_allclose(run["x1"], doubles["x1"], rtol=0, atol=1e-16)

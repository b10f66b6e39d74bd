"""Case II-B before its chaos: checkpoints from 50 digits."""

import math

import pytest

from tests.scenes import paper
from tests.trajectories import run

CHECKPOINTS = {
    20.0: (0.003511, 4.00240, 115),
    50.0: (0.014103, 5.27362, 339),
}  # x2 [m], w / 2 pi [Hz], impacts


@pytest.mark.parametrize("t", CHECKPOINTS)
@pytest.mark.parametrize(("order", "tol"), [(20, 2.0**-53), (30, 2.0**-53), (24, 1e-18)])
def test_checkpoints_of_ii_b(t, order, tol):
    drift, frequency, impacts = CHECKPOINTS[t]
    result = run(paper("II-B", t_end=t, order=order, tol=tol))
    assert result.final("x2") == pytest.approx(drift, abs=0.5e-6)  # half a unit of the last digit given
    assert result.final("phidot") / (2 * math.pi) == pytest.approx(frequency, abs=0.5e-5)
    assert result.totals["impacts"] == impacts
    assert result.totals["uncertified"] == 0

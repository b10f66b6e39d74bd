"""V3: with the stop at the rest position the relative motion is the bilinear oscillator."""

import math

import numpy as np
import pytest

from tests.scenes import scene
from tests.trajectories import ENGINES, run


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_bilinear_frequency(engine, method):
    mobility = 1 / 0.297 + 1 / 2.94
    f1, f2 = (math.sqrt(k * mobility) / (2 * math.pi) for k in (200.0, 12600.0))
    assert (f1, f2) == pytest.approx((4.3337, 34.397), rel=2e-5)
    result = run(scene(x1=0.05, c=0.0, N=None, G=0.0, t_end=3.0, method=method), engine)
    begins = result.times[0::2]
    assert result.kinds[:2] == ["contact_begin", "contact_end"]
    assert result.totals["impacts"] >= 22
    # half a period of each oscillator; a time is off by its rounding (2^-52 s here) and by eps of the phases
    np.testing.assert_allclose(np.diff(begins), (1 / f1 + 1 / f2) / 2, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        result.times[1::2] - begins[: len(result.times[1::2])], 1 / (2 * f2), rtol=0, atol=1e-14
    )
    assert 1 / np.diff(begins).mean() == pytest.approx(7.6975, abs=5e-5)
    assert result.times[0] == pytest.approx(1 / (4 * f1), abs=1e-15)

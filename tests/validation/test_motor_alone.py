"""V9: the motor on a block that does not move runs up exponentially."""

import math

import numpy as np
import pytest

from tests.scenes import fixed_block, motor
from tests.trajectories import ENGINES, run


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("start", (0.0, -20.0, 50.0))
def test_run_up(engine, start):
    # (J + m3 e^2) w' = M0 (1 - w / Omega0)
    Omega0 = 2 * math.pi * 5.5
    heavy = fixed_block(
        {**motor(5.5), "phidot": start, "phi": 0.3}, m1=1e30, k1=0.0, c=0.0, G=None, t_end=60.0
    )
    result = run(heavy, engine)
    t = result.samples["time"]
    decay = np.exp(-0.005 * t / (Omega0 * (0.001 + 0.03 * 0.11**2)))
    w = Omega0 + (start - Omega0) * decay
    # about 1000 steps, each rounding w to eps: their errors decay as w does
    np.testing.assert_allclose(result.samples["phidot"], w, rtol=0, atol=1e-13 * Omega0)
    tau = Omega0 * (0.001 + 0.03 * 0.11**2) / 0.005
    phi = 0.3 + Omega0 * t + (start - Omega0) * tau * (1 - decay)
    np.testing.assert_allclose(result.samples["phi"], phi, rtol=1e-13, atol=1e-12)
    assert result.samples["phi"][-1] / (2 * math.pi) > 100
    assert np.all(np.abs(result.samples["x1"]) < 1e-25)

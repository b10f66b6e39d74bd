"""Every order of the Taylor series that a case may ask for runs, on both engines, to the same motion."""

from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import harmonic, motor, scene
from tests.trajectories import ENGINES, run

TOLERANCE = 2.0**-20  # steps of low orders at full tolerance are a thousand times shorter


def sliding(source, order):
    """At rest on friction: a start and releases that ask for derivatives beyond a series of order 4."""
    return scene(source, N=0.02, t_end=0.8, method="taylor", order=order, tol=TOLERANCE)


@pytest.mark.parametrize("source", [harmonic(3.5, 0.0725), motor(5.5)], ids=["harmonic", "motor"])
@pytest.mark.parametrize("order", [4, 5, 6, 7, 8, 40])
def test_each_order_runs(source, order):
    case = sliding(source, order)
    truth = run(replace(case, order=20, tol=2.0**-53))
    assert "stick_end" in truth.kinds
    runs = [run(case, engine) for engine in ENGINES]
    for other in runs:
        assert other.events["kind"].tolist() == truth.events["kind"].tolist()
        for column in ("x1", "x2"):
            size = np.abs(truth.samples[column]).max()
            assert np.abs(other.samples[column] - truth.samples[column]).max() < 1000 * TOLERANCE * size
    assert runs[0].totals == pytest.approx(runs[1].totals, rel=0, abs=0, nan_ok=True)

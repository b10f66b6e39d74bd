"""V6 and V7: Coulomb friction alone, with exact stops."""

import math

import numpy as np
import pytest

from tests.scenes import scene
from tests.trajectories import ENGINES, run

METHODS = ("closed_form", "taylor")


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("v0", (0.02, -0.02, 0.7))
def test_a_sliding_block_stops_and_stays(engine, method, v0):
    mu_g = 0.001 * 9.81
    alone = scene(k1=0.0, c=0.0, k2=None, G=None, v2=v0, t_end=100.0, every_num=1, every_den=2, method=method)
    result = run(alone, engine)
    stop, distance = abs(v0) / mu_g, v0 * abs(v0) / (2 * mu_g)
    assert result.kinds == ["stick_begin"]
    assert result.times[0] == pytest.approx(stop, rel=1e-15 * 4)
    after = result.samples["time"] >= stop
    assert np.all(result.samples["v2"][after] == 0.0)
    assert np.all(result.samples["friction"][after] == 0)
    assert np.ptp(result.samples["x2"][after]) == 0.0
    assert result.final("x2") == pytest.approx(distance, rel=1e-15 * 8)


def scaled_friction_oscillator(m1, **changes):
    """x'' + x + sgn(x') = 0 for block 2 on its spring to a block 1 that is practically a wall."""
    numbers = {"m1": m1, "m2": 1.0, "k1": 1.0, "c": 0.0, "k2": None, "G": None, "N": 1.0}
    return scene(**numbers, x2=12.0, v2=6.0, t_end=40.0, every_num=1, every_den=10, **changes)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("m1", "tolerance"), [(1e30, 2e-13), (1e12, 2e-8)])
def test_the_scaled_friction_oscillator(engine, method, m1, tolerance):
    # Circles about -1 (x' > 0) and +1: from (12, 6) an arc of atan2(6, 13), then seven half turns.
    # A block 1 of 1e12 moves by x t^2 / (2 m1) = 3e-9 meanwhile.
    result = run(scaled_friction_oscillator(m1, method=method), engine)
    assert result.kinds == ["reversal"] * 7 + ["stick_begin"]
    first = math.atan2(6, 13)
    np.testing.assert_allclose(result.times, first + math.pi * np.arange(8), rtol=0, atol=tolerance)
    assert result.final("x2") == pytest.approx(15 - math.sqrt(205), abs=tolerance)
    after = result.samples["time"] >= result.times[-1]
    assert np.ptp(result.samples["x2"][after]) == 0.0
    # turning points: the amplitude about the centre falls by 2 N / k1 at each
    turns = result.events["x2"][1:-1]
    radius = math.sqrt(205)
    expected = [(-1) ** n * (radius - 1 - 2 * n) for n in range(8)]
    np.testing.assert_allclose(turns, expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("method", METHODS)
def test_amplitude_falls_by_4_mu_m2_g_over_k1_per_cycle(method):
    mu_m2_g = 0.02 * 2.94 * 9.81
    heavy = scene(m1=1e30, c=0.0, k2=None, G=None, N=mu_m2_g, x2=0.05, t_end=8.0, method=method)
    result = run(heavy)
    tops = result.events["x2"][1:-1][1::2]  # every second turning point is a maximum
    assert len(tops) >= 3
    np.testing.assert_allclose(np.diff(tops[:-1]), -4 * mu_m2_g / 200.0, rtol=1e-12)

"""Events crossed almost tangentially are told: first order holds for ever smaller disturbances there."""

import math

import pytest

from tests.scenes import fixed_block, harmonic, paper, scene
from tests.tangent.bundles import exponents

m1, k1, c, FREQUENCY, GAP = 0.297, 200.0, 1.0, 3.0, 0.001
OMEGA = 2 * math.pi * FREQUENCY
IMPEDANCE = math.hypot(k1 - m1 * OMEGA**2, c * OMEGA)


def grazing(ratio, periods=30):
    """The steady vibration whose amplitude without the stop would be `ratio` times the gap (V5)."""
    amplitude = ratio * GAP
    lag = math.atan2(c * OMEGA, k1 - m1 * OMEGA**2)
    start = {"x1": -amplitude * math.sin(lag), "v1": amplitude * OMEGA * math.cos(lag)}
    source = harmonic(FREQUENCY, IMPEDANCE * amplitude)
    return fixed_block(source, **start, c=c, k2=1000.0, stop_sign=-1, t_end=periods / FREQUENCY)


def test_a_contact_that_just_happens():
    found = exponents(grazing(1 + 1e-8))
    assert found.tangencies >= 30  # one contact a period, begun and ended at sqrt(2e-8) of the top speed
    assert found.closest_tangency < 1e-6
    assert 0.0 < found.closest_tangency_time <= 10.0


def test_a_contact_that_just_does_not_happen():
    found = exponents(grazing(1 - 1e-8))
    assert found.tangencies == 1  # the smallest gap of the run
    assert 3e-9 < found.closest_tangency < 3e-8  # 1e-8 of the amplitude, twice, over one to three amplitudes


@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_no_contact_and_a_clear_one(ratio):
    found = exponents(grazing(ratio))
    assert found.tangencies == 0 and found.closest_tangency > 1e-3


def test_a_block_that_all_but_passes_through_rest():
    """From x2 = -N/k - r/2 it slides on a circle of radius r about -N/k to its stop, where S = N - k r."""
    stiffness, friction, mass = 200.0, 1.0, 2.94
    radius = 5e-4 * 2 * friction / stiffness  # (N - S) / (2 N) is 5e-4
    start = {"x2": -friction / stiffness - radius / 2}
    start["v2"] = math.sqrt(0.75 * stiffness / mass) * radius
    stopped = scene(None, **start, m1=1e12, c=0.0, k2=None, G=None, N=friction, t_end=1.0)
    found = exponents(stopped)
    assert found.rank_losses == 1 and found.tangencies == 1
    assert found.closest_tangency == pytest.approx(2.5e-7, rel=1e-6)


def test_the_papers_cases_have_none():
    for name in ("I-A", "I-B", "II-B"):
        assert exponents(paper(name, t_end=60.0), begin=10.0).tangencies == 0

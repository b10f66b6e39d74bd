"""V2, V4 and V5: what linear theory says of the scenes without impacts, and of the first one."""

import math

import numpy as np
import pytest

from tests.scenes import fixed_block, harmonic, scene
from tests.trajectories import ENGINES, run

METHODS = ("closed_form", "taylor")
K1, M1, G = 200.0, 0.297, 0.001


def impedance(omega, c):
    """|k1 - m1 w^2 + i c w| [N/m]."""
    return math.hypot(K1 - M1 * omega**2, c * omega)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", METHODS)
def test_free_free_frequency(engine, method):
    # V2: 4.3337 Hz = sqrt(k1 (1/m1 + 1/m2)) / (2 pi); y = 1 mm cos(w t), centre of mass at rest
    free = {"c": 0.0, "N": None, "k2": None, "G": None}
    result = run(scene(x1=0.001, t_end=5.0, method=method, **free), engine)
    w = math.sqrt(K1 * (1 / 0.297 + 1 / 2.94))
    assert w / (2 * math.pi) == pytest.approx(4.3337, abs=5e-5)
    y = result.samples["x1"] - result.samples["x2"]
    # w t is rounded once or twice on the way: eps w t = 136 eps times the amplitude; Taylor adds 1 eps a step
    np.testing.assert_allclose(
        y, 0.001 * np.cos(w * result.samples["time"]), rtol=0, atol=0.001 * 1000 * 2**-53
    )
    centre = 0.297 * result.samples["x1"] + 2.94 * result.samples["x2"]
    np.testing.assert_allclose(centre, 0.297 * 0.001, rtol=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("frequency", (1.0, 4.13, 9.0))
def test_steady_amplitude(engine, method, frequency):
    # V4, with c so large that the transient is below eps: exp(-c t / (2 m1)) = exp(-50)
    c, A, omega = 6.0, 0.3, 2 * math.pi * frequency
    result = run(fixed_block(harmonic(frequency, A), c=c, G=None, t_end=5.0, method=method), engine)
    steady = np.hypot(result.samples["x1"], result.samples["v1"] / omega)[-20:]
    np.testing.assert_allclose(steady, A / impedance(omega, c), rtol=1e-13)


def at_grazing(factor, c=0.5, frequency=3.0, periods=6.5, **changes):
    """Block 1 before the stop, on its steady state x1 = X sin(w t - lag) with X = factor G from the start."""
    omega = 2 * math.pi * frequency
    lag, X = math.atan2(c * omega, K1 - M1 * omega**2), factor * G
    state = {"x1": -X * math.sin(lag), "v1": X * omega * math.cos(lag)}
    source = harmonic(frequency, X * impedance(omega, c))
    return fixed_block(source, c=c, k2=12400.0, t_end=periods / frequency, **state, **changes), omega, lag


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("short", (1e-3, 1e-6, 1e-9, 1e-12))
def test_no_contact_below_grazing(method, short):
    # V5: the wall is at -x1 = G, the trough at G (1 - short); rounding of state and source: some eps G
    touching, *_ = at_grazing(1 - short, method=method)
    result = run(touching)
    assert result.kinds == []
    assert result.totals["grazing_margin"] == pytest.approx(short * G, abs=200 * 2**-53 * G)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("beyond", (1e-3, 1e-6, 1e-9, 1e-12))
def test_contact_beyond_grazing(method, beyond):
    touching, omega, lag = at_grazing(1 + beyond, method=method)
    result = run(touching)
    assert result.kinds[:2] == ["contact_begin", "contact_end"]
    # X sin(w t - lag) = -G first at w t - lag = 3 pi / 2 - acos(1 / (1 + beyond)); eps of the level moves the
    # angle before the trough, q = sqrt(2 beyond), by eps / q
    early = math.acos(1 / (1 + beyond))
    expected = (1.5 * math.pi - early + lag) / omega
    assert result.times[0] == pytest.approx(expected, abs=200 * 2**-53 / early / omega + 1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_engines_agree_at_grazing(method):
    for factor in (1 - 1e-6, 1.0, 1 + 1e-6):
        touching, *_ = at_grazing(factor, method=method)
        fast, slow = run(touching, "c"), run(touching, "python")
        assert fast.kinds == slow.kinds
        assert fast.times.tolist() == slow.times.tolist()

"""Closed forms of linear, bilinear and rubbing oscillators; mirrored scenes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.random_scenes import scenes
from tests.scenes import CASE_NAMES, fixed_block, harmonic, paper, scene
from tests.trajectories import run

METHODS = ("closed_form", "taylor")
K1, M1, G = 200.0, 0.297, 0.001


def impedance(omega, c):
    """|k1 - m1 w^2 + i c w| [N/m]."""
    return math.hypot(K1 - M1 * omega**2, c * omega)


@pytest.mark.parametrize("method", METHODS)
def test_free_free_frequency(method):
    # V2: 4.3337 Hz = sqrt(k1 (1/m1 + 1/m2)) / (2 pi); y = 1 mm cos(w t), centre of mass at rest
    free = {"c": 0.0, "N": None, "k2": None, "G": None}
    result = run(scene(x1=0.001, t_end=5.0, method=method, **free))
    w = math.sqrt(K1 * (1 / 0.297 + 1 / 2.94))
    assert w / (2 * math.pi) == pytest.approx(4.3337, abs=5e-5)
    y = result.samples["x1"] - result.samples["x2"]
    # w t is rounded once or twice on the way: eps w t = 136 eps times the amplitude; Taylor adds 1 eps a step
    np.testing.assert_allclose(
        y, 0.001 * np.cos(w * result.samples["time"]), rtol=0, atol=0.001 * 1000 * 2**-53
    )
    centre = 0.297 * result.samples["x1"] + 2.94 * result.samples["x2"]
    np.testing.assert_allclose(centre, 0.297 * 0.001, rtol=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("frequency", (1.0, 4.13, 9.0))
def test_steady_amplitude(method, frequency):
    # V4, with c so large that the transient is below eps: exp(-c t / (2 m1)) = exp(-50)
    c, A, omega = 6.0, 0.3, 2 * math.pi * frequency
    result = run(fixed_block(harmonic(frequency, A), c=c, G=None, t_end=5.0, method=method))
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


# V3: with the stop at the rest position the relative motion is the bilinear oscillator.


@pytest.mark.parametrize("method", ("closed_form", "taylor"))
def test_bilinear_frequency(method):
    mobility = 1 / 0.297 + 1 / 2.94
    f1, f2 = (math.sqrt(k * mobility) / (2 * math.pi) for k in (200.0, 12600.0))
    assert (f1, f2) == pytest.approx((4.3337, 34.397), rel=2e-5)
    result = run(scene(x1=0.05, c=0.0, N=None, G=0.0, t_end=3.0, method=method))
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


# V6 and V7: Coulomb friction alone, with exact stops.


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("v0", (0.02, -0.02, 0.7))
def test_a_sliding_block_stops_and_stays(method, v0):
    mu_g = 0.001 * 9.81
    alone = scene(k1=0.0, c=0.0, k2=None, G=None, v2=v0, t_end=100.0, every_num=1, every_den=2, method=method)
    result = run(alone)
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


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("m1", "tolerance"), [(1e30, 2e-13), (1e12, 2e-8)])
def test_the_scaled_friction_oscillator(method, m1, tolerance):
    # Circles about -1 (x' > 0) and +1: from (12, 6) an arc of atan2(6, 13), then seven half turns.
    # A block 1 of 1e12 moves by x t^2 / (2 m1) = 3e-9 meanwhile.
    result = run(scaled_friction_oscillator(m1, method=method))
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


# V8: any scene mirrored gives the mirrored trajectory, bit for bit.


ODD = ("x1", "v1", "x2", "v2", "friction")  # change sign; all else stays: time, phi, phidot, contact, kinds


def mirrored(scene):
    """The scene seen in a mirror: signs of state and of A, F0 or e, and the stop on the other side."""
    names = ("A", "F0", "e", "x1", "v1", "x2", "v2")
    flipped = {name: -getattr(scene, name) for name in names if getattr(scene, name) is not None}
    return replace(scene, stop_sign=-scene.stop_sign, **flipped)


def assert_mirror_image(scene):
    one, other = run(scene), run(mirrored(scene))
    for table, image in ((one.samples, other.samples), (one.events, other.events)):
        for name, column in table.items():
            # without friction the flag means nothing and is absent; -0.0 == 0.0 holds
            np.testing.assert_array_equal(-image[name] if name in ODD else image[name], column, err_msg=name)
    assert one.totals == pytest.approx(other.totals, rel=0, abs=0, nan_ok=True)
    return one


@pytest.mark.parametrize("name", CASE_NAMES)
def test_papers_cases_mirrored(name):
    result = assert_mirror_image(paper(name, t_end=60.0))
    assert result.totals["impacts"] > 10


@settings(max_examples=150)
@given(scenes(features=False))
def test_random_scenes_mirrored(scene):
    assert_mirror_image(scene)


@settings(max_examples=100)
@given(scenes(sources=("none", "harmonic"), features=False))
def test_random_scenes_mirrored_by_taylor(scene):
    assert_mirror_image(replace(scene, method="taylor"))

"""Sticking takes a direction: it is counted, and the exponent of that direction is minus infinity."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.engine.runs import run
from tests.scenes import fixed_block, harmonic, paper, scene
from tests.tangent.test_liouville import exponents
from vibsim.engine.tangent.tangent_space import plainly_weighed_alike, weights
from vibsim.physics.numbers import Doubles

m1, m2, k1 = 0.297, 2.94, 200.0


def resting(method, **changes):
    """Block 2 stuck from the start to the end, block 1 vibrating with |S| < N."""
    period = 2 * math.pi / math.sqrt(k1 / m1 - (0.5 / m1) ** 2)
    fields = {"N": 10.0, "c": 1.0, "k2": None, "G": None, "x1": 0.01, "t_end": 20 * period}
    return scene(None, **{**fields, **changes}, method=method)


@pytest.mark.parametrize("method", ["closed_form", "taylor"])
def test_a_block_that_never_moves(method):
    found, fewer = (exponents(resting(method), count) for count in (None, 2))
    for one in (found, fewer):
        np.testing.assert_allclose(one.exponents[:2], -1.0 / (2 * m1), rtol=1e-12)
        assert one.rank_losses == 1
    assert found.exponents[2] == -math.inf and len(fewer.exponents) == 2
    assert abs(found.volume_residual) < 1e-11  # of the two directions that are left
    assert math.isnan(fewer.volume_residual)  # a bundle that is not complete spans no volume


def test_every_sticking_in_the_span_counts():
    case = paper("I-A", t_end=30.0)
    found, events = exponents(case, begin=10.0), run(case).events
    begin = found.span[0]
    stuck = int(events["friction"][events["t"] <= begin][-1] == 0)
    sticks = int(np.count_nonzero(events["kind"][events["t"] > begin] == 4))
    assert found.rank_losses == sticks + stuck > 20
    assert found.exponents[2] == -math.inf and np.all(np.isfinite(found.exponents[:2]))


def test_a_sticking_before_the_span_leaves_all_directions():
    case = paper("I-B", t_end=30.0)  # starts stuck, then slips for good
    assert exponents(case).rank_losses == 1
    later = exponents(case, begin=10.0)
    assert later.rank_losses == 0 and np.all(np.isfinite(later.exponents))


def test_a_span_that_begins_at_rest_counts_it():
    case = paper("I-A", t_end=30.0)
    events = run(case).events
    stick = int(np.flatnonzero((events["kind"] == 4) & (events["t"] > 10.0))[0])
    since, until = events["t"][stick], events["t"][stick + 1]
    found = exponents(replace(case, t_end=float(until)), begin=float(since + until) / 2)
    assert since < found.span[0] < until
    assert found.rank_losses == 1 and found.exponents[2] == -math.inf


# What disturbances are measured by, and which changes of a scene leave it as it is.


SCENE = paper("II-B").as_parts()
LINK, STOP, BODY, MOTOR = SCENE.links[0], SCENE.stops[0], SCENE.bodies[0], SCENE.motor
CHANGES = {
    "damping": ({"links": (replace(LINK, c=2 * LINK.c + 1),)}, True),
    "no-load speed": ({"motor": replace(MOTOR, Omega0=2 * MOTOR.Omega0)}, True),
    "spring": ({"links": (replace(LINK, k=2 * LINK.k),)}, False),
    "mass": ({"bodies": (replace(BODY, m=2 * BODY.m), *SCENE.bodies[1:])}, False),
    "arm of the motor": ({"motor": replace(MOTOR, e=2 * MOTOR.e)}, False),
}


@pytest.mark.parametrize(("parts", "alike"), CHANGES.values(), ids=CHANGES.keys())
def test_weights_follow_springs_masses_and_the_arm(parts, alike):
    other = SCENE.but(**parts)
    assert plainly_weighed_alike(SCENE, other) is alike
    assert (weights(SCENE, Doubles) == weights(other, Doubles)) is alike


def test_a_stop_that_is_another_is_not_plainly_alike():
    """Its stiffness weighs where no link has a spring."""
    assert not plainly_weighed_alike(SCENE, SCENE.but(stops=(replace(STOP, k=2 * STOP.k),)))


# Events crossed almost tangentially are told: first order holds for ever smaller disturbances there.


M1, K1, c, FREQUENCY, GAP = 0.297, 200.0, 1.0, 3.0, 0.001
OMEGA = 2 * math.pi * FREQUENCY
IMPEDANCE = math.hypot(K1 - M1 * OMEGA**2, c * OMEGA)


def grazing(ratio, periods=30):
    """The steady vibration whose amplitude without the stop would be `ratio` times the gap (V5)."""
    amplitude = ratio * GAP
    lag = math.atan2(c * OMEGA, K1 - M1 * OMEGA**2)
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

"""The impact pair: its symmetric motion, where that loses its symmetry, and the motions that leave there.

A ball strikes each wall of a box once in a period, with the speed u between them; X = A sin(w t) is the box,
b half of the play, e the restitution, tau = pi / w a flight. The linearised half period from behind a blow
(dt, dv) to behind the next one, mirrored, has the trace 2 e - X'' tau (1 + e)^2 / (2 u) and the determinant
e^2, with X'' = w^2 (pi u / (2 w) - b) at the blow. Symmetry is lost where one of its multipliers is -1: there
X'' = 2 u / tau, and A = b sqrt((2 / pi)^2 + ((1 - e) / (1 + e))^2) / (pi / 2 - 2 / pi).
"""

from math import pi, sqrt

import numpy as np
import pytest

import vibsim

W, B, E = 10 * pi, 10.0, 0.7  # [rad/s], [mm]
TAU, RATIO = pi / W, (1 - E) / (1 + E)
BROKEN = B * sqrt((2 / pi) ** 2 + RATIO**2) / (pi / 2 - 2 / pi)  # [mm]


@pytest.fixture(scope="module")
def symmetric():
    return vibsim.continue_branch("gallery/impact-pair", "base.a", "4:9 mm")


@pytest.fixture(scope="module")
def broken(symmetric):
    return vibsim.continue_branch(symmetric, switch="BP1")


def half_period(amplitude):
    """Trace of the mirrored half period at an amplitude of the box [mm]."""
    square = (pi / (2 * W)) ** 2 + (RATIO / W) ** 2
    u = (pi * B / W + sqrt((pi * B / W) ** 2 - 4 * square * (B**2 - amplitude**2))) / (2 * square)
    return 2 * E - W**2 * (pi * u / (2 * W) - B) * TAU * (1 + E) ** 2 / (2 * u)


def test_it_loses_its_symmetry_where_mechanics_says(symmetric):
    (special,) = symmetric.specials
    assert special.kind == "branch point" and special.jump == 1
    assert special.parameter == pytest.approx(BROKEN, rel=1e-12)


def test_its_multipliers(symmetric):
    """Those of the half period squared: trace t^2 - 2 e^2, product e^4."""
    traces = np.array([half_period(amplitude) for amplitude in symmetric["parameter"]])
    sums, products = (of(symmetric["multipliers"], axis=1).real for of in (np.sum, np.prod))
    np.testing.assert_allclose(sums, traces**2 - 2 * E**2, rtol=0, atol=1e-11)
    np.testing.assert_allclose(products, E**4, rtol=1e-11)


def test_beyond_it_one_flight_is_longer(broken):
    """The branch begins at the special point, stable, towards larger amplitudes, and its flights part."""
    assert broken["parameter"][0] == pytest.approx(BROKEN, rel=1e-4) and broken["parameter"][0] > BROKEN
    assert broken["stable"].all() and broken["parameter"][-1] == pytest.approx(9.0, rel=1e-14)
    np.testing.assert_allclose(np.prod(broken["multipliers"], axis=1).real, E**4, rtol=1e-10)
    family, last = broken.plan.family(), broken.points[-1]
    carried = family(np.array(last.unknowns)).end.carried
    blows = [t for (kind, _), t in zip(carried.events, carried.times, strict=True) if kind == "impact"]
    assert len(blows) == 2 and abs(blows[1] - blows[0] - TAU) > 0.1 * TAU


def test_seen_from_a_prong_it_is_a_branch_point():
    """The branch of unequal flights turns round there, among its own mirror images, with a multiplier that
    touches 1: that was listed as a fold and a branch point side by side.
    """
    orbit = vibsim.orbit("gallery/impact-pair", {"base.a": "7.6 mm", "initial.ball.v": "0.25 m/s"})
    branch = vibsim.continue_branch(orbit, "base.a", "7:8 mm")
    (special,) = branch.specials
    assert special.kind == "branch point" and special.jump == 0
    assert special.parameter == pytest.approx(BROKEN, rel=1e-11)
    assert dict(branch.lines())["index check"] == "holds everywhere"
    assert dict(branch.lines())["ends"] == "end of the range"
    np.testing.assert_allclose(branch["parameter"][[0, -1]], 8.0, rtol=1e-14)
    back = vibsim.continue_branch(branch, switch=special.label)
    (crossed,) = back.specials  # the branch goes through there, and is followed both ways
    assert crossed.kind == "branch point" and abs(crossed.jump) == 1
    assert crossed.parameter == pytest.approx(BROKEN, rel=1e-12)
    np.testing.assert_allclose(back["parameter"][[0, -1]], [7.0, 8.0], rtol=1e-14)
    sums = np.sum(back["multipliers"], axis=1).real
    np.testing.assert_allclose(sums, [half_period(a) ** 2 - 2 * E**2 for a in back["parameter"]], atol=1e-9)

import numpy as np
import pytest

from tests.scenes import scene
from vibsim.evidence.peers.solvers import RungeKutta4, TimeLimit

STEPS = (8e-3, 4e-3, 2e-3, 1e-3, 5e-4)
RELEASE = 1e-3  # m


def free_vibration(made, times):
    """x1 [m] of two blocks on a spring, released from x1 = RELEASE at rest: elementary."""
    total = made.m1 + made.m2
    rate = np.sqrt(made.k1 * total / (made.m1 * made.m2))
    return RELEASE * (made.m1 + made.m2 * np.cos(rate * times)) / total


def smooth(**changes):
    """Two blocks and a spring: no stop, no friction, no damper, no source."""
    return scene(k2=None, G=None, N=None, c=0.0, x1=RELEASE, **changes)


def test_order_four_on_a_smooth_scene():
    made, times = smooth(), np.linspace(0, 2.0, 11)
    errors = []
    for step in STEPS:
        attempt = RungeKutta4(made.as_parts(), step).run(times, TimeLimit())
        errors.append(np.abs(attempt.states[:, 0] - free_vibration(made, times)).max())
        assert attempt.steps == round(2.0 / step) and attempt.evaluations == 4 * attempt.steps
    order, _ = np.polyfit(np.log(STEPS), np.log(errors), 1)
    assert order == pytest.approx(4, abs=0.2)


def test_the_step_divides_the_sampling_interval():
    attempt = RungeKutta4(smooth().as_parts(), 3e-3).run(np.array([0.0, 0.01, 0.02]), TimeLimit())
    assert attempt.steps == 8  # 4 steps of 2.5 ms each


def test_what_is_no_longer_finite_is_a_failure():
    with pytest.raises(ArithmeticError, match=r"no longer finite at \d"):
        RungeKutta4(smooth(k1=1e9).as_parts(), 0.1).run(np.linspace(0, 200.0, 11), TimeLimit())

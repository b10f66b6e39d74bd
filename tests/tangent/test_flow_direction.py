"""Without an ideal source no time occurs: the motion's own direction is carried along, through all events."""

from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import paper, scene
from vibsim.engine.driver import Driver
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import EVENT_NAMES
from vibsim.physics.two_blocks import motor_accelerations, transmitted_force


def direction(scene, state, status):
    """Rate of change of (x1, v1, ...), from the equations as printed, where x1 is measured from block 2."""
    (x1, x2), (v1, v2) = state.x, state.v
    force = transmitted_force(scene, x1 - x2, v1 - v2, status.stops[0])
    a1, rotor = -force / scene.m1, []
    if scene.has_motor:
        a1, dw = motor_accelerations(scene, force, np.sin(state.phase), np.cos(state.phase), state.w)
        rotor = [state.w, dw]
    slip = status.frictions[0]
    a2 = (force - slip * scene.N) / scene.m2 if slip else 0.0
    return [v1 - v2, 0.0, a1, a2, *rotor]


def carried(scene, method):
    """The direction at the start, carried to the end; the direction there; kinds of the events between."""
    driver = Driver(replace(scene, method=method).as_parts(), Doubles, tangent=(1, 0.0))
    driver.tangent.vectors = [direction(scene, driver.state, driver.status)]
    while not driver.finished:
        driver.run(10**9, 10**9, 10**6)
    ours = np.exp(driver.tangent.sums[0]) * np.array(driver.tangent.vectors[0])
    kinds = [EVENT_NAMES[code] for code, *_ in driver.events]
    return ours, np.array(direction(scene, driver.state, driver.status)), kinds


@pytest.mark.parametrize(("name", "t_end"), [("II-A", 15.0), ("II-B", 8.0), ("II-C", 6.0)])
def test_the_motors_cases(name, t_end):
    ours, theirs, kinds = carried(paper(name, t_end=t_end), "taylor")
    # errors grow no faster than neighbours part; by less than 1e4 here
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-10 * np.max(np.abs(theirs)))
    assert kinds.count("contact_begin") > 10 and kinds.count("reversal") + kinds.count("stick_begin") > 10


@pytest.mark.parametrize("method", ["closed_form", "taylor"])
def test_a_free_vibration_with_impacts_and_friction(method):
    released = scene(x1=0.02, v1=0.3, v2=-0.01, N=2.0, t_end=1.5, method=method)
    ours, theirs, kinds = carried(released, method)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-10 * np.max(np.abs(theirs)))
    assert {"contact_begin", "reversal", "stick_begin", "stick_end"} <= set(kinds)

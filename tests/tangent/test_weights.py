"""What disturbances are measured by, and which changes of a scene leave it as it is."""

from dataclasses import replace

import pytest

from tests.scenes import paper
from vibsim.engine.tangent.tangent_space import plainly_weighed_alike, weights
from vibsim.physics.numbers import Doubles

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

"""Where orbits end because a static force carries bodies off.

Over a period of a motion that returns, the mean force on bodies that nothing but dry friction holds is zero:
their static force is no larger than what the frictions between them and the rest can take. Where it comes to
be larger there is no orbit: they speed up without end.
"""

from vibsim.branches.curve.arclength import NoCase
from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node
from vibsim.cases.number import number
from vibsim.physics.body_sets import BodySet, body_sets
from vibsim.physics.parts import Scene

NEAR = 1e-6  # scaled distance of the last orbit from where the force is as large as what friction takes


def carried_off(family: Family, node: Node, sense: float) -> str | None:
    """Words on the bodies that a static force carries off just beyond a node, in the sense in which the
    parameter goes on; None where it carries none.
    """
    unit = float(family.scale[-1])
    within, beyond = node.parameter, node.parameter + sense * NEAR * unit
    try:
        if _overcome(family.map(within).scene) is not None:
            return None
        bodies = _overcome(family.map(beyond).scene)
        if bodies is None:
            return None
        while within != (middle := (within + beyond) / 2) != beyond:
            there = _overcome(family.map(middle).scene)
            within, beyond = (middle, beyond) if there is None else (within, middle)
    except NoCase:
        return None
    names = [family.map(node.parameter).scene.bodies[body].name for body in bodies.bodies]
    value = f"{number(within, 12)} {family.unit}".rstrip()
    return (
        f"friction takes the static force on {' and '.join(names)} up to {value}: beyond, it speeds them up "
        "without end"
    )


def _overcome(scene: Scene) -> BodySet | None:
    """Bodies on which the static force is more than friction can take; None where there are none."""
    for bodies in body_sets(scene, [*scene.links, *scene.stops]):
        motor = scene.motor is not None and scene.motor.on in bodies.bodies
        if not (bodies.held or motor) and _excess(scene, bodies) > 0:
            return bodies
    return None


def _excess(scene: Scene, bodies: BodySet) -> float:
    """The static force on bodies less the most that friction can take of it [N]."""
    force = sum(each.constant for each in scene.forces if each.on in bodies.bodies)
    taken = 0.0
    for friction in scene.frictions:
        inside = [end in bodies.bodies for end in (friction.P, friction.Q)]
        if inside[0] != inside[1]:
            against_forward, against_backward = friction.limits
            taken += against_forward if (force > 0) == inside[0] else against_backward
    return abs(force) - taken

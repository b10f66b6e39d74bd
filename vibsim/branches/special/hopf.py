"""Where a branch of free vibrations shrinks to a state of rest: the Hopf point.

The section of a scene that nothing drives is where a body turns round. Its acceleration there, the swing,
goes through zero with the amplitude; beyond lie the same orbits, seen at their other turn. Parameter and
period are smooth over it, though singular for Newton's method at zero itself (Kuznetsov, Elements of Applied
Bifurcation Theory, section 3.4): they are taken there by the polynomial through orbits on both sides.
"""

import numpy as np

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node
from vibsim.branches.curve.way import Way, at_zero, regula_falsi
from vibsim.branches.special.special import HOPF, Special
from vibsim.orbits.matrices import length_of

SHARES = (-0.4, 0.4, -0.25, 0.25, -0.15, 0.15)  # distances of these orbits, of the room for them
# The least room, scaled: that to the nearer end if it is more. Rounding of 1e-16 over the swing there, some
# 1e-4, is 1e-12 of the parameter; the polynomial leaves out the sixth power of the room.
ROOM = 4e-3
FINE, TRIES = 1e-6, 40  # share of it at which the place is known well enough to begin with
SHRINKS = 0.5  # share of the rates of change that is left near rest: more, and the body alone stands still


def swing(node: Node) -> float:
    """Acceleration of the body at its turn, over the section that it makes [m/s^2]; 0 for a state of rest."""
    tilt = node.point.end.tilt
    assert tilt is not None
    return float(tilt[1])


def hopf_point(family: Family, one: Node, other: Node) -> Special | None:
    """The Hopf point between two nodes; None where there is none."""
    section = one.point.end.coordinates.section
    if not section.turning or one.word or other.word or swing(one) * swing(other) >= 0:
        return None
    try:
        least, nodes = _near_rest(Way(family, one, other))
    except ContinuationError:
        return None
    if not _pace(least) < SHRINKS * _pace(one):
        return None
    z = least.z.copy()
    for i in (-2, -1):  # period and parameter
        z[i] = at_zero([(swing(node), float(node.z[i])) for node in nodes])
    return Special(HOPF, Node.of(family(z), one.tangent, least.iterations), one, one)


def _pace(node: Node) -> float:
    """Size of the velocities and accelerations at the turn [m/s^2]."""
    end = node.point.end
    count, rates = len(end.coordinates.scene.bodies), end.carried.rate
    return length_of(np.array([*(rates[:count] * 2 * np.pi / end.T), *rates[count : 2 * count]]))


def _near_rest(way: Way) -> tuple[Node, list[Node]]:
    """The orbit of the least swing, and others of little, one way and the other. Raises ContinuationError."""
    _, near = regula_falsi(way, swing, TRIES, FINE)
    place = next(share for share, node in way.known if node is near)
    way.known = [(share, node) for share, node in way.known if swing(node)]  # rest itself has no derivative
    room = max(min(place, 1 - place), ROOM / way.length)
    least = min((node for _, node in way.known), key=lambda node: abs(swing(node)))
    return least, [way.node(place + share * room) for share in SHARES]

"""Where a branch ends because a rigid stop is grazed: the graze itself, past the touch.

On the side with the impact multipliers grow without bound, on the other the motion meets the stop: no step of
the branch gets there. Past the touch the orbits go on smoothly, and the graze is where they reach the stop.
"""

import numpy as np

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.correction import CLOSE, ROUGH
from vibsim.branches.curve.family import Family, FamilyPoint
from vibsim.branches.curve.node import Node
from vibsim.branches.special.special import GRAZING, Special
from vibsim.branches.special.touching import TouchFamily, windows_of
from vibsim.orbits.matrices import least_squares, length_of
from vibsim.orbits.returns.word import Word, circle

STEPS = 12
EPS = 2.0**-52
DIFFERENCE = 2.0**-30  # of a scaled unknown: hops that an incomplete chatter ends with are as short as 1e-8
NEAR = 0.1  # scaled distance from the last orbit of the branch


def grazing_end(family: Family, node: Node) -> Special | None:
    """The graze of a rigid stop near the last orbit of a branch; None where there is none."""
    scene = node.point.end.coordinates.scene
    for stop, _ in scene.rigid_stops:
        found = _graze(family, node, stop)
        if found is None:
            continue
        point, middle = found
        at = Node(point, node.heading, 0)
        impacting = _impacts(node.word, stop) > _impacts(at.word, stop)
        touched = node.word if impacting else _with(point, middle, stop)
        words = (node.word, at.word) if touched == node.word else (node.word, touched)
        return Special(GRAZING, at, node, at, words)
    return None


def _graze(family: Family, node: Node, stop: int) -> tuple[FamilyPoint, float] | None:
    """The nearest orbit that grazes a stop, and when [s / period]; None without any."""
    try:
        for window in windows_of(family.map(node.parameter), node.point.end.X, node.point.period, stop):
            point = _touched(TouchFamily(family, window), node)
            if point is not None:
                return point, window.middle
    except ContinuationError:
        pass
    return None


def _touched(past: TouchFamily, node: Node) -> FamilyPoint | None:
    """The orbit near a node that grazes in a window; None where there is none."""
    z, last = node.z, np.inf
    try:
        for _ in range(STEPS):
            point = past(z)
            beside = [past(z + shift).end.clearance for shift in DIFFERENCE * np.eye(len(z))]
            gradient = (np.array(beside) - point.end.clearance) / DIFFERENCE
            size = length_of(gradient) or 1.0
            matrix = np.vstack([point.jacobian(), gradient / size])
            if not np.isfinite(matrix).all():  # another stop is grazed
                return None
            missing = np.append(point.residual, point.end.clearance / size)
            step = -least_squares(matrix, missing, EPS * len(matrix))
            z = z + step
            if length_of(z - node.z) > NEAR:
                return None
            length = length_of(step)
            if length <= CLOSE or last / 2 <= length <= ROUGH:
                point = past(z)
                return point if np.isfinite(point.matrix).all() else None
            last = length
    except ContinuationError:
        pass
    return None


def _impacts(word: Word, stop: int) -> int:
    return sum(part == stop for _, part in word)


def _with(point: FamilyPoint, middle: float, stop: int) -> Word:
    """The word with the touch in its place, at a share of the period."""
    end = point.end
    before = int(np.count_nonzero(end.carried.times < middle * end.T))
    return circle((*end.events[:before], ("impact", stop), *end.events[before:]))

"""From a special point of a branch to the branch that leaves it there.

At a period doubling the orbits of 2 n periods leave along the eigenvector of the multiplier -1: seen over 2 n
periods the doubling is a pitchfork, whose other curve has the tangent (v, 0) at first. At a branch point the
other branch leaves along what of the kernel the known branch does not span.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from vibsim.branches.branch import Branch, SpecialPoint
from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node, node_at
from vibsim.branches.plan import BranchError, BranchPlan
from vibsim.branches.special.special import BRANCHING, DOUBLING, NAMES
from vibsim.branches.tracing.joining import shift
from vibsim.orbits.matrices import directions, length_of, product
from vibsim.orbits.returns.word import cyclic

FIRST, TRIES = 2.0**-8, 8  # scaled distance of the first orbit from the special point, halved so often


def switched(branch: Branch, label: str, span: tuple[float, float] | None = None) -> BranchPlan:
    """The plan of the branch that leaves another at its special point `label`.

    span : range of the parameter; that of the branch where it is left out

    Raises BranchError for a label that is none, or from which no branch leaves.
    """
    try:
        special = branch.special(label)
    except KeyError as error:
        raise BranchError(str(error.args[0])) from None
    if special.kind not in (DOUBLING, BRANCHING):
        raise BranchError(
            f"{label} is {NAMES[special.kind]}: branches leave doublings (PD) and branch points (BP)"
        )
    plan, times = branch.plan, 2 if special.kind == DOUBLING else 1
    longer = replace(plan, n=times * plan.n, span=span or plan.span)
    family = replace(longer, period=times * plan.period).family()
    orbit = special.orbit
    z = family.unknowns(np.array(orbit.state), times * orbit.period, orbit.parameter)
    node = _first(family, special, z)
    values = node.z * family.scale
    state = tuple(values[: len(special.orbit.state)].tolist())
    away = (node.z - z) / length_of(node.z - z)
    heading = () if times == 1 and _goes_through(family, z, node, away) else tuple(away.tolist())
    return replace(longer, state=state, period=node.point.period, parameter=node.parameter, heading=heading)


def _first(family: Family, special: SpecialPoint, z: np.ndarray) -> Node:
    """An orbit beside the special point z on the branch that leaves it. Raises BranchError."""
    direction = _direction(family, special, z)
    size, other = FIRST, None
    for _ in range(TRIES):
        try:
            node = node_at(family, z + size * direction, direction, None, 8 * size)
        except ContinuationError:
            size /= 2
            continue
        if length_of(node.z - z) > size / 2 and _is_new(family, special, node, size):
            if _begins_there(special, node):
                return node
            other = other or node
        size /= 2
    if other is None:
        raise BranchError(f"no orbit was found on the branch that leaves {special.label}")
    return other


def _goes_through(family: Family, z: np.ndarray, node: Node, away: np.ndarray) -> bool:
    """Whether the branch that leaves a branch point z by a node, along a unit vector, has orbits on the other
    side of its parameter, too.
    """
    size = length_of(node.z - z)
    try:
        other = node_at(family, z - size * away, away, None, 8 * size)
    except ContinuationError:
        return False
    return bool((node.z[-1] - z[-1]) * (other.z[-1] - z[-1]) < 0)


def _begins_there(special: SpecialPoint, node: Node) -> bool:
    """Whether an orbit has the order of events with which the branch leaves: one with another lies beyond a
    change of order, and may be on the far side of a fold, or of another branch.
    """
    times = 2 if special.kind == DOUBLING else 1
    return node.word in [cyclic(word * times) for word in (special.before, special.after)]


def _is_new(family: Family, special: SpecialPoint, node: Node, size: float) -> bool:
    """Whether an orbit is none of the branch that is left: at a doubling, none that repeats itself before."""
    if special.kind != DOUBLING:
        return True
    return length_of(shift(family, node, family.n // 2)) > size / 8


def _direction(family: Family, special: SpecialPoint, z: np.ndarray) -> np.ndarray:
    """Unit vector, scaled, along which the branch leaves."""
    if special.kind == DOUBLING:
        return _of_doubling(family, special, z)
    point = family(z)
    known = np.array(special.tangent)
    _, vectors, _ = directions(point.jacobian())
    across = product(vectors[-2:], known)
    direction = across[1] * vectors[-2] - across[0] * vectors[-1]
    return np.asarray(direction / length_of(direction))


def _of_doubling(family: Family, special: SpecialPoint, z: np.ndarray) -> np.ndarray:
    """The eigenvector of -1, with the change of the time of return that goes with it: none at first."""
    count = len(special.orbit.state)
    half = family.map(special.orbit.parameter).of(family.n // 2)
    end = half(np.array(special.orbit.state), None if half.section.timed else special.orbit.period)
    scale = family.scale[:count]
    matrix = end.derivative * (scale / scale[:, None])
    _, vectors, _ = directions(matrix + np.eye(count))
    direction: Any = np.zeros(len(z))
    direction[:count] = vectors[-1]
    return np.asarray(direction)

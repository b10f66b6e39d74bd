"""Where a branch turns round because it comes to orbits of more symmetry: a pitchfork seen from its prongs.

Beyond it the branch is its own mirror image. A multiplier touches 1 there while the parameter turns round,
and no test value changes its sign but dp/ds; by rounding the multiplier may pass 1 and come back, which looks
like a fold and a branch point side by side.
"""

from collections.abc import Iterable

import numpy as np

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.family import Family, FamilyPoint
from vibsim.branches.curve.node import Node
from vibsim.branches.curve.way import Way, at_zero, regula_falsi
from vibsim.branches.special.special import BRANCHING, CORNER, FOLD, UNRESOLVED, Special
from vibsim.orbits.matrices import dot, least_squares, length_of, moduli

TOUCHES = 1e-4  # distance from 1 of the multiplier where the parameter turns: the square of the way
TRIES, FINE = 40, 1e-4  # evaluations while locating, and length of the last step
AWAY = 0.02  # scaled distance of the nodes that tell the place
CRITICAL, SETTLE = 1e-4, 3  # share of a critical singular value, and Newton steps across it
TURNS = (FOLD, BRANCHING, CORNER, UNRESOLVED)


def with_pitchfork(
    family: Family, one: Node, other: Node, specials: Iterable[Special]
) -> tuple[Special, ...]:
    """The special points between two nodes with the pitchfork where the branch turns round, if it is one."""
    listed = tuple(specials)
    turns = [each for each in listed if each.kind in TURNS]
    if one.ahead * other.ahead >= 0 or one.in_family or other.in_family or not _may_be_one(turns):
        return listed
    special = _pitchfork(family, *_between(turns, one, other))
    if special is None:
        return listed
    rest = [each for each in listed if each not in turns]
    chord = other.z - one.z
    return tuple(sorted([*rest, special], key=lambda each: dot(each.node.z - one.z, chord)))


def _may_be_one(turns: list[Special]) -> bool:
    """Whether what is listed of a turn is nothing, or a fold and a branch point that undo each other."""
    return not turns or (
        {each.kind for each in turns} == {FOLD, BRANCHING} and sum(t.jump for t in turns) == 0
    )


def _between(turns: list[Special], one: Node, other: Node) -> tuple[Node, Node]:
    """The nodes between which the branch turns round."""
    return (turns[0].before, turns[-1].after) if turns else (one, other)


def _pitchfork(family: Family, one: Node, other: Node) -> Special | None:
    """The pitchfork where the parameter turns round between two nodes.

    None where no multiplier is 1 there, or Newton's method fails.
    """
    if one.word != other.word:
        return None
    way = Way(family, one, other)
    try:
        _, turn = regula_falsi(way, lambda node: node.ahead, TRIES, FINE)
        if moduli(turn.multipliers - 1).min(initial=1.0) > TOUCHES:
            return None
        at = _settled(family, turn.z, _parameter(way, turn))
    except (ContinuationError, ZeroDivisionError):
        return None
    along = one.tangent + other.tangent  # at the place itself two curves cross, and the tangent is neither's
    return Special(BRANCHING, Node.of(at, np.asarray(along / length_of(along)), turn.iterations), one, other)


def _parameter(way: Way, turn: Node) -> float:
    """The scaled parameter of the pitchfork.

    It and det(P' - I) go like the square of the way, so the one is smooth over the other: taken to where the
    other is zero from nodes at some distance, as right there the derivative is singular.
    """
    chord = way.other.z - way.one.z
    place = dot(turn.z - way.one.z, chord) / way.length**2
    widest = min(AWAY / way.length, place / 2, (1 - place) / 2)
    values = []
    for side in (1, -1):
        nodes = [way.node(place + side * widest * share) for share in (1.0, 0.7, 0.5, 0.35)]
        values.append(at_zero([(node.fold, float(node.z[-1])) for node in nodes]))
    return sum(values) / 2


def _settled(family: Family, near: np.ndarray, parameter: float) -> FamilyPoint:
    """The orbit at a parameter near scaled unknowns, which no step leaves along the critical direction."""
    z = np.append(near[:-1], parameter)
    for _ in range(SETTLE):
        point = family(z)
        z[:-1] -= least_squares(point.linear, point.residual, CRITICAL)
    return family(z)

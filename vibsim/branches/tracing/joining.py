"""Where a branch of n periods joins one of fewer: beyond it, its orbits are those in front of it, shifted.

The change over n / d periods, P^(n/d)(X) - X, is zero at an orbit of n / d periods only. Along a branch that
leaves a doubling it turns round there: the orbits on the other side are the same, half their period later.
"""

import numpy as np

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node, between
from vibsim.orbits.matrices import dot, length_of
from vibsim.orbits.returns.word import Word

FINE = 2.0**-6  # share of a step at which its search ends: nearer, orbits are no longer told apart
HALVINGS = 40
JOINS = "joins"
CLOSES = 1e-10  # scaled: an orbit that comes that near to itself before its time is one of fewer periods


def joining(family: Family, one: Node, other: Node) -> tuple[Node, str] | None:
    """The last node before the branch joins one of fewer periods between two nodes, and a word on that;
    None where it does not.
    """
    for shorter in (d for d in range(1, family.n) if family.n % d == 0):
        if dot(shift(family, one, shorter), shift(family, other, shorter)) < 0:
            node = _last_before(family, one, other, shorter)
            return node, _words(shorter)
    return None


def _words(periods: int) -> str:
    return f"{JOINS} the orbits of {periods} period{'s' * (periods > 1)}"


def repetition(family: Family, node: Node) -> str | None:
    """A word on it where the orbit at a node is one of fewer periods gone through again, else None.

    Newton's method may go over to such orbits from a branch that comes near them: where it joins them they
    are on both sides of it, and no test value changes its sign.
    """
    shorter = (d for d in range(1, family.n) if family.n % d == 0 and _repeats(node.word, family.n // d))
    again = (d for d in shorter if length_of(shift(family, node, d)) <= CLOSES)
    return next((_words(periods) for periods in again), None)


def _repeats(word: Word, times: int) -> bool:
    """Whether a word is one so many times."""
    return len(word) % times == 0 and word == word[: len(word) // times] * times


def shift(family: Family, node: Node, periods: int) -> np.ndarray:
    """P^periods(X) - X at a node, scaled."""
    end = node.point.end
    T = None if end.tilt is None else end.T * periods / family.n
    change = family.map(node.parameter).of(periods)(end.X, T).difference
    return np.asarray(change / family.scale[: len(end.X)])


def _last_before(family: Family, one: Node, other: Node, periods: int) -> Node:
    """By halving the stretch, as far as Newton's method goes: at the place itself its matrix is singular, and
    near it Newton's method may find the orbit of fewer periods.
    """
    low, high = 0.0, 1.0
    node, reference = one, shift(family, one, periods)
    for _ in range(HALVINGS):
        if high - low < FINE:
            break
        middle = (low + high) / 2
        try:
            tried = between(family, one, other, middle)
        except ContinuationError:
            high = middle
            continue
        change = shift(family, tried, periods)
        if dot(change, reference) < 0 or length_of(change) <= CLOSES:
            high = middle
        else:
            low, node = middle, tried
    return Node.of(node.point, node.tangent, node.iterations)

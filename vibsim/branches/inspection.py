"""What happened between two neighbouring points of a branch, each event found and located.

Index check: the number of multipliers outside the unit circle may change only by what was detected: by one
at a fold, a branch point or a doubling, by two at a Neimark-Sacker point, by anything where a change of the
order of events makes the derivative of the map jump. A stretch that shows more than one event, or does not
satisfy the check, is halved until each part has one event at most. At an event that was located the other
multipliers must be on the side of the circle that they are on at both ends of its stretch: of a
Neimark-Sacker point a hair before a fold the ends alone say nothing. Multipliers of conservative orbits come
as mu and 1 / mu (`vibsim.branches.reciprocal`): where a pair passes 1 or -1 one of them leaves the circle,
where two pairs meet on it two do.
"""

from collections.abc import Callable, Iterator
from itertools import combinations

import numpy as np

from vibsim.branches.arclength import ContinuationError
from vibsim.branches.family import Family
from vibsim.branches.node import Node, between
from vibsim.branches.special import (
    BRANCHING,
    CORNER,
    DOUBLING,
    FOLD,
    TORUS,
    UNRESOLVED,
    Special,
    kind_of_change,
)

SHORT = 1e-9  # scaled length of a stretch that is not halved any more to part its events
LONGEST_PART = 0.9  # of a stretch that is halved
NARROW = 4e-15  # scaled length of a bracket that a change of the order of events is located in
TRIES = 100  # evaluations while locating
NEAR = 1e-3  # how far a located multiplier may be from where it crosses the circle [-]

CHANGE = "change of order"
SMOOTH = (FOLD, DOUBLING, TORUS, BRANCHING)

Test = Callable[[Node], float]


def inspect(family: Family, one: Node, other: Node) -> Iterator[Special]:
    """The special points between two nodes, in their order."""
    detected = detect(one, other)
    if not detected and one.index == other.index:
        return
    middle = None if len(detected) == 1 else _middle(family, one, other)
    if middle is None:
        special = _located(family, detected, one, other)
        if special is not None:
            yield from _with_sides(family, special, one, other)
            return
        middle = _middle(family, one, other)
    if middle is None:
        yield from _unparted(family, detected, one, other)
        return
    yield from inspect(family, one, middle)
    yield from inspect(family, middle, other)


def _unparted(family: Family, detected: list[str], one: Node, other: Node) -> Iterator[Special]:
    """What lies between two nodes that are too near to be parted: changes of order one by one, as where a
    motion that is its own mirror image changes on both sides at once.
    """
    try:
        special = _change(family, one, other, first=True) if CHANGE in detected else None
    except ContinuationError:
        special = None
    if special is None:
        yield Special(UNRESOLVED, other, one, other)
    else:
        yield from _with_sides(family, special, one, other)


def _with_sides(family: Family, special: Special, one: Node, other: Node) -> Iterator[Special]:
    """A special point with what else lies on both sides of a change of order; a bifurcation is alone."""
    if special.kind in SMOOTH:
        yield special
        return
    yield from inspect(family, one, special.before)
    yield special
    yield from inspect(family, special.after, other)


def detect(one: Node, other: Node) -> list[str]:
    """Kinds of what must have happened between two nodes; a change of the order of events is called so."""
    kinds, conservative = [], one.point.family.conservative
    if conservative or not (one.in_family or other.in_family):
        if one.ahead * other.ahead < 0:
            kinds.append(FOLD)
        elif one.fold * other.fold < 0:
            kinds.append(BRANCHING)
    if one.doubling * other.doubling < 0:
        kinds.append(DOUBLING)
    if not kinds and one.index != other.index and _left_the_circle(one, other, conservative):
        kinds.append(TORUS)
    if one.word != other.word:
        kinds.append(CHANGE)
    return kinds


def _left_the_circle(one: Node, other: Node, conservative: bool) -> bool:
    """Whether a pair of multipliers, or two that met, crossed the circle elsewhere than at 1 and -1."""
    if conservative:
        return one.collision * other.collision < 0
    return one.pairs_outside != other.pairs_outside


def _located(family: Family, detected: list[str], one: Node, other: Node) -> Special | None:
    """The one event of a stretch, or of several that are too near to be parted the change of order.

    None where it was not what it seemed, or more happens.
    """
    try:
        if CHANGE in detected:
            return _change(family, one, other)
        if len(detected) != 1:
            return None
        _, node = bracketed(family, one, other, test_of(detected[0], one, other))
    except ContinuationError:
        return None
    special = Special(detected[0], node, one, other)
    return special if _index_explained(special) else None


def test_of(kind: str, one: Node, other: Node) -> Test:
    """The function of a node that changes its sign at an event of a kind between two nodes."""
    if kind == DOUBLING:
        return lambda node: node.doubling
    if kind in (FOLD, BRANCHING):
        return (lambda node: node.fold) if one.fold * other.fold < 0 else (lambda node: node.ahead)
    if one.point.family.conservative:
        return lambda node: node.collision
    outside = one if one.pairs_outside > other.pairs_outside else other
    pair = min((mu for mu in outside.pairs if abs(mu) > 1), key=lambda mu: abs(abs(mu) - 1))
    return lambda node: node.torus(pair)


def bracketed(family: Family, low: Node, high: Node, test: Test) -> tuple[Node, Node]:
    """Neighbours on both sides of a zero of `test`, the second the better.

    By regula falsi after Anderson and Bjorck (BIT 13, 1973). Raises ContinuationError.
    """
    a, b = test(low), test(high)
    left, right = 0.0, 1.0
    ends = low, high
    if not a * b < 0:
        raise ContinuationError("the test does not change its sign")
    f_left, f_right = a, b
    for _ in range(TRIES):
        share = right - f_right * (right - left) / (f_right - f_left)
        if not min(left, right) < share < max(left, right):
            break
        node = between(family, *ends, share)
        value = test(node)
        if value == 0:
            return node, node
        if value * f_right < 0:
            left, f_left, low = right, f_right, high
        else:
            shrink = 1 - value / f_right
            f_left *= shrink if shrink > 0 else 0.5
        moved = abs(share - right)
        right, f_right, high = share, value, node
        if moved * np.linalg.norm(ends[1].z - ends[0].z) < 1e-14:
            break
    return low, high


def _index_explained(special: Special) -> bool:
    """Whether the other multipliers are at the event where they are at both ends of its stretch."""
    before, at, after = special.before, special.node, special.after
    if at.point.family.conservative:
        return _pairs_explained(special)
    distance = {
        FOLD: abs(at.multipliers - 1),
        BRANCHING: abs(at.multipliers - 1),
        DOUBLING: abs(at.multipliers + 1),
        TORUS: abs(abs(at.multipliers) - 1) + (abs(at.multipliers.imag) == 0),
    }[special.kind]
    count = 2 if special.kind == TORUS else 1
    order = np.argsort(distance)
    if distance[order[count - 1]] > NEAR:
        return False
    rest = int(np.sum(np.abs(at.multipliers[order[count:]]) > 1))
    return sorted((before.index, after.index)) == [rest, rest + count]


def _pairs_explained(special: Special) -> bool:
    """The same of a conservative orbit: one pair at 1 or -1, or two that meet on the circle."""
    traces, count = special.node.point.reciprocal.traces, 2 if special.kind == TORUS else 1
    at: tuple[int, ...]
    if special.kind == TORUS:
        pairs = combinations(range(len(traces)), 2)
        at = min(pairs, key=lambda pair: abs(traces[pair[0]] - traces[pair[1]]))
        near = abs(traces[at[0]] - traces[at[1]]) < NEAR and abs(traces[at[0]].real) < 2
    else:
        place = -2 if special.kind == DOUBLING else 2
        at = (min(range(len(traces)), key=lambda i: abs(traces[i] - place)),)
        near = abs(traces[at[0]] - place) < NEAR
    rest = sum(tau.imag != 0 or abs(tau.real) > 2 for i, tau in enumerate(traces) if i not in at)
    return near and sorted((special.before.index, special.after.index)) == [rest, rest + count]


def _change(family: Family, one: Node, other: Node, first: bool = False) -> Special | None:
    """A change of the order of events by bisection; None where there is a third order between that can be
    parted from the others, unless the first change is asked for.
    """
    low, high = one, other
    for _ in range(TRIES):
        if np.linalg.norm(high.z - low.z) <= NARROW:
            break
        middle = between(family, low, high, 0.5)
        if middle.word == low.word:
            low, stuck = middle, np.array_equal(middle.z, low.z)
        elif first or middle.word == high.word or _inseparable(low, high):
            high, stuck = middle, np.array_equal(middle.z, high.z)
        else:
            return None
        if stuck:
            break
    kind = CORNER if low.ahead * high.ahead < 0 else kind_of_change(low.word, high.word)
    return Special(kind, high, low, high)


def _inseparable(one: Node, other: Node) -> bool:
    """Whether two nodes are too near to be parted."""
    return bool(np.linalg.norm(other.z - one.z) <= SHORT)


def _middle(family: Family, one: Node, other: Node) -> Node | None:
    """The node about halfway between two; None where they are too near, or Newton's method fails or leads
    elsewhere, as it may within a family of orbits.
    """
    if _inseparable(one, other):
        return None
    length = float(np.linalg.norm(other.z - one.z))
    for share in (0.5, 0.4, 0.6, 0.3, 0.7):
        try:
            middle = between(family, one, other, share)
        except ContinuationError:
            continue
        if max(np.linalg.norm(middle.z - end.z) for end in (one, other)) < LONGEST_PART * length:
            return middle
    return None

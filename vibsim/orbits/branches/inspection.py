"""Events between two neighbouring points of a branch, each found and located.

Index check: the number of multipliers outside the unit circle may change only by what was detected: by one
at a fold, a branch point or a doubling, by two at a Neimark-Sacker point, by anything where a change of the
order of events makes the derivative of the map jump. A stretch that shows more than one event, or does not
satisfy the check, is halved until each part has one event at most. At an event that was located the other
multipliers must be on the side of the circle that they are on at both ends of its stretch: of a
Neimark-Sacker point a hair before a fold the ends alone say nothing. Multipliers of conservative orbits come
as mu and 1 / mu (`vibsim.orbits.branches.family`): where a pair passes 1 or -1 one of them leaves the
circle, where two pairs meet on it two do.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations, pairwise
from math import inf, isfinite

import numpy as np

from vibsim.orbits.branches.correction import CLOSES, ContinuationError
from vibsim.orbits.branches.family import Family
from vibsim.orbits.branches.grazing import grazing_end
from vibsim.orbits.branches.interpolant import BranchInterpolant, regula_falsi
from vibsim.orbits.branches.node import Node, between
from vibsim.orbits.branches.order_change import SHORT, change_between
from vibsim.orbits.branches.special_points import (
    BIFURCATIONS,
    BRANCHING,
    CORNER,
    DOUBLING,
    FOLD,
    GRAZING,
    TORUS,
    UNRESOLVED,
    Special,
    kind_of_change,
)
from vibsim.orbits.stability import length_of, moduli, modulus, singular_values
from vibsim.orbits.words import changes, without_landings

LONGEST_PART = 0.9  # of a stretch that is halved
TRIES = 100  # nodes while locating
FINE = 1e-13  # length, over that of the unknowns, of the last step of a location
AT_ONCE = 1e-12  # distance, over the size of the unknowns, of changes of order that are one
PARTS = 250  # of one stretch, behind which what is left of it is not parted
SPREAD, MANY = 1e-6, 5  # scaled distance of special points side by side, and how many are told as one
NEAR = 1e-3  # how far a located multiplier may be from where it crosses the circle [-]

CHANGE = "change of order"
SMOOTH = (FOLD, DOUBLING, TORUS, BRANCHING)

Test = Callable[[Node], float]


def inspect(family: Family, one: Node, other: Node) -> list[Special]:
    """The special points between two nodes, in their order."""
    if other.level:  # the parts of the last step would be of orbits that rounding takes from the family
        changed = one.word != other.word
        return [Special(kind_of_change(one.word, other.word), other, one, other)] if changed else []
    return list(_gathered(_parted(family, one, other, iter(range(PARTS)))))


def _gathered(specials: Iterator[Special]) -> Iterator[Special]:
    """Special points with those as one that rounding spreads about a place, as where a slip comes up so
    slowly that none of its orbits tells whether it has begun.
    """
    run: list[Special] = []
    for each in specials:
        if run and length_of(each.node.z - run[-1].node.z) > SPREAD:
            yield from _as_one(_known_apart(run))
            run = []
        run.append(each)
    yield from _as_one(_known_apart(run))


def _known_apart(run: list[Special]) -> list[Special]:
    """Special points side by side with those changes of order as one that no computed orbit tells apart:
    nearer to each other than orbits there are known, or a landing with and without an impact.
    """
    if len(run) < 2 or any(each.kind in BIFURCATIONS and each.kind != UNRESOLVED for each in run):
        return run
    left: list[Special] = []
    for each in run:
        if not left or not _in_doubt(left[-1], each):
            left.append(each)
            continue
        last = left.pop()
        if last.before.word != each.after.word:
            one = _change_of(last.before, each.after)
            sure = each if _lands(last) else last if _lands(each) else one
            left.append(replace(one, node=sure.node))
    return left


def _in_doubt(one: Special, other: Special) -> bool:
    """Whether rounding alone may part a change of order from the next."""
    doubt = max(_doubt(node) for node in (one.before, one.after, other.before, other.after))
    return _lands(one) or _lands(other) or length_of(other.node.z - one.node.z) <= doubt


def _lands(special: Special) -> bool:
    """Whether nothing changes but the impact of a landing, whose speed may be rounding."""
    one, other = special.before.word, special.after.word
    return one != other and without_landings(one) == without_landings(other)


def _doubt(node: Node) -> float:
    """How far an orbit may be from where it was found, scaled: what Newton's method takes for no residual,
    over the smallest singular value of its equations; the more, the nearer the orbit is to those of a family.
    """
    matrix, size = node.point.jacobian(), max(1.0, length_of(node.z))
    if not isfinite(length_of(matrix)):  # a rigid stop is grazed
        return 0.0
    smallest = float(singular_values(matrix)[-1])
    return CLOSES * size / smallest if smallest > 0 else inf


def _as_one(run: list[Special]) -> list[Special]:
    """Special points side by side, or what there is between the first and the last where they are many and
    some are not resolved, or events come and go and come again: the change of order from one end to the
    other, as where rounding hides when a slip begins, or a chatter that is complete no more loses one impact
    after the other, infinitely many.
    """
    orders = [each.after.word for each in run if each.before.word != each.after.word]
    if len(run) < MANY or (len(set(orders)) == len(orders) and all(each.kind != UNRESOLVED for each in run)):
        return _without_returns(run)
    before, after = run[0].before, run[-1].after
    chatters = [node for node in (before, after) if any(kind == "chatter" for kind, _ in node.word)]
    ordinary = all(each.kind not in SMOOTH for each in run) or len(chatters) == 1
    kind = kind_of_change(before.word, after.word) if ordinary and before.word != after.word else UNRESOLVED
    return [Special(kind, chatters[0] if len(chatters) == 1 else after, before, after)]


def _without_returns(run: list[Special]) -> list[Special]:
    """Changes of order side by side without those that are undone there, as where rounding tells whether a
    flight from a rest has begun; bifurcations among them stay.
    """
    if any(each.kind in BIFURCATIONS for each in run):
        return run
    left: list[Special] = []
    for each in run:
        words = [run[0].before.word, *(one.after.word for one in left)]
        if each.after.word in words:
            del left[words.index(each.after.word) :]
        else:
            left.append(replace(each, before=left[-1].after) if left else each)
    return left


def _parted(family: Family, one: Node, other: Node, parts: Iterator[int]) -> Iterator[Special]:
    """The same, part by part; parts : those that the stretch which this is of may still be taken into."""
    detected = detect(one, other)
    if not detected and one.index == other.index:
        return
    if next(parts, None) is None:
        yield Special(UNRESOLVED, other, one, other)
        return
    middle = None if len(detected) == 1 else _middle(family, one, other)
    if middle is None:
        located = _located(family, detected, one, other)
        if isinstance(located, Special):
            yield from _with_sides(family, located, one, other, parts)
            return
        middle = located or _middle(family, one, other)
    if middle is None:
        yield from _unparted(family, detected, one, other, parts)
        return
    yield from _parted(family, one, middle, parts)
    yield from _parted(family, middle, other, parts)


def _unparted(
    family: Family, detected: list[str], one: Node, other: Node, parts: Iterator[int]
) -> Iterator[Special]:
    """Events between two nodes that are too near to be parted: changes of order one by one."""
    try:
        special = _change(family, one, other, first=True) if CHANGE in detected else None
    except ContinuationError:
        special = None
    if isinstance(special, Special):
        yield from _with_sides(family, special, one, other, parts)
        return
    grazing = _graze_between(family, one, other)
    if grazing is None and one.word != other.word and length_of(other.z - one.z) <= _told_within(one, other):
        grazing = _change_of(one, other)
    yield grazing or Special(UNRESOLVED, other, one, other)


def _told_within(one: Node, other: Node) -> float:
    """Scaled distance of two nodes within which a change of order between them that no node parts is told:
    where a chatter ends to be complete infinitely many are.
    """
    chatters = [any(kind == "chatter" for kind, _ in node.word) for node in (one, other)]
    return SHORT if chatters[0] == chatters[1] else SPREAD


def _graze_between(family: Family, one: Node, other: Node) -> Special | None:
    """The grazing of a rigid stop between two nodes whose words differ by its impact, and the slip that it
    brings about; None where there is none.

    A multiplier is infinite there on one side, so that no bracket of orbits closes in on it.
    """
    gone, come = changes(one.word, other.word)
    kinds = [kind for kind, _ in (gone + come).elements()]
    if kinds.count("impact") != 1 or not {"impact", "stick_begin", "stick_end"} >= set(kinds):
        return None
    for node in (one, other):
        grazing = grazing_end(family, node)
        if grazing is not None and _around_corner(one, grazing.node, other):
            turns = one.fold * other.fold < 0
            return Special(CORNER if turns else GRAZING, grazing.node, one, other)
    return None


def _around_corner(one: Node, corner: Node, other: Node) -> bool:
    """Whether the way between two nodes may go by another: with a turn of up to 120 degrees there."""
    way = length_of(corner.z - one.z) + length_of(other.z - corner.z)
    return way <= 2 * length_of(other.z - one.z)


def _with_sides(
    family: Family, special: Special, one: Node, other: Node, parts: Iterator[int]
) -> Iterator[Special]:
    """A special point with what else lies on both sides of a change of order; a bifurcation is alone."""
    if special.kind in SMOOTH:
        yield special
        return
    yield from _parted(family, one, special.before, parts)
    near = None if special.after.word == other.word else _just_behind(family, special.after, other)
    ends = (special.after, other) if near is None else (special.after, near, other)
    behind = [each for pair in pairwise(ends) for each in _parted(family, *pair, parts)]
    if behind and _at_once(special, behind[0]):
        yield _change_of(special.before, behind.pop(0).after)
    else:
        yield special
    yield from behind


def _at_once(one: Special, other: Special) -> bool:
    """Whether two changes of order are one: Newton's method cannot part them, as of a motion that is its own
    mirror image and changes on both sides.
    """
    size = max(1.0, length_of(other.node.z))
    return other.kind not in BIFURCATIONS and length_of(other.node.z - one.node.z) <= AT_ONCE * size


def _change_of(before: Node, after: Node) -> Special:
    """The change of the order of events between two neighbours."""
    turns = before.ahead * after.ahead < 0 and not (before.level or after.level)
    kind = CORNER if turns else kind_of_change(before.word, after.word)
    return Special(kind, after, before, after)


def _just_behind(family: Family, one: Node, other: Node) -> Node | None:
    """A node so near behind another that only changes that come together lie between; None where there is
    none, or a third order of events follows.
    """
    length = length_of(other.z - one.z)
    try:
        near = between(family, one, other, SHORT / length) if length > SHORT else None
    except ContinuationError:
        return None
    return near if near is not None and near.word == other.word else None


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


def _located(family: Family, detected: list[str], one: Node, other: Node) -> Special | Node | None:
    """The one event of a stretch, or of several that are too near to be parted the change of order.

    None where it was not what it seemed, or more happens; a node with a third order of events where there is
    one between.
    """
    try:
        if CHANGE in detected:
            return _change(family, one, other)
        if len(detected) != 1:
            return None
        _, node = regula_falsi(
            BranchInterpolant(family, one, other), test_of(detected[0], one, other), TRIES, FINE
        )
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
    pair = min((mu for mu in outside.pairs if modulus(mu) > 1), key=lambda mu: abs(modulus(mu) - 1))
    return lambda node: node.torus(pair)


def _index_explained(special: Special) -> bool:
    """Whether the other multipliers are at the event where they are at both ends of its stretch."""
    before, at, after = special.before, special.node, special.after
    if at.point.family.conservative:
        return _pairs_explained(special)
    distance = {
        FOLD: moduli(at.multipliers - 1),
        BRANCHING: moduli(at.multipliers - 1),
        DOUBLING: moduli(at.multipliers + 1),
        TORUS: abs(moduli(at.multipliers) - 1) + (abs(at.multipliers.imag) == 0),
    }[special.kind]
    count = 2 if special.kind == TORUS else 1
    order = np.argsort(distance)
    if distance[order[count - 1]] > NEAR:
        return False
    rest = int(np.count_nonzero(moduli(at.multipliers[order[count:]]) > 1))
    return sorted((before.index, after.index)) == [rest, rest + count]


def _pairs_explained(special: Special) -> bool:
    """The same of a conservative orbit: one pair at 1 or -1, or two that meet on the circle."""
    traces, count = special.node.point.reciprocal.traces, 2 if special.kind == TORUS else 1
    at: tuple[int, ...]
    if special.kind == TORUS:
        pairs = combinations(range(len(traces)), 2)
        at = min(pairs, key=lambda pair: modulus(traces[pair[0]] - traces[pair[1]]))
        near = modulus(traces[at[0]] - traces[at[1]]) < NEAR and abs(traces[at[0]].real) < 2
    else:
        place = -2 if special.kind == DOUBLING else 2
        at = (min(range(len(traces)), key=lambda i: modulus(traces[i] - place)),)
        near = modulus(traces[at[0]] - place) < NEAR
    rest = sum(tau.imag != 0 or abs(tau.real) > 2 for i, tau in enumerate(traces) if i not in at)
    return near and sorted((special.before.index, special.after.index)) == [rest, rest + count]


def _change(family: Family, one: Node, other: Node, first: bool = False) -> Special | Node:
    """A change of the order of events, as of `change_between`."""
    neighbours = change_between(family, one, other, first)
    if isinstance(neighbours, Node):
        return neighbours
    return _change_of(*neighbours)


def _inseparable(one: Node, other: Node) -> bool:
    """Whether two nodes are too near to be parted."""
    return length_of(other.z - one.z) <= SHORT


def _middle(family: Family, one: Node, other: Node) -> Node | None:
    """The node about halfway between two; None where they are too near, or Newton's method fails or leads
    elsewhere, as it may within a family of orbits.
    """
    if _inseparable(one, other):
        return None
    length = length_of(other.z - one.z)
    for share in (0.5, 0.4, 0.6, 0.3, 0.7):
        try:
            middle = between(family, one, other, share)
        except ContinuationError:
            continue
        if max(length_of(middle.z - end.z) for end in (one, other)) < LONGEST_PART * length:
            return middle
    return None

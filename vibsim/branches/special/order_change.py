"""Where the order of events changes on a branch: between which two neighbours, located by what shrinks there.

On one side of such a change at least something goes to zero: the time between two events, as in a contact or
a stick that comes or goes; the speed of an impact; the gap at a turn before a stop. It goes like the way to
there or its root. Where it would be zero is told from the nodes of one side; the two sides are then brought
to it, and the bracket is halved wherever that does not help.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite

from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node
from vibsim.branches.curve.way import Way, at_zero
from vibsim.orbits.returns.gaps import gap_of
from vibsim.orbits.returns.word import LETTERS, Word, counted

NARROW = 4e-14  # length, over that of the unknowns, of the last bracket: Newton's method leaves as much open
SHORT = 1e-9  # scaled length of a stretch that is not halved any more to part its events
TRIES = 100  # nodes while locating
TOGETHER = 1e-12  # of the period, between events of two parts at one instant on all of a branch
BESIDE = 0.1  # of the doubt about a place: so far beside it the next node is, on the longer side
WIDER, CLOSER = 8.0, 0.25  # times as far when that was not enough, and when it was
FAILS, SHRUNK = 2, 0.6  # nodes that did not shrink the bracket to this share, behind which it is halved


@dataclass
class Side:
    """The nodes on one side of a change, by their share, the last the nearest to it."""

    word: Word
    nodes: list[tuple[float, Node]] = field(default_factory=list)

    @property
    def share(self) -> float:
        return self.nodes[-1][0]

    @property
    def node(self) -> Node:
        return self.nodes[-1][1]

    def zeros(self) -> Iterator[tuple[float, float]]:
        """(doubt, share) of where something on this side would be zero."""
        last = [(share, dict(shrinking(node))) for share, node in self.nodes[-3:]]
        for name in last[-1][1] if len(last) > 1 else ():
            points = [(values[name], share) for share, values in last if name in values]
            if len(points) > 1 and len({value for value, _ in points}) == len(points):
                yield _zero(points)


def _zero(points: list[tuple[float, float]]) -> tuple[float, float]:
    """(doubt, share) of where a value with two or three (value, share) would be zero: it goes like the way to
    there or its root, whichever the three bear out.
    """
    square = [(value * value, share) for value, share in points]
    if len(points) == 2:
        line = at_zero(points)
        return abs(line - points[-1][1]), line
    points = min(points, square, key=_bent)
    curve = at_zero(points)
    return abs(curve - at_zero(points[1:])), curve


def _bent(points: list[tuple[float, float]]) -> float:
    """How much the slope of three (value, share) changes, over its size."""
    one, other = ((b - a) / (t - s) for (a, s), (b, t) in pairwise(points))
    return abs(one - other) / (abs(one) + abs(other))


def shrinking(node: Node) -> Iterator[tuple[str, float]]:
    """What may go to zero at a change of order near a node."""
    end = node.point.end
    carried, scene = end.carried, end.coordinates.scene
    happened = list(zip(carried.events, carried.times.tolist(), carried.states, strict=True))
    told = [each for each in happened if each[0][0] in LETTERS]
    told = [each for each, kept in zip(told, counted([event for event, *_ in told]), strict=True) if kept]
    events = [(t, part) for (_, part), t, _ in told]
    circle = [*events, (events[0][0] + end.T, events[0][1])] if len(events) > 1 else []
    gaps = [((t - s) / end.T, one == other) for (s, one), (t, other) in pairwise(circle)]
    apart = [gap for gap, same in gaps if same or gap > TOGETHER]
    if apart:
        yield "time", min(apart)
    if isfinite(end.margin):
        yield "margin", end.margin
    blows = [(part, t, state) for (kind, part), t, state in told if kind == "impact"]
    if blows:
        yield "speed", min(abs(gap_of(scene, *blow)[1]) for blow in blows)


class Search:
    """A change of order between two nodes, closed in from both sides."""

    def __init__(self, family: Family, one: Node, other: Node):
        self.way = Way(family, one, other)
        self.low, self.high = Side(one.word, [(0.0, one)]), Side(other.word, [(1.0, other)])
        self.fails, self.beside = 0, BESIDE  # nodes in succession that did not shrink the bracket

    @property
    def width(self) -> float:
        """Of the bracket, in shares."""
        return self.high.share - self.low.share

    @property
    def length(self) -> float:
        """Of the bracket, scaled."""
        return self.width * self.way.length

    @property
    def narrow(self) -> float:
        """Width at which it ends."""
        return NARROW * self.way.size / self.way.length

    def place(self) -> tuple[float, Word]:
        """The share of the next node, and the order of events that it should have."""
        low, high = self.low, self.high
        zeros = [one for side in (low, high) for one in side.zeros() if low.share < one[1] < high.share]
        if zeros and self.fails < FAILS:
            doubt, zero = min(zeros)
            beside = max(self.beside * doubt, self.narrow / 4)
            below = zero - low.share > high.share - zero
            share = zero - beside if below else zero + beside
            if low.share < share < high.share:
                return share, (low if below else high).word
        return (low.share + high.share) / 2, low.word

    def take(self, share: float, node: Node) -> None:
        """A node between: any order but that of the low side is of the high one."""
        width = self.width
        if node.word not in (self.low.word, self.high.word):
            self.high = Side(node.word)
        side = self.low if node.word == self.low.word else self.high
        side.nodes.append((share, node))
        shrunk = self.width <= SHRUNK * width
        if self.fails < FAILS:
            self.beside = max(BESIDE, self.beside * CLOSER) if shrunk else self.beside * WIDER
        self.fails = 0 if shrunk else self.fails + 1


def change_between(family: Family, one: Node, other: Node, first: bool) -> tuple[Node, Node] | Node:
    """The nodes on both sides of a change of the order of events between two nodes; a node between that has a
    third order, where it can be parted from the others, unless the first change is asked for.

    Raises ContinuationError.
    """
    search = Search(family, one, other)
    for _ in range(TRIES):
        if search.width <= search.narrow:
            break
        share, word = search.place()
        if not search.low.share < share < search.high.share:
            break
        node = search.way.node(share, word)
        known = node.word in (search.low.word, search.high.word)
        if not (known or first or search.length <= SHORT):
            return node
        search.take(share, node)
    return search.low.node, search.high.node

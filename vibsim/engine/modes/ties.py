"""Bodies that are tied move as one group; what its ties must carry, cut by cut.

Sticking frictions and rigid stops at rest tie their ends; such a stop only pushes. A group with the ground
(or the base) in it does not move on its own. Where ties are redundant the split of the force among them is
not unique, but whether some split is admissible is: by the max-flow min-cut theorem it is where, for every
way of cutting the group in two connected sets, the force that must pass the cut is within the sum of the
limits of the ties that cross it (Ford & Fulkerson 1956). So each such cut is watched, and where it gives way
all ties across it slip or open.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic

from vibsim.physics.numbers import N

Edge = tuple[int, int]  # columns of P and Q
Tie = tuple[int, int, int]  # number, columns of P and Q
Limits = tuple[N | None, N | None]  # against slip forwards and backwards [N]; None: any force
MOST_CUTS = 2**12 - 1  # of a group: those of 12 bodies of which each is tied to each other one and the ground


class TooManyCuts(Exception):
    """A group with redundant ties has more than MOST_CUTS cuts; its arguments: the columns of the group, but
    for one.
    """


@dataclass(slots=True)
class Cut(Generic[N]):
    """A set of columns on one side of ties.

    ties : numbers of the ties that cross, with +1 where P is in the set, -1 where Q is
    above, below : the largest force on the set that they can pass in either direction [N]; None: any
    """

    columns: tuple[int, ...]
    ties: tuple[tuple[int, int], ...]
    above: N | None
    below: N | None


class Groups:
    """Groups of columns tied by `ties` = [(number, P, Q)].

    columns: number of bodies n; column n is the ground, n + 1 the base. leader[c]: the column that stands for
    the group of c: the ground, the base, or the first body.
    """

    def __init__(self, bodies: int, ties: Iterable[Tie]) -> None:
        self.ground, self.base = bodies, bodies + 1
        parent = list(range(bodies + 2))

        def root(c: int) -> int:
            while parent[c] != c:
                c = parent[c]
            return c

        for _, P, Q in ties:
            one, other = root(P), root(Q)
            if one != other:  # the ground leads, then the base, then the first body
                first, second = (one, other) if one < other else (other, one)
                first, second = (second, first) if second >= bodies > first else (first, second)
                parent[second] = first
        self.leader = [root(c) for c in range(bodies + 2)]
        self.members: dict[int, list[int]] = {c: [] for c in set(self.leader)}
        for c, leader in enumerate(self.leader):
            self.members[leader].append(c)

    def moves(self, column: int) -> bool:
        """Whether the column is free to move: not tied to the ground or the base."""
        return self.leader[column] < self.ground


def cuts(
    members: Sequence[int], ties: Sequence[Tie], limits: Mapping[int, Limits[N]], reference: int
) -> list[Cut[N]]:
    """The cuts of one group.

    members: its columns; ties: its [(number, P, Q)]; limits: {number: (forward, backward)} [N], None: none;
    reference: the column that stays on the other side. Raises TooManyCuts for redundant ties with more than
    MOST_CUTS of them.
    """
    others = [c for c in members if c != reference]
    edges = [(P, Q) for _, P, Q in ties]
    if len(ties) == len(others):
        sides = [beyond(edges, k, reference) for k in range(len(edges))]
    else:
        sides = connected_sides(others, edges, reference)
    return [_cut(side, ties, limits) for side in sides]


def connected_sides(others: Sequence[int], edges: Sequence[Edge], reference: int) -> list[tuple[int, ...]]:
    """The sets of columns `others` that hang together by `edges` and leave a rest that does, with the
    reference in it; in the order of `itertools.combinations`, smaller ones first. Raises TooManyCuts.

    Each step makes one of them larger by a neighbour and by what that parts from the reference, which gives
    another one, and leaves it to later steps to have that neighbour on the other side.
    """
    bits = {c: 1 << i for i, c in enumerate(others)} | {reference: 1 << len(others)}
    beside = dict.fromkeys(bits.values(), 0)
    for P, Q in edges:
        beside[bits[P]] |= bits[Q]
        beside[bits[Q]] |= bits[P]
    everything = (1 << len(bits)) - 1

    def grown(start: int, within: int) -> int:
        """Set of all that hangs together with `start` within a set."""
        reached = ahead = start
        while ahead:
            bit = ahead & -ahead
            new = beside[bit] & within & ~reached
            reached, ahead = reached | new, (ahead ^ bit) | new
        return reached

    found: list[int] = []
    waiting = [(0, bits[reference])]  # a side, and what it is not to have
    while waiting:
        side, without = waiting.pop()
        neighbours = everything
        if side:
            side = everything ^ grown(bits[reference], everything ^ side)
            if side & without:
                continue
            found.append(side)
            if len(found) > MOST_CUTS:
                raise TooManyCuts(*others)
            neighbours = 0
            for c in others:
                if side & bits[c]:
                    neighbours |= beside[bits[c]]
        for c in others:
            if neighbours & bits[c] & ~side & ~without:
                waiting.append((side | bits[c], without))
                without |= bits[c]
    places = [tuple(i for i in range(len(others)) if side >> i & 1) for side in found]
    return [
        tuple(others[i] for i in place) for place in sorted(places, key=lambda place: (len(place), place))
    ]


def beyond(edges: Sequence[Edge], k: int, reference: int) -> tuple[int, ...]:
    """Columns that edge k of a tree of ties parts from the reference."""
    reached, ahead = set(), [reference]
    while ahead:
        c = ahead.pop()
        reached.add(c)
        ahead += [
            b if a == c else a
            for i, (a, b) in enumerate(edges)
            if i != k and c in (a, b) and not {a, b} <= reached
        ]
    return tuple(sorted({c for edge in edges for c in edge} - reached))


def _cut(side: tuple[int, ...], ties: Sequence[Tie], limits: Mapping[int, Limits[N]]) -> Cut[N]:
    crossing = [(i, 1 if P in side else -1) for i, P, Q in ties if (P in side) != (Q in side)]
    ups, downs = [], []
    for i, orientation in crossing:
        forward, backward = limits[i]
        ups.append(backward if orientation > 0 else forward)
        downs.append(forward if orientation > 0 else backward)
    return Cut(tuple(side), tuple(crossing), _together(ups), _together(downs))


def _together(limits: Sequence[N | None]) -> N | None:
    """Sum of limits in their order; None where one of them is none."""
    total = limits[0]
    for limit in limits[1:]:
        total = None if total is None or limit is None else total + limit
    return total

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
from itertools import combinations
from typing import Generic

from vibsim.physics.arithmetic.numbers import N

Edge = tuple[int, int]  # columns of P and Q
Tie = tuple[int, int, int]  # number, columns of P and Q
Limits = tuple[N | None, N | None]  # against slip forwards and backwards [N]; None: any force
LARGEST = 12  # bodies of a group with redundant ties, whose cuts are enumerated


@dataclass(frozen=True)
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
            if one != other:
                first, second = sorted((one, other), key=self._rank)
                parent[second] = first
        self.leader = [root(c) for c in range(bodies + 2)]
        self.members = {c: [d for d in range(bodies + 2) if self.leader[d] == c] for c in set(self.leader)}

    def _rank(self, column: int) -> tuple[int, int]:
        return (0, column) if column >= self.ground else (1, column)

    def moves(self, column: int) -> bool:
        """Whether the column is free to move: not tied to the ground or the base."""
        return self.leader[column] < self.ground


def connected(columns: Iterable[int], edges: Sequence[Edge]) -> bool:
    """Whether `columns` hang together by `edges` = [(P, Q)]."""
    joined = set(columns)
    reached: set[int] = set()
    ahead = [next(iter(joined))]
    while ahead:
        c = ahead.pop()
        reached.add(c)
        ahead += [
            b if a == c else a for a, b in edges if c in (a, b) and {a, b} <= joined and not {a, b} <= reached
        ]
    return reached == joined


def cuts(
    members: Sequence[int], ties: Sequence[Tie], limits: Mapping[int, Limits[N]], reference: int
) -> list[Cut[N]]:
    """The cuts of one group.

    members: its columns; ties: its [(number, P, Q)]; limits: {number: (forward, backward)} [N], None: none;
    reference: the column that stays on the other side. Raises ValueError for a group with redundant ties of
    more than LARGEST bodies.
    """
    others = [c for c in members if c != reference]
    if len(others) > LARGEST and len(ties) > len(others):
        raise ValueError(f"more than {LARGEST} bodies tied to each other in loops")
    edges = [(P, Q) for _, P, Q in ties]
    if len(ties) == len(others):
        sides = [beyond(edges, k, reference) for k in range(len(edges))]
    else:
        sides = [
            side
            for size in range(1, len(others) + 1)
            for side in combinations(others, size)
            if connected(side, edges) and connected(set(members) - set(side), edges)
        ]
    return [_cut(side, ties, limits) for side in sides]


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

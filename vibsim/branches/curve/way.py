"""The way from one node of a branch to another: its nodes by their share, each begun near where it will be.

Nodes that are known on the way, and the tangents at its ends where they are, tell where another one lies: by
the polynomial through the nearest of them (Newton's divided differences). So Newton's method has less and
less to do as a place on the way is narrowed down. Where the order of events changes the unknowns have a kink:
there only nodes with one order are taken.
"""

from typing import Any

import numpy as np

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node, chord_of, node_at, start_between
from vibsim.orbits.matrices import length_of
from vibsim.orbits.returns.word import Word

THROUGH = 3  # nodes that the polynomial goes through, the tangents at ends beside them
Row = tuple[float, np.ndarray, np.ndarray | None]  # share, unknowns there, and their slope
APART = 0.25  # of the distance from the place asked for: nodes nearer to each other tell but rounding


class Way:
    """From node `one`, share 0, to `other`, share 1; `length` of the chord between them, scaled,
    and `size` of the unknowns, no less than 1.
    """

    def __init__(self, family: Family, one: Node, other: Node):
        self.family, self.one, self.other = family, one, other
        self.chord = chord_of(one, other)
        self.length, self.size = self.chord.length, max(1.0, length_of(other.z))
        self.known: list[tuple[float, Node]] = [(0.0, one), (1.0, other)]

    def node(self, share: float, word: Word | None = None) -> Node:
        """The node at a share; word: the order of events that it will have, where only nodes with this one
        tell where it is. Raises ContinuationError.
        """
        known = [node for _, node in sorted(self.known, key=lambda pair: abs(pair[0] - share))]
        across = self.chord.across
        start = self.chord.placed(self._told(share, word), share)
        limit = self.chord.limit
        try:
            node = node_at(self.family, start, across, known[0], limit)
        except ContinuationError:
            start = start_between(self.one, self.other, share, self.chord)
            node = node_at(self.family, start, across, known[0], limit)
        node.go_like(known)
        self.known.append((share, node))
        return node

    def _told(self, share: float, word: Word | None) -> np.ndarray:
        """About where the node is, by the polynomial through the known nodes that are nearest."""
        near = sorted(self.known, key=lambda pair: abs(pair[0] - share))
        alike = [pair for pair in near if pair[1].word == word]
        rows: list[Row] = []
        for place, node in alike if len(alike) > 1 else near:
            room = APART * abs(place - share)
            if all(abs(place - each) > room for each, *_ in rows):
                rows.append((place, node.z, self._pace(place, node)))
            if len(rows) == THROUGH:
                break
        return _newton(rows, share)

    def _pace(self, place: float, node: Node) -> np.ndarray | None:
        """dz / d share at an end of the way, where its tangent is known; None elsewhere."""
        if place not in (0.0, 1.0) or not node.has_tangent:
            return None
        return self.chord.pace(node.tangent)


def _newton(rows: list[Row], share: float) -> np.ndarray:
    """The polynomial through places, and with their slopes where they are given, by divided differences."""
    at, table = [], []
    for place, value, slope in rows:
        for column in (value, *(() if slope is None else (value,))):
            at.append(place)
            table.append(column)
    slopes = {place: slope for place, _, slope in rows}
    value, product = table[0], 1.0
    for order in range(1, len(at)):
        table = [
            slopes[at[i]] if at[i + order] == at[i] else (table[i + 1] - table[i]) / (at[i + order] - at[i])
            for i in range(len(table) - 1)
        ]
        product *= share - at[order - 1]
        value = value + product * table[0]
    return np.asarray(value)


def regula_falsi(way: Way, test: Any, tries: int, fine: float) -> tuple[Node, Node]:
    """Neighbours on both sides of a zero of `test` on a way, the second the better.

    After Anderson and Bjorck (BIT 13, 1973), until a step is shorter than `fine` of the unknowns. Raises
    ContinuationError where the test has the same sign at both ends.
    """
    low, high = way.one, way.other
    left, right = 0.0, 1.0
    f_left, f_right = test(low), test(high)
    if not f_left * f_right < 0:
        raise ContinuationError("the test does not change its sign")
    for _ in range(tries):
        share = right - f_right * (right - left) / (f_right - f_left)
        if not min(left, right) < share < max(left, right):
            break
        node = way.node(share)
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
        if moved * way.length < fine * way.size:
            break
    return low, high


def at_zero(points: list[tuple[float, float]]) -> float:
    """The value at 0 of the polynomial through (x, value), by Neville's scheme."""
    values = [value for _, value in points]
    for order in range(1, len(points)):
        for i in range(len(points) - order):
            here, there = points[i][0], points[i + order][0]
            values[i] = (there * values[i] - here * values[i + 1]) / (there - here)
    return values[0]

"""The way from one node of a branch to another: its nodes by their share, each begun near where it will be.

Nodes that are known on the way, and the tangents at its ends where they are, tell where another one lies: by
the polynomial through the nearest of them (Newton's divided differences). So Newton's method has less and
less to do as a place on the way is narrowed down. Where the order of events changes the unknowns have a kink:
there only nodes with one order are taken.
"""

from itertools import pairwise
from typing import Any

import numpy as np

from vibsim.cases.problems import counted
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.orbits import ReturnMap
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.family import Family
from vibsim.orbits.branches.grazing import later
from vibsim.orbits.branches.node import Node, between, chord_of, node_at, start_between
from vibsim.orbits.return_map import Return
from vibsim.orbits.stability import dot, length_of
from vibsim.orbits.words import Word
from vibsim.physics.parts import Scene

THROUGH = 3  # nodes that the polynomial goes through, the tangents at ends beside them
Row = tuple[float, np.ndarray, np.ndarray | None]  # share, unknowns there, and their slope
APART = 0.25  # of the distance from the place asked for: nodes nearer to each other tell but rounding


class BranchInterpolant:
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


def regula_falsi(way: BranchInterpolant, test: Any, tries: int, fine: float) -> tuple[Node, Node]:
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


# Across an impact that comes to the section: there the branch is followed on a section at another phase.
#
# The state on the section jumps where an impact passes it, and the return map with it; where a contact with a
# stop begins or ends there, the state has a kink that Newton's method may not get across. The orbits
# themselves go on. Seen from a phase at which nothing happens they are followed until the impact is on the
# other side.


IMPACTS = ("impact", "transmitted")
CONTACTS = (*IMPACTS, "contact_begin", "contact_end")
WITHIN = 0.02  # share of the period from the section, within which an impact may have ended a walk
NEAR = 1e-3  # the same, where it has passed the section and hinders Newton's method no more
POLISH = 6  # Newton steps of the time that a motor takes to the section
CORRECTION = 0.1  # scaled, that a point taken from one section to the other may need


class MovedMap(ReturnMap):
    """From a section behind that of a scene, by a share of the period or an angle of the motor, to itself."""

    def __init__(self, scene: Scene, n: int, share: float, angle: float):
        super().__init__(scene, n)
        if self.section.timed:
            self.carrier = Carrier(later(scene, share * self.section.time(n)))
        self.angle = angle

    def start(self, X: np.ndarray) -> np.ndarray:
        """Components of the state at unknowns."""
        start = np.array(self.coordinates.lifted(X))
        if self.section.pinned is not None:
            start[self.section.pinned] = self.angle
        return start

    def _motion(self, X: Any, T: Any, disturbances: np.ndarray) -> Return:
        T = self.section.time(self.n) if self.section.timed else float(T)
        carried = self.carrier.carry(self.start(X), T, disturbances)
        ahead = 0.0 if self.section.timed else self._ahead(carried) - self.angle
        return Return(self.coordinates, np.asarray(X, dtype="f8"), T, ahead, carried)


class MovedFamily(Family):
    """The orbits of another family on a section behind its own, by a share of the period of a node, or by the
    angle that its motor has turned by then.
    """

    def __init__(self, of: Family, node: Node, share: float):
        super().__init__(of.case, of.keys, of.unit, of.n)
        self.of, self.scale, self.share, self.path = of, of.scale, share, of.path
        of_map = of.map(node.parameter)
        start = of_map.coordinates.lifted(node.point.end.X)
        self._state = of_map.carrier.carry(start, share * node.point.period, []).state
        pinned = of_map.section.pinned
        self.angle = 0.0 if pinned is None else float(self._state[pinned])
        self._from = node

    def _new_map(self, scene: Scene) -> ReturnMap:
        return MovedMap(scene, self.n, self.share, self.angle)

    @property
    def start(self) -> Node:
        """The orbit of the node that it was made from, on this section. Raises ContinuationError."""
        return _arrived(self, self.of.map(self._from.parameter).coordinates.of(self._state), self._from)

    def rest(self, node: Node) -> tuple[float, np.ndarray]:
        """Time from this section to the other [s], and the state there."""
        moved, T = self.map(node.parameter), (1 - self.share) * node.point.period
        assert isinstance(moved, MovedMap)
        section, start = moved.section, moved.start(node.point.end.X)
        carried = moved.carrier.carry(start, T, [])
        for _ in range(0 if section.pinned is None else POLISH):
            missing = self.n * section.advance - carried.state[section.pinned]
            T += float(missing / carried.rate[section.pinned])
            carried = moved.carrier.carry(start, T, [])
        return T, carried.state

    def given_back(self, node: Node) -> Node:
        """The orbit of a node of this family, on the other section. Raises ContinuationError."""
        _, state = self.rest(node)
        return _arrived(self.of, self.map(node.parameter).coordinates.of(state), node)


def _arrived(family: Family, X: np.ndarray, node: Node) -> Node:
    """The orbit near unknowns on the section of a family, at the parameter and the way of a node."""
    z = family.unknowns(X, node.point.period, node.parameter)
    there = node_at(family, z, None, None, CORRECTION)
    along = np.zeros(len(z))
    along[-1] = 1.0 if node.ahead > 0 else -1.0
    return Node(there.point, along, there.iterations)


def times_of(node: Node, kinds: tuple[str, ...]) -> list[float]:
    """Instants of events of some kinds, in shares of the period from the section."""
    carried, T = node.point.end.carried, node.point.period
    return [float(t / T) for t, (kind, _) in zip(carried.times, carried.events, strict=True) if kind in kinds]


def from_section(node: Node, kinds: tuple[str, ...] = IMPACTS) -> float:
    """How near to the section a rigid stop is struck, or events of other kinds happen, as a share of the
    period; 1 where none do.
    """
    if not any(kind in kinds for kind, _ in node.point.end.carried.events):
        return 1.0
    return min(min(t, 1 - t) for t in times_of(node, kinds))


def quiet_share(node: Node) -> float:
    """The middle of the longest stretch without events within a period, as a share of it."""
    times = [0.0, *(node.point.end.carried.times / node.point.period).tolist(), 1.0]
    gaps = [(b - a, (a + b) / 2) for a, b in pairwise(times)]
    return float(max(gaps)[1])


def beyond_the_impact(walk: Any) -> Node | None:
    """The first node behind the impact or contact at which a walk came to an end; None where another thing
    ended it.
    """
    node = walk.node
    if from_section(node, CONTACTS) > WITHIN:
        return None
    try:
        moved = MovedFamily(walk.family, node, quiet_share(node))
        inner = walk.on(moved, moved.start)
        for step in inner.steps():
            if step.ended or step.specials:
                return None
            if _passed_section(moved, node, step.node):
                return moved.given_back(step.node)
    except ContinuationError:
        return None
    return None


def _passed_section(moved: MovedFamily, before: Node, node: Node) -> bool:
    """Whether what was near one side of the section is on the other, and far enough from it."""
    behind = min(times_of(before, CONTACTS), key=lambda t: min(t, 1 - t)) < 0.5
    section = moved.rest(node)[0] / node.point.period
    nearest = min((t - section for t in times_of(node, CONTACTS)), key=abs, default=0.0)
    return abs(nearest) > NEAR and (nearest < 0) == behind


# Where a branch of n periods joins one of fewer: beyond it, its orbits are those in front of it, shifted.
#
# The change over n / d periods, P^(n/d)(X) - X, is zero at an orbit of n / d periods only. Along a branch
# that leaves a doubling it turns round there: the orbits on the other side are the same, half their period
# later.


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
    return f"{JOINS} the orbits of {counted(periods, 'period')}"


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

"""Changes of the order of events on a branch: the two neighbours between them, located by what shrinks there.

On one side of such a change at least something goes to zero: the time between two events, as in a contact or
a stick that comes or goes; the speed of an impact; the gap at a turn before a stop. It goes like the way to
there or its root. Where it would be zero is told from the nodes of one side; the two sides are then brought
to it, and the bracket is halved wherever that does not help.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite

import numpy as np

from vibsim.cases.quantities import number
from vibsim.orbits.branches.correction import ContinuationError, NoCase
from vibsim.orbits.branches.family import Family, FamilyPoint
from vibsim.orbits.branches.interpolant import BranchInterpolant, at_zero, regula_falsi
from vibsim.orbits.branches.node import Node
from vibsim.orbits.branches.special_points import BRANCHING, CORNER, FOLD, HOPF, UNRESOLVED, Special
from vibsim.orbits.stability import dot, least_squares, length_of, moduli
from vibsim.orbits.words import LETTERS, Word, counted
from vibsim.physics.connections import BodySet, body_sets
from vibsim.physics.formula_values import gap_of
from vibsim.physics.parts import Scene

NARROW = 4e-14  # length, over that of the unknowns, of the last bracket: Newton's method leaves as much open
SHORT = 1e-9  # scaled length of a stretch that is not halved any more to part its events
ORDER_CHANGE_TRIES = 100  # nodes while locating
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
    """Relative change of the slope of three (value, share)."""
    one, other = ((b - a) / (t - s) for (a, s), (b, t) in pairwise(points))
    return abs(one - other) / (abs(one) + abs(other))


def shrinking(node: Node) -> Iterator[tuple[str, float]]:
    """Quantities that may go to zero at a change of order near a node."""
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
    impacts = [(part, t, state) for (kind, part), t, state in told if kind == "impact"]
    if impacts:
        yield "speed", min(abs(gap_of(scene, *impact)[1]) for impact in impacts)


class OrderSearch:
    """A change of order between two nodes, closed in from both sides."""

    def __init__(self, family: Family, one: Node, other: Node):
        self.way = BranchInterpolant(family, one, other)
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
    search = OrderSearch(family, one, other)
    for _ in range(ORDER_CHANGE_TRIES):
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


# Where a branch of free vibrations shrinks to a state of rest: the Hopf point.
#
# The section of a scene that nothing drives is where a body turns round. Its acceleration there, the swing,
# goes through zero with the amplitude; beyond lie the same orbits, seen at their other turn. Parameter and
# period are smooth over it, though singular for Newton's method at zero itself (Kuznetsov, Elements of
# Applied Bifurcation Theory, section 3.4): they are taken there by the polynomial through orbits on both
# sides.


SHARES = (-0.4, 0.4, -0.25, 0.25, -0.15, 0.15)  # distances of these orbits, of the room for them
# The least room, scaled: that to the nearer end if it is more. Rounding of 1e-16 over the swing there, some
# 1e-4, is 1e-12 of the parameter; the polynomial leaves out the sixth power of the room.
ROOM = 4e-3
HOPF_FINE, HOPF_TRIES = 1e-6, 40  # share of it at which the place is known well enough to begin with
SHRINKS = 0.5  # share of the rates of change that is left near rest: more, and the body alone stands still


def swing(node: Node) -> float:
    """Acceleration of the body at its turn, over the section that it makes [m/s^2]; 0 for a state of rest."""
    tilt = node.point.end.tilt
    assert tilt is not None
    return float(tilt[1])


def hopf_point(family: Family, one: Node, other: Node) -> Special | None:
    """The Hopf point between two nodes; None where there is none."""
    section = one.point.end.coordinates.section
    if not section.turning or one.word or other.word or swing(one) * swing(other) >= 0:
        return None
    try:
        least, nodes = _near_rest(BranchInterpolant(family, one, other))
    except ContinuationError:
        return None
    if not _pace(least) < SHRINKS * _pace(one):
        return None
    z = least.z.copy()
    for i in (-2, -1):  # period and parameter
        z[i] = at_zero([(swing(node), float(node.z[i])) for node in nodes])
    return Special(HOPF, Node.of(family(z), one.tangent, least.iterations), one, one)


def _pace(node: Node) -> float:
    """Size of the velocities and accelerations at the turn [m/s^2]."""
    end = node.point.end
    count, rates = len(end.coordinates.scene.bodies), end.carried.rate
    return length_of(np.array([*(rates[:count] * 2 * np.pi / end.T), *rates[count : 2 * count]]))


def _near_rest(way: BranchInterpolant) -> tuple[Node, list[Node]]:
    """The orbit of the least swing, and others of little, one way and the other. Raises ContinuationError."""
    _, near = regula_falsi(way, swing, HOPF_TRIES, HOPF_FINE)
    place = next(share for share, node in way.known if node is near)
    way.known = [(share, node) for share, node in way.known if swing(node)]  # rest itself has no derivative
    room = max(min(place, 1 - place), ROOM / way.length)
    least = min((node for _, node in way.known), key=lambda node: abs(swing(node)))
    return least, [way.node(place + share * room) for share in SHARES]


# Where a branch turns round because it comes to orbits of more symmetry: a pitchfork seen from its prongs.
#
# Beyond it the branch is its own mirror image. A multiplier touches 1 there while the parameter turns round,
# and no test value changes its sign but dp/ds; by rounding the multiplier may pass 1 and come back, which
# looks like a fold and a branch point side by side.


TOUCHES = 1e-4  # distance from 1 of the multiplier where the parameter turns: the square of the way
PITCHFORK_TRIES, PITCHFORK_FINE = 40, 1e-4  # evaluations while locating, and length of the last step
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
    way = BranchInterpolant(family, one, other)
    try:
        _, turn = regula_falsi(way, lambda node: node.ahead, PITCHFORK_TRIES, PITCHFORK_FINE)
        if moduli(turn.multipliers - 1).min(initial=1.0) > TOUCHES:
            return None
        at = _settled(family, turn.z, _parameter(way, turn))
    except (ContinuationError, ZeroDivisionError):
        return None
    along = one.tangent + other.tangent  # at the place itself two curves cross, and the tangent is neither's
    return Special(BRANCHING, Node.of(at, np.asarray(along / length_of(along)), turn.iterations), one, other)


def _parameter(way: BranchInterpolant, turn: Node) -> float:
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


# Where orbits end because a static force carries bodies off.
#
# Over a period of a motion that returns, the mean force on bodies that nothing but dry friction holds is
# zero: their static force is no larger than what the frictions between them and the rest can take. Where it
# comes to be larger there is no orbit: they speed up without end.


NEAR = 1e-6  # scaled distance of the last orbit from where the force is as large as what friction takes


def carried_off(family: Family, node: Node, sense: float) -> str | None:
    """Words on the bodies that a static force carries off just beyond a node, in the sense in which the
    parameter goes on; None where it carries none.
    """
    unit = float(family.scale[-1])
    within, beyond = node.parameter, node.parameter + sense * NEAR * unit
    try:
        if _overcome(family.map(within).scene) is not None:
            return None
        bodies = _overcome(family.map(beyond).scene)
        if bodies is None:
            return None
        while within != (middle := (within + beyond) / 2) != beyond:
            there = _overcome(family.map(middle).scene)
            within, beyond = (middle, beyond) if there is None else (within, middle)
    except NoCase:
        return None
    names = [family.map(node.parameter).scene.bodies[body].name for body in bodies.bodies]
    value = f"{number(within, 12)} {family.unit}".rstrip()
    return (
        f"friction takes the static force on {' and '.join(names)} up to {value}: beyond, it speeds them up "
        "without end"
    )


def _overcome(scene: Scene) -> BodySet | None:
    """Bodies on which the static force is more than friction can take; None where there are none, and of
    bodies on which formulas act none is known.
    """
    for bodies in body_sets(scene, [*scene.links, *scene.stops]):
        motor = scene.motor is not None and scene.motor.on in bodies.bodies
        unknown = any(each.formula is not None for each in scene.forces if each.on in bodies.bodies)
        unknown = unknown or any(friction.holds is not None for friction in scene.frictions)
        if not (bodies.held or motor or unknown) and _excess(scene, bodies) > 0:
            return bodies
    return None


def _excess(scene: Scene, bodies: BodySet) -> float:
    """The static force on bodies less the most that friction can take of it [N]."""
    force = sum(each.constant for each in scene.forces if each.on in bodies.bodies)
    taken = 0.0
    for friction in scene.frictions:
        inside = [end in bodies.bodies for end in (friction.P, friction.Q)]
        if inside[0] != inside[1]:
            against_forward, against_backward = friction.limits
            taken += against_forward if (force > 0) == inside[0] else against_backward
    return abs(force) - taken

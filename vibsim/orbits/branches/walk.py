"""A walk along a branch in one direction: from point to point, with the special points between them."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from math import frexp
from typing import Any

import numpy as np

from vibsim.orbits.branches.correction import SHARP, ContinuationError, NoCase, Pace, turn
from vibsim.orbits.branches.family import Family
from vibsim.orbits.branches.grazing import grazing_end
from vibsim.orbits.branches.inspection import NEAR, detect, inspect
from vibsim.orbits.branches.interpolant import JOINS, beyond_the_impact, from_section, joining, repetition
from vibsim.orbits.branches.node import (
    LEAST_LIMIT,
    Node,
    ahead_of,
    between,
    goes_on,
    node_at,
    predicted,
    trend,
)
from vibsim.orbits.branches.order_change import carried_off, hopf_point, with_pitchfork
from vibsim.orbits.branches.special_points import (
    BRANCHING,
    CORNER,
    FOLD,
    GRAZING,
    UNRESOLVED,
    Special,
    beyond_the_change,
    corner_near,
)
from vibsim.orbits.newton import EPS
from vibsim.orbits.stability import dot, length_of, moduli

END = "end of the range"
BEHIND = 4  # steps before a branch can have come back to its start
INFINITE = 200.0  # multiplier of orbits that all but graze a rigid stop, where it goes like 1 / impact speed
GRAZED = "a multiplier grows without bound: a rigid stop is grazed near by"
TOUCHED = "a rigid stop is grazed: beyond, orbits strike it, and a multiplier is infinite at first"
AT_SECTION = 1e-6  # share of the period
ROUNDING = "Newton's method goes to and fro across a grazing"
AT_REST = "shrinks to a state of rest"
FAMILY = "orbits come in a family at this value, in which more than one number is free"
BLOCKED = "an impact on a rigid stop comes to the section: shift the phase of the source to go on"
STUCK = "stuck"
LOOSE = 1e-10  # residual, scaled, of what is no orbit where the branch turns back
POLISH = 3  # Newton steps of a time of return that is known to 1e-9
KINKS = (1e-7, 1e-6, 1e-5, 1e-4)  # scaled lengths of steps across a kink
IN_A_ROW = 8  # such steps: where nothing else leads on the branch is stuck
ONE_ORBIT = 1e-4  # scaled distance of the orbits on both sides of a grazing: beside it a root of the bracket
AHEAD = 0.97  # cosine of the angle between a step and the tangent before it, below which it goes aside
SHORTER, TRIES = 8, 3  # times shorter a step is that is taken again, and how often
SAME = 1e-8  # scaled distance of a closed branch from its start


class NoBound(ContinuationError):
    """A node at the end of the range that was not found; from nearer it may be."""


@dataclass(frozen=True)
class Step:
    """One step of a walk.

    node : where it led; specials : what lies between, in order
    next : length of the step that follows; ended : why none follows, or empty
    """

    node: Node
    specials: tuple[Special, ...]
    next: float
    ended: str = ""


class Walk:
    """A walk from a node, whose tangent says in which direction, while the parameter is within `span`."""

    def __init__(self, family: Family, start: Node, span: tuple[float, float], pace: Pace):
        self.family, self.span, self.pace = family, span, pace
        self.start = self.node = start
        self.before: Node | None = None
        self.step, self.count, self.bend = pace.first, 0, 0.0
        self.crosses, self.tries = True, 0  # impacts that come to the section; steps taken again in a row
        self.kinks = 0  # steps across one in a row

    def go_on(self, before: Node, node: Node, step: float, count: int) -> None:
        """Go on from a node that a walk came to after `count` steps; before: the one before that."""
        self.before, self.node, self.step, self.count = before, node, step, count
        self.bend, node.trend = bend(before, node), trend(before, node)

    def steps(self) -> Iterator[Step]:
        """The steps, until the branch ends, leaves the span or comes back to its start."""
        while True:
            try:
                node, following = self._next()
                loose = abs(node.point.residual).max() > LOOSE
                corner = self._corner(self.node) if loose else None
                if corner is None and self.crosses and from_section(node) < AT_SECTION:
                    raise ContinuationError(BLOCKED)
                shrunk, ended = hopf_point(self.family, self.node, node), ""
                if corner is None and shrunk is None:
                    node, ended = self._ended(node)
            except ContinuationError as error:
                if isinstance(error, NoBound) and self.step > self.pace.least:
                    self.step /= 2
                    continue
                beyond = beyond_the_impact(self) if self.crosses else None
                if beyond is not None:
                    yield self._across(beyond)
                    continue
                corner = self._corner(self.node)
                if corner is not None:
                    yield self._around(*corner)
                    continue
                stuck = self._stuck(error)
                behind = beyond_the_change(self.family, self.node) if stuck.startswith(STUCK) else None
                if behind is not None:
                    specials = tuple(inspect(self.family, self.node, behind))
                    self.go_on(self.node, behind, self.pace.first * KINKS[-1], self.count + 1)
                    yield Step(behind, specials, self.step)
                    continue
                grazing = grazing_end(self.family, self.node)
                ended = stuck if grazing is None else TOUCHED
                yield Step(self.node, () if grazing is None else (grazing,), self.step, ended)
                return
            if shrunk is not None:
                yield Step(self.node, (shrunk,), self.step, AT_REST)
                return
            if corner is None:
                specials = with_pitchfork(self.family, self.node, node, inspect(self.family, self.node, node))
                if self._left(node, specials):
                    self.step, self.tries = self.step / SHORTER, self.tries + 1
                    continue
                self.tries = 0
                at_corner = next((each.before for each in specials if each.kind == CORNER), None)
                corner = None if at_corner is None else self._corner(at_corner)
            if corner is not None:
                yield self._around(*corner)
                continue
            if ended.startswith(JOINS):  # the doubling there, which is told by the other branch
                specials = tuple(each for each in specials if not is_joint(each))
            self.go_on(self.node, node, following, self.count + 1)
            grazing = grazing_end(self.family, node) if ended == GRAZED else None
            if ended == GRAZED and grazing is None:
                ended = ""
            yield Step(node, specials if grazing is None else (*specials, grazing), following, ended)
            if ended:
                return

    def _left(self, node: Node, specials: tuple[Special, ...]) -> bool:
        """Whether a step to a node may have led to another branch near by. Multipliers tell it, but not where
        a rigid stop is grazed between, beyond all bounds there: unless the step goes aside, or the orbits on
        both sides of a grazing are not one where it was located, as it ends both of them further on.
        """
        torn = [each for each in specials if each.kind == UNRESOLVED]
        chord = node.z - self.node.z
        aside = dot(self.node.tangent, chord) < AHEAD * length_of(chord)
        if self.node.point.end.coordinates.scene.rigid_stops and not aside:
            torn = [each for each in torn if each.before.word == each.after.word]
        torn += [
            each
            for each in specials
            if each.kind == GRAZING and length_of(each.after.z - each.before.z) > ONE_ORBIT
        ]
        return bool(torn) and self.tries < TRIES and self.step > SHORTER * self.pace.least

    def _across(self, node: Node) -> Step:
        """The step over an impact that was on the section."""
        changed = detect(self.node, node)
        specials = (Special(UNRESOLVED, node, self.node, node),) if changed else ()
        self.go_on(self.node, node, self.pace.first, self.count + 1)
        return Step(node, specials, self.step)

    def _corner(self, node: Node) -> tuple[Special, Node] | None:
        """The touch of a sliding velocity near a node at which the branch turns back, and the node behind."""
        before = self.before if node is self.node else self.node
        if before is None or before.z[-1] == node.z[-1]:
            return None
        return corner_near(self.family, node, node.z[-1] - before.z[-1])

    def _around(self, special: Special, node: Node) -> Step:
        """The step around a corner."""
        self.go_on(self.node, node, self.pace.first, self.count + 1)
        return Step(node, (special,), self.step)

    def on(self, family: Family, start: Node) -> "Walk":
        """A walk at the same pace on another section, which goes over no impacts."""
        walk = Walk(family, start, self.span, self.pace)
        walk.crosses = False
        return walk

    def _stuck(self, error: Exception) -> str:
        """Reason why there is no next node."""
        if from_section(self.node) < AT_SECTION:
            return BLOCKED
        if str(error).startswith((JOINS, END)):
            return str(error)
        sense = 1.0 if self.node.ahead > 0 else -1.0
        return carried_off(self.family, self.node, sense) or f"{STUCK}: {error}"

    def _next(self) -> tuple[Node, float]:
        """The next node, and the length of the step behind it. Raises ContinuationError."""
        length = self.step
        while True:
            try:
                node = ahead_of(self.family, self.before, self.node, length, self.bend)
                turned = turn(self.node.tangent, node.tangent)
                chord = node.z - self.node.z
                reason = "the branch turns too sharply"
                straight = dot(self.node.tangent, chord) > 0.9 * length_of(chord)
                if turned <= SHARP and straight and not turned_over(self.node, node):
                    again = ROUNDING if self._beside_a_graze(node) else repetition(self.family, node)
                    if again is None:
                        self.kinks = 0
                        return node, self.pace.following(length, turned, node.iterations, length_of(node.z))
                    reason = again
            except NoCase as error:
                onto_bound = self._onto_bound(length)
                if onto_bound is not None:
                    return onto_bound, length
                reason = str(error)
            except ContinuationError as error:
                reason = str(error)
            length /= 2
            if length < self.pace.least:
                return self._past_kink(reason)

    def _beside_a_graze(self, node: Node) -> bool:
        """Whether Newton's method went to and fro across the grazing of a rigid stop, and left no orbit."""
        scene = node.point.end.coordinates.scene
        return bool(scene.rigid_stops) and abs(node.point.residual).max() > LOOSE

    def _onto_bound(self, length: float) -> Node | None:
        """The node at the end of the range, where the case allows nothing beyond it; None where that is more
        than two steps away, or Newton's method fails. Raises ContinuationError where the walk is there.
        """
        if self._is_at_bound(self.node):
            raise ContinuationError(END)
        bound = self._bound_ahead(self.node) / self.family.scale[-1]
        away = float(bound - self.node.z[-1]) / self.node.ahead
        if not away <= 2 * length:
            return None
        start = predicted(self.before, self.node, away)
        for start[-1] in (bound, np.nextafter(bound, self.node.z[-1])):  # one may be beyond by rounding
            try:
                return node_at(self.family, start, None, self.node, max(4 * away, LEAST_LIMIT))
            except ContinuationError:
                continue
        return None

    def _bound_ahead(self, node: Node) -> float:
        """The end of the range that a walk from a node comes to unless it turns back."""
        return max(self.span) if node.ahead > 0 else min(self.span)

    def _is_at_bound(self, node: Node) -> bool:
        """Whether a walk from a node leaves the range at once."""
        return abs(node.parameter - self._bound_ahead(node)) <= 4 * EPS * float(self.family.scale[-1])

    def _past_kink(self, reason: str) -> tuple[Node, float]:
        """The next node where the branch has a kink, and the length of the step behind it.

        The state on the section has one where an event crosses the section; the branch itself has one where
        a sliding velocity comes to touch zero, and a stick is born. Raises ContinuationError where nothing is
        near, or the branch turns back.
        """
        self.kinks += 1
        if self.kinks > IN_A_ROW:
            raise ContinuationError(reason)
        for length in KINKS:
            try:
                node = node_at(
                    self.family, self.node.z + length * self.node.tangent, None, self.node, 8 * length
                )
            except ContinuationError:
                continue
            node.go_like((self.node,))
            near = length_of(node.z - self.node.z) < 8 * length
            if near and self.node.ahead * node.ahead > 0 and repetition(self.family, node) is None:
                return node, self.pace.first * KINKS[-1]
        raise ContinuationError(reason)

    def _ended(self, node: Node) -> tuple[Node, str]:
        """The node at which the walk ends, and why; the node itself and nothing where it goes on."""
        if node.level:
            return node, FAMILY
        if self.count >= BEHIND:
            there = self._closed(node)
            if there is not None:
                return there, "closed"
        if node.ahead * self.node.ahead < 0:
            shorter = joining(self.family, self.node, node)
            if shorter is not None:
                return shorter
        low, high = sorted(self.span)
        bound = low if node.parameter < low else high if node.parameter > high else None
        if bound is not None:
            return self._at_bound(node, bound), END
        if self._is_at_bound(node):
            return node, END
        return node, GRAZED if self._may_graze(node) else ""

    def _may_graze(self, node: Node) -> bool:
        """Whether to look for a grazing of a rigid stop at the next node: a multiplier has gone beyond
        `INFINITE`, or another power of two there. Orbits within chaos have such too.
        """
        before, now = (float(moduli(each.multipliers).max()) for each in (self.node, node))
        larger = before <= INFINITE or frexp(now)[1] > frexp(before)[1]
        return bool(node.point.end.coordinates.scene.rigid_stops) and now > INFINITE and larger

    def _at_bound(self, node: Node, bound: float) -> Node:
        """The node at the end of the range, between the last one and one beyond. Raises NoBound."""
        here, there = self.node.z[-1], node.z[-1]
        target = bound / self.family.scale[-1]
        start = self.node.z + (node.z - self.node.z) * ((target - here) / (there - here))
        start[-1] = target
        try:
            return node_at(self.family, start, None, node, length_of(node.z - self.node.z))
        except ContinuationError as error:
            raise NoBound(str(error)) from error

    def _closed(self, node: Node) -> Node | None:
        """The node where the branch comes back to its start between the last node and this one, if it does.

        To the start itself, or to the same orbit some periods of the source later.
        """
        chord = node.z - self.node.z
        length = length_of(chord)
        for start in self._starts:
            z = self._in_turn_of(start, node)
            share = dot(z - self.node.z, chord) / length**2
            if not 0 < share <= 1 or length_of(z - self.node.z - share * chord) > length / 4:
                continue
            of_parameter = (z[-1] - self.node.z[-1]) / chord[-1] if chord[-1] else share
            for place in (share, float(of_parameter)):  # what `between` takes for a share
                there = self._there(node, place)
                if there is not None and length_of(there.z - z) <= SAME:
                    return there
        return None

    def _in_turn_of(self, z: np.ndarray, node: Node) -> np.ndarray:
        """Scaled unknowns whose angles are in the turn of those at a node: a rotor may have gained a whole
        turn on the one that the section pins.
        """
        at, scale = node.point.end.coordinates, self.family.scale
        if not len(at.angles):
            return z
        X = at.in_turn_of((z * scale)[: at.count], node.point.end.X)
        return np.array([*(X / scale[: at.count]), *z[at.count :]])

    def _there(self, node: Node, share: float) -> Node | None:
        if not 0 < share <= 1:
            return None
        try:
            return between(self.family, self.node, node, share)
        except ContinuationError:
            return None

    @cached_property
    def _starts(self) -> list[np.ndarray]:
        """The start, and the same orbit after each number of periods less than its own."""
        end, z = self.start.point.end, self.start.z
        once, X, starts = self.family.map(self.start.parameter).of(1), end.X, [z]
        for _ in range(1, self.family.n):
            X = landed(once, X).image
            starts.append(np.array([*(X / self.family.scale[: len(X)]), *z[len(X) :]]))
        return starts


def turned_over(one: Node, other: Node) -> bool:
    """Whether a step has gone over a bend that turns the branch by more than a right angle, so that the
    tangent behind it points back: dp/ds has another sign, and det(P' - I), whose sign changes with it at a
    fold (Keller 1977), has not. Told of where a contact comes or goes, beside which a branch bends so, and
    under a source of known period; at a pitchfork, seen from its prongs, and at rest both are zero.
    """
    timed = one.point.end.coordinates.section.timed
    if one.word == other.word or not timed or one.in_family or other.in_family:
        return False
    return one.ahead * other.ahead < 0 < one.fold * other.fold


def is_joint(special: Special) -> bool:
    """Whether a special point in front of the place where a branch joins one of fewer periods is that place:
    a fold or branch point there, or a multiplier of 1 and a turn of the parameter that do not agree.
    """
    if special.kind == UNRESOLVED:
        at_one = bool(moduli(special.node.multipliers - 1).min(initial=1.0) < NEAR)
        return at_one and special.before.word == special.after.word
    return special.kind in (FOLD, BRANCHING)


def landed(return_map: Any, X: np.ndarray) -> Any:
    """The motion from X to its next return to the section, to rounding."""
    T = None if return_map.section.timed else return_map.time_of_return(X)
    end = return_map(X, T)
    for _ in range(0 if T is None else POLISH):
        T -= end.ahead / end.tilt[1]
        end = return_map(X, T)
    return end


def bend(before: Node, node: Node) -> float:
    """Change of dp/ds with s from one node to the next; 0 across an impact on the section."""
    length = length_of(node.z - before.z)
    return (node.ahead - before.ahead) / length if length and goes_on(before, node) else 0.0

"""A branch traced both ways from its start, each point kept as it comes; and its course between the points.

Points lie as far apart as Newton's method goes. Between two of them the scaled unknowns are taken on the
cubic that has their places and tangents; what it leaves out goes like the fourth power of the step. At a
change of the order of events, where the branch may have a corner, no tangent counts: there the cubic has the
place of the point behind instead. It is a line where the state on the section jumps.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Protocol

import numpy as np

from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.branches.family import Family
from vibsim.orbits.branches.node import Node
from vibsim.orbits.branches.plan import BranchPlan
from vibsim.orbits.branches.special_points import DOUBLING, FOLD, NAMES, TORUS, Special
from vibsim.orbits.branches.walk import Step, Walk
from vibsim.orbits.coordinates import placed
from vibsim.orbits.stability import dot, length_of, sides_of_circle
from vibsim.orbits.words import Word
from vibsim.physics.parts import GROUND

# What is kept of a branch: its points and special points, as plain numbers.


@dataclass(frozen=True)
class OrbitRecord:
    """An orbit of a branch.

    parameter : in the unit of the branch; period : time of return [s]; state : unknowns on the section
    multipliers : complex, the largest first; word : the events as a circle
    fold, doubling : det(P' - I) and det(P' + I); margin : smallest gap at a turn without contact [m], or inf
    drift : of bodies that are held nowhere, per period [m]; residual : of the equations, scaled
    """

    parameter: float
    period: float
    state: tuple[float, ...]
    multipliers: tuple[complex, ...]
    word: Word
    fold: float
    doubling: float
    margin: float
    drift: tuple[float, ...]
    residual: float
    uncertified: int

    @property
    def index(self) -> int:
        """Number of multipliers outside the unit circle, by more than rounding."""
        return sides_of_circle(np.array(self.multipliers))[2]

    @property
    def stable(self) -> bool:
        """Whether all multipliers are inside the unit circle, by more than rounding."""
        return sides_of_circle(np.array(self.multipliers))[0] == len(self.multipliers)


@dataclass(frozen=True)
class PointRecord:
    """A point of a branch, and what it takes to go on from it.

    way : 1 forwards, -1 backwards from the start; number : of steps from there
    unknowns, tangent : scaled; step : length of the next step; ended : why none follows, or empty
    """

    way: int
    number: int
    orbit: OrbitRecord
    unknowns: tuple[float, ...]
    tangent: tuple[float, ...]
    step: float
    iterations: int
    ended: str = ""


@dataclass(frozen=True)
class SpecialRecord:
    """A special point of a branch, as of `vibsim.orbits.branches.special_points`.

    way, number : of the point behind it, seen from the start
    before, after : the words on both sides, the way the branch was walked; jump : of the index on that way
    """

    way: int
    number: int
    kind: str
    orbit: OrbitRecord
    unknowns: tuple[float, ...]
    tangent: tuple[float, ...]
    before: Word
    after: Word
    jump: int


@dataclass(frozen=True)
class BranchStep:
    """A point of a branch, and the special points in front of it."""

    point: PointRecord
    specials: tuple[SpecialRecord, ...] = ()

    @property
    def way(self) -> int:
        return self.point.way

    @property
    def number(self) -> int:
        return self.point.number


def orbit_record(node: Node) -> OrbitRecord:
    """Record of a node."""
    point, end = node.point, node.point.end
    return OrbitRecord(
        parameter=point.parameter,
        period=point.period,
        state=tuple(end.X.tolist()),
        multipliers=tuple(node.multipliers.tolist()),
        word=node.word,
        fold=node.fold,
        doubling=node.doubling,
        margin=float(end.margin),
        drift=tuple(end.drift.values()),
        residual=length_of(point.residual),
        uncertified=int(end.uncertified),
    )


def point_record(node: Node, way: int, number: int, step: float, ended: str = "") -> PointRecord:
    """A point of a branch as it is kept."""
    places = tuple(node.z.tolist()), tuple(node.tangent.tolist())
    return PointRecord(way, number, orbit_record(node), *places, step, node.iterations, ended)


def records_of(step: Step, way: int, number: int) -> BranchStep:
    """Records of step `number` of a walk."""
    specials = tuple(special_record(each, way, number) for each in step.specials)
    return BranchStep(point_record(step.node, way, number, step.next, step.ended), specials)


def special_record(special: Special, way: int, number: int) -> SpecialRecord:
    """A special point as it is kept."""
    node = special.node
    return SpecialRecord(
        way,
        number,
        special.kind,
        orbit_record(node),
        tuple(node.z.tolist()),
        tuple(node.tangent.tolist()),
        *special.words,
        special.jump,
    )


MOST_POINTS = 5000
CLOSED = "closed"
ALONE = (FOLD, DOUBLING, TORUS)
FAR, SAME = 10, 1e-7  # points between, and scaled distance of two places that are one
REMEMBERED = 3  # points that the next step goes by

Watch = Callable[..., bool]  # told the number of points, of a branch the special points; whether to go on


class Keeper(Protocol):
    """Store of the points of a branch."""

    points: list[PointRecord]
    specials: list[SpecialRecord]

    def add(self, records: Iterable[BranchStep]) -> None:
        """Keep points with their special points."""


def trace(
    plan: BranchPlan,
    keeper: Keeper,
    most: int = MOST_POINTS,
    watch: Watch | None = None,
) -> bool:
    """Trace a branch from where `keeper` knows it until it ends both ways, or has `most` points.

    watch : told the number of points and the special points of each step; whether to go on. Returns whether
    the branch has been followed to its ends, or `most` points. Raises ContinuationError where the start is
    no orbit.
    """
    family = plan.family()
    start = plan.start(family)
    if not keeper.points:
        keeper.add([BranchStep(point_record(start, 1, 0, plan.pace.first))])
    for way in plan.ways:
        done = [point for point in keeper.points if point.way == way or point.number == 0]
        own = [point for point in done if point.way == way]  # the start is of the way forwards
        if (own and own[-1].ended) or any(point.ended == CLOSED for point in keeper.points):
            continue
        share = most if way == plan.ways[-1] else (most + 1) // 2
        walk = _walk(plan, family, _turned(start, way), done, way)
        for step in walk.steps():
            made = records_of(step, way, walk.count)
            point, specials = made.point, made.specials
            again = next((each for each in specials if _passed_specials(keeper.specials, each)), None)
            if again is not None:  # as where a step has led onto a branch that crosses this one
                point = replace(point, ended=f"comes back to {NAMES[again.kind]} that it has passed")
                specials = specials[: specials.index(again)]
            keeper.add([BranchStep(point, specials)])
            if watch is not None and not watch(len(keeper.points), specials):
                return False
            if point.ended or len(keeper.points) >= share:
                break
    return True


def _passed_specials(specials: list[SpecialRecord], special: SpecialRecord) -> bool:
    """Whether a bifurcation that one branch alone goes through is among those behind a walk."""
    if special.kind not in ALONE:
        return False
    behind = (one for one in specials if one.way == special.way and special.number - one.number > FAR)
    z = np.array(special.unknowns)
    return any(one.kind == special.kind and length_of(one.unknowns - z) <= SAME for one in behind)


def _turned(start: Node, way: int) -> Node:
    return start if way > 0 else Node.of(start.point, -start.tangent, start.iterations)


def _walk(plan: BranchPlan, family: Family, start: Node, done: list[PointRecord], way: int) -> Walk:
    """A walk from the last of the points that are there."""
    walk = Walk(family, start, plan.span, plan.pace)
    nodes = [_node(family, point, way) for point in done[-REMEMBERED:]]
    for (before, node), point in zip(pairwise(nodes), done[1 - len(nodes) :], strict=False):
        walk.go_on(before, node, point.step, point.number)
    return walk


def _node(family: Family, point: PointRecord, way: int) -> Node:
    """A point that is there, its tangent the way that is walked."""
    tangent = way * point.way * np.array(point.tangent)
    return Node.of(family(np.array(point.unknowns)), tangent, point.iterations)


# The course of a branch or a locus between its points: cubics with the tangents that are known there.


ALONG = 0.9  # cosine of the angle between a step and the tangents at its ends; else these are not its own
TESTED = 0.4  # share at which a stretch is compared with its chord: an S crosses it in the middle
NEAR = 0.1  # of a stretch: a place behind that says nothing of how it bends
FINE = 1e-4  # of what is drawn: how far from the chord a stretch may be
DEEPEST = 6  # halvings of a stretch
Places = Callable[[Any], tuple[float, ...]]


@dataclass(frozen=True)
class Between:
    """An orbit between two points, as far as pictures ask; see `OrbitRecord` of `tracing`."""

    parameter: float
    period: float
    state: tuple[float, ...]


@dataclass(frozen=True)
class Arc:
    """A curve in the scaled unknowns from one place to another.

    leaving, arriving : unit vectors along it at its ends, either way, where they are known
    earlier, later : places that the curve comes from, and that it goes on to
    """

    start: np.ndarray
    end: np.ndarray
    leaving: np.ndarray | None = None
    arriving: np.ndarray | None = None
    earlier: np.ndarray | None = None
    later: np.ndarray | None = None

    def __call__(self, share: float) -> np.ndarray:
        """Scaled unknowns at a share of the way."""
        one, other = self._bulges
        bulge = share * (1 - share) * ((1 - share) * one + share * other)
        return np.asarray(self.start + share * self._chord + bulge)

    @cached_property
    def _chord(self) -> np.ndarray:
        return np.asarray(self.end - self.start)

    @cached_property
    def _bulges(self) -> tuple[np.ndarray, np.ndarray]:
        """dz / d share at the start less the chord, and the chord less it at the end."""
        chord = self._chord
        leaving, arriving = (self._along(tangent) for tangent in (self.leaving, self.arriving))
        if leaving is not None and arriving is not None:
            half = np.sqrt((1 + min(1.0, dot(leaving, arriving) / dot(chord, chord))) / 2)
            longer = 2 / (1 + half)  # than the chord, by 1 / cos^2 of a quarter of the turn, as on a circle
            return longer * leaving - chord, chord - longer * arriving
        if leaving is not None:
            return leaving - chord, _other(leaving - chord, self.start, self.earlier, chord)
        if arriving is not None:
            return _other(chord - arriving, self.end, self.later, -chord), chord - arriving
        return np.zeros(len(chord)), np.zeros(len(chord))

    def _along(self, tangent: np.ndarray | None) -> Any:
        """A tangent as long as the chord; None where it does not go along."""
        length = length_of(self._chord)
        if tangent is None or not abs(dot(tangent, self._chord)) > ALONG * length:
            return None
        return tangent * np.copysign(length, dot(tangent, self._chord))


def _other(bulge: np.ndarray, place: np.ndarray, behind: np.ndarray | None, chord: np.ndarray) -> np.ndarray:
    """The bulge at the end without a tangent, of the cubic through the place behind the other end; without a
    place, of a parabola.
    """
    if behind is None:
        return bulge
    back = place - behind
    share = length_of(back) / length_of(chord)
    if share < NEAR or not dot(back, chord) > ALONG * share * dot(chord, chord):
        return bulge
    # at -share the curve is at the place behind: chord - share (1 + share) ((1 + share) one - share other)
    missing = (share * chord - back) / (share * (1 + share))
    return np.asarray(((1 + share) * bulge + missing) / share)


@dataclass(frozen=True)
class Stretch:
    """A piece of a branch between two of its orbits that were computed, and whether its orbits are stable."""

    one: Any
    other: Any
    arc: Arc
    scale: np.ndarray
    stable: bool

    def at(self, share: float) -> Between:
        """The orbit at a share of the way."""
        values = (self.arc(share) * self.scale).tolist()
        count = len(self.one.state)
        free = len(values) == count + 2
        period = values[count] if free else self._period(values[-1])
        return Between(values[-1], period, tuple(values[:count]))

    def _period(self, parameter: float) -> float:
        """Time of return where the source tells it [s]: 1 / T is constant or goes with the parameter."""
        one, other = self.one, self.other
        span = other.parameter - one.parameter
        share = (parameter - one.parameter) / span if span else 0.0
        return float(1 / ((1 - share) / one.period + share / other.period))


@dataclass(frozen=True)
class _Knot:
    """A computed orbit: its place, the tangent unless it may be a corner, multipliers outside behind it."""

    orbit: Any
    place: np.ndarray
    tangent: np.ndarray | None
    index: int
    family: bool = False


def stretches(branch: Any) -> list[Stretch]:
    """A branch from one computed orbit to the next, special points included, first to last.

    Orbits of a family have a multiplier on the unit circle and are not stable, though none is outside; those
    of a backbone curve count as stable where none is outside.
    """
    scale = branch.plan.family().scale
    knots = [knot for i in range(len(branch)) for knot in _knots(branch, i)]
    around: list[Any] = [None, *knots, None]
    return [
        Stretch(one.orbit, other.orbit, _arc(*around[i : i + 4]), scale, one.index == 0 and not one.family)
        for i, (one, other) in enumerate(pairwise(knots))
    ]


def _arc(before: Any, one: _Knot, other: _Knot, after: Any) -> Arc:
    earlier, later = (None if knot is None else knot.place for knot in (before, after))
    return Arc(one.place, other.place, one.tangent, other.tangent, earlier, later)


def _knots(branch: Any, i: int) -> Iterator[_Knot]:
    """Point i, and the special points up to the next."""
    point = branch.points[i]
    pair, index = branch.points[i : i + 2], point.orbit.index
    family = all(one.orbit.index == 0 for one in pair) and not branch["stable"][i : i + 2].any()
    yield _Knot(point.orbit, np.array(point.unknowns), np.array(point.tangent), index, family)
    for special in _passed(branch, i) if len(pair) > 1 else ():
        index += special.jump
        tangent = np.array(special.tangent) if special.before == special.after else None
        yield _Knot(special.orbit, np.array(special.unknowns), tangent, index, family)


def _passed(branch: Any, i: int) -> list[Any]:
    """The special points between point i and the next; not a grazing beyond the last one."""
    one, other = (np.array(point.unknowns) for point in branch.points[i : i + 2])
    chord = other - one
    between = [special for special in branch.specials if special.between == (i, i + 1)]
    return [each for each in between if 0 < dot(np.array(each.unknowns) - one, chord) < dot(chord, chord)]


def drawn(curve: Any, ends: tuple[Any, Any], value: Places, sizes: np.ndarray) -> np.ndarray:
    """Values (n, d) along a stretch, so close that their polygon is the curve to 1e-4 of `sizes` (d).

    curve : what lies at a share of the way; ends : what lies at 0 and at 1; value : of either
    """

    def inner(low: float, high: float, first: Any, last: Any, depth: int) -> list[Any]:
        middle = low + TESTED * (high - low)
        here = np.array(value(curve(middle)))
        far = np.abs((here - first - TESTED * (last - first)) / sizes).max() > FINE
        if not far or depth == DEEPEST:
            return []
        return [
            *inner(low, middle, first, here, depth + 1), here, *inner(middle, high, here, last, depth + 1)
        ]  # fmt: skip

    first, last = (np.array(value(end)) for end in ends)
    return np.array([first, *inner(0.0, 1.0, first, last, 0), last])


def curve_of(locus: Any) -> np.ndarray:
    """Both parameters (n, 2) along a locus, smooth between its points."""
    points = locus.points
    scale = locus.plan.plane().scale[-2:]
    arcs = [
        Arc(*(np.array(each.unknowns) for each in pair), *(np.array(each.tangent) for each in pair))
        for pair in pairwise(points)
    ]
    places = np.array([point.unknowns[-2:] for point in points]) * scale
    sizes = np.ptp(places, axis=0)
    sizes[sizes == 0] = 1.0
    lines = [
        drawn(lambda share, arc=arc: arc(share)[-2:] * scale, ends, lambda place: place, sizes)
        for arc, ends in zip(arcs, pairwise(places), strict=True)
    ]
    return np.concatenate([places[:1], *(line[1:] for line in lines)])


# Extremes of the motion of an orbit over one period.


def half_range(return_map: Any, orbit: OrbitRecord) -> float:
    """Half of greatest less least of the first displacement among the unknowns [m]."""
    at = return_map.coordinates
    row = at.take[0]
    ends = int(np.argmax(row)), int(np.argmin(row)) if row.min() < 0 else GROUND
    scene = placed(return_map.scene, at.state(np.array(orbit.state)), orbit.period)
    trajectory = open_trajectory(scene.without_samples(), extremes=([ends], 0.0))
    for _ in trajectory.blocks():
        pass
    least, greatest, _ = trajectory.extremes
    return float(greatest[0] - least[0]) / 2

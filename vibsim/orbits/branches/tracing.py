"""A branch traced both ways from its start, each point kept as it comes."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numpy as np

from vibsim.orbits.branches.family import Family
from vibsim.orbits.branches.node import Node
from vibsim.orbits.branches.plan import BranchPlan
from vibsim.orbits.branches.special_points import DOUBLING, FOLD, NAMES, TORUS, Special
from vibsim.orbits.branches.walk import Step, Walk
from vibsim.orbits.coordinates import Word
from vibsim.orbits.stability import length_of, sides_of_circle

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
    """Where points of a branch are kept."""

    points: list[PointRecord]
    specials: list[SpecialRecord]

    def add(self, records: Iterable[BranchStep]) -> None:
        """Keep points with their special points."""


def trace(
    plan: BranchPlan,
    keeper: Keeper,
    most: int = MOST_POINTS,
    engine: str = "auto",
    watch: Watch | None = None,
) -> bool:
    """Trace a branch from where `keeper` knows it until it ends both ways, or has `most` points.

    watch : told the number of points and the special points of each step; whether to go on. Returns whether
    the branch has been followed to its ends, or `most` points. Raises ContinuationError where the start is
    no orbit.
    """
    family = plan.family(engine)
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

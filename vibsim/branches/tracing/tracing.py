"""A branch traced both ways from its start, each point kept as it comes."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Protocol

import numpy as np

from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node
from vibsim.branches.plan import BranchPlan
from vibsim.branches.special.special import DOUBLING, FOLD, NAMES, TORUS
from vibsim.branches.tracing.records import PointRecord, SpecialRecord, point_record, records_of
from vibsim.branches.tracing.walk import Walk
from vibsim.orbits.matrices import length_of

MOST_POINTS = 5000
CLOSED = "closed"
ALONE = (FOLD, DOUBLING, TORUS)
FAR, SAME = 10, 1e-7  # points between, and scaled distance of two places that are one
REMEMBERED = 3  # points that the next step goes by

Watch = Callable[[int, list[SpecialRecord]], bool]


class Keeper(Protocol):
    """Where points of a branch are kept."""

    points: list[PointRecord]
    specials: list[SpecialRecord]

    def add(self, point: PointRecord, specials: list[SpecialRecord]) -> None:
        """Keep a point, and the special points in front of it."""


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
        keeper.add(point_record(start, 1, 0, plan.pace.first), [])
    for way in plan.ways:
        done = [point for point in keeper.points if point.way == way or point.number == 0]
        own = [point for point in done if point.way == way]  # the start is of the way forwards
        if (own and own[-1].ended) or any(point.ended == CLOSED for point in keeper.points):
            continue
        share = most if way == plan.ways[-1] else (most + 1) // 2
        walk = _walk(plan, family, _turned(start, way), done, way)
        for step in walk.steps():
            point, specials = records_of(step, way, walk.count)
            again = next((each for each in specials if _passed(keeper.specials, each)), None)
            if again is not None:  # as where a step has led onto a branch that crosses this one
                point = replace(point, ended=f"comes back to {NAMES[again.kind]} that it has passed")
                specials = specials[: specials.index(again)]
            keeper.add(point, specials)
            if watch is not None and not watch(len(keeper.points), specials):
                return False
            if point.ended or len(keeper.points) >= share:
                break
    return True


def _passed(specials: list[SpecialRecord], special: SpecialRecord) -> bool:
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

"""Across an impact that comes to the section: there the branch is followed on a section at another phase.

The state on the section jumps where an impact passes it, and the return map with it; where a contact with a
stop begins or ends there, the state has a kink that Newton's method may not get across. The orbits themselves
go on. Seen from a phase at which nothing happens they are followed until the impact is on the other side.
"""

from itertools import pairwise
from typing import Any

import numpy as np

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node, node_at
from vibsim.branches.special.touching import later
from vibsim.engine.tangent.monodromy import Carrier
from vibsim.orbits import ReturnMap
from vibsim.orbits.returns.return_map import Return
from vibsim.physics.parts import Scene

IMPACTS = ("impact", "transmitted")
CONTACTS = (*IMPACTS, "contact_begin", "contact_end")
WITHIN = 0.02  # share of the period from the section, within which an impact may have ended a walk
NEAR = 1e-3  # the same, where it has passed the section and hinders Newton's method no more
POLISH = 6  # Newton steps of the time that a motor takes to the section
CORRECTION = 0.1  # scaled, that a point taken from one section to the other may need


class MovedMap(ReturnMap):
    """From a section behind that of a scene, by a share of the period or an angle of the motor, to itself."""

    def __init__(self, scene: Scene, n: int, engine: str, share: float, angle: float):
        super().__init__(scene, n, engine)
        if self.section.timed:
            self.carrier = Carrier(later(scene, share * self.section.time(n)), engine)
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
        super().__init__(of.case, of.keys, of.unit, of.n, of.engine)
        self.of, self.scale, self.share, self.path = of, of.scale, share, of.path
        of_map = of.map(node.parameter)
        start = of_map.coordinates.lifted(node.point.end.X)
        self._state = of_map.carrier.carry(start, share * node.point.period, []).state
        pinned = of_map.section.pinned
        self.angle = 0.0 if pinned is None else float(self._state[pinned])
        self._from = node

    def _new_map(self, scene: Scene) -> ReturnMap:
        return MovedMap(scene, self.n, self.engine, self.share, self.angle)

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
    """When events of some kinds happen, in shares of the period from the section."""
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
            if _passed(moved, node, step.node):
                return moved.given_back(step.node)
    except ContinuationError:
        return None
    return None


def _passed(moved: MovedFamily, before: Node, node: Node) -> bool:
    """Whether what was near one side of the section is on the other, and far enough from it."""
    behind = min(times_of(before, CONTACTS), key=lambda t: min(t, 1 - t)) < 0.5
    section = moved.rest(node)[0] / node.point.period
    nearest = min((t - section for t in times_of(node, CONTACTS)), key=abs, default=0.0)
    return abs(nearest) > NEAR and (nearest < 0) == behind

"""Rigid stops at one place: between the same ends, in either order, on one side and with one gap."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from vibsim.physics.arithmetic.numbers import N
from vibsim.physics.parts import RigidStop, Scene


def twins_of(scene: Scene[N], i: int) -> list[int]:
    """Numbers of the rigid stops whose depth is that of rigid stop `i` at all times, `i` among them."""
    one = dict(scene.rigid_stops)[i]
    ways = (one.P, one.Q, one.sense, one.gap), (one.Q, one.P, -one.sense, one.gap)
    return [j for j, other in scene.rigid_stops if (other.P, other.Q, other.sense, other.gap) in ways]


def hardest(stops: Mapping[int, RigidStop[N]], twins: Iterable[int]) -> int:
    """Of stops at one place the one that the law of impacts obeys: of the greatest e, the first of several.
    It fulfils g'(after) + e g'(before) <= 0 of all of them, so the others pass nothing.
    """
    return min(twins, key=lambda j: (-stops[j].e, j))

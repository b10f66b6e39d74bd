"""Where a branch turns back because a sliding velocity touches zero.

Some orbits slide all the time at a friction, others stick on it for a while: as both come to the touch they
become one, and beyond it there is neither. The return map has a kink there, and no step of the branch gets
across. It goes on among the orbits of the other kind, back in the parameter: a fold without a multiplier 1
(Leine and van Campen 2006).
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.branches.curve.family import Family
from vibsim.branches.curve.node import Node, node_at
from vibsim.branches.special.holding import STICK, kinds_of
from vibsim.branches.special.special import CORNER, Special
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits import ReturnMap
from vibsim.orbits.matrices import length_of
from vibsim.orbits.returns.gaps import apart, motion_of_base
from vibsim.orbits.returns.start import placed
from vibsim.orbits.returns.word import Word, changes

BACK = (1e-4, 1e-3, 1e-2)  # scaled: how far back in the parameter orbits of the other kind are looked for
ASIDE = (0.25, 1.0, 4.0, 16.0)  # times that: how far a state is moved to be of the other kind
NEAR = 200.0  # times that: how far such an orbit may be
SAMPLES = 256  # of a period, among which the touch is looked for
FIRST = 1e-9  # of it: a motion takes some time
SHARE = 0.1  # of the slip that is left, at the next orbit on the way to the touch
TOUCHED = 1e-12  # of the first slip that is left: the touch
TRIES = 40


def sliding_corner(family: Family, node: Node, risen: float) -> tuple[Special, Node] | None:
    """The touch near the last node of a branch at which it turns back, and the node behind it; None where
    there is none.

    risen : above 0 where the parameter has risen to the node
    """
    for back in BACK:
        change = float(np.copysign(back, risen))
        for start in _beside(family, node, -change, back):
            try:
                behind = node_at(family, start, None, None, NEAR * back)
                friction = _sticks_apart(node.word, behind.word)
                if friction is None or length_of(behind.z - node.z) > NEAR * back:
                    continue
                slipping = min((node, behind), key=lambda one: len(one.word))
                at = _touch(family, _near(family, slipping, start[-1]), friction, change)
            except ContinuationError:
                continue
            away = Node(behind.point, behind.z - at.z, behind.iterations)
            return Special(CORNER, at, node, away), away
    return None


def _beside(family: Family, node: Node, change: float, size: float) -> Iterator[np.ndarray]:
    """Scaled unknowns about the size beside those of a node, at a parameter changed, with sticks or without
    where it has none or has them.
    """
    count = len(node.point.end.X)
    for times in ASIDE:
        for shift in (*np.eye(count), *-np.eye(count)):
            z = node.z.copy()
            z[:count] += times * size * shift
            z[-1] += change
            try:
                if _sticks_apart(node.word, family(z).word) is not None:
                    yield z
            except ContinuationError:
                continue


def _sticks_apart(one: Word, other: Word) -> int | None:
    """The friction at which one of two words has a stick and the other not; None where they differ else."""
    gone, come = changes(one, other)
    more = gone or come
    frictions = {part for _, part in more}
    alone = kinds_of(more) == STICK and not (gone and come) and len(frictions) == 1
    return frictions.pop() if alone else None


def _near(family: Family, node: Node, parameter: float) -> Node:
    """The orbit of the kind of a node at a scaled parameter beside it. Raises ContinuationError."""
    change = parameter - node.z[-1]
    beside = node if change == 0 else node_at(family, _along(node, change), None, None, NEAR)
    if beside.word != node.word:
        raise ContinuationError("beside the touch there is no orbit of its kind")
    return beside


def _along(node: Node, change: float) -> np.ndarray:
    """Scaled unknowns on the tangent of a node, where the parameter has changed."""
    return np.asarray(node.z + node.tangent * (change / node.tangent[-1]))


def _touch(family: Family, node: Node, friction: int, distance: float) -> Node:
    """The orbit that touches, from one that slides all the time, about so far away in the scaled parameter.

    Raises ContinuationError.

    Each orbit on the way has a tenth of the slip of the one before, where the secant says.
    """
    places, slips = [node.z], [least_slip(family, node, friction)]
    for _ in range(TRIES):
        if slips[-1] <= TOUCHED * slips[0]:
            break
        if len(slips) > 1:
            if slips[-1] == slips[-2]:
                raise ContinuationError("the slip does not change on the way to the touch")
            slope = (places[-1] - places[-2]) / (slips[-1] - slips[-2])
            start = places[-1] - (1 - SHARE) * slips[-1] * slope
        else:
            start = _along(node, SHARE * distance)
        following = node_at(family, start, None, None, NEAR)
        if following.word != node.word:
            raise ContinuationError("the way to the touch leads elsewhere")
        places.append(following.z)
        slips.append(least_slip(family, following, friction))
        node = following
    return node


def least_slip(family: Family, node: Node, friction: int) -> float:
    """The least speed of slip at a turn of it on an orbit [m/s]. Raises ContinuationError without any."""
    of, period = family.map(node.parameter), node.point.period
    start, part = of.coordinates.lifted(node.point.end.X), of.scene.frictions[friction]
    times, slips = _sampled_slip(of, node, part)
    sizes = abs(slips)
    inner = (sizes[1:-1] <= sizes[:-2]) & (sizes[1:-1] <= sizes[2:])
    turns = 1 + np.flatnonzero(inner & (slips[:-2] * slips[2:] > 0))

    def rate(t: float) -> float:
        return _slip_of(of.scene, part, t, of.carrier.carry(start, t, []))[1]

    for at in sorted(turns, key=lambda i: sizes[i]):
        begin, end = max(times[at - 1], FIRST * period), times[at + 1]
        if rate(begin) * rate(end) < 0:
            turn = _zero_of(rate, begin, end, 1e-14 * period)
            return abs(_slip_of(of.scene, part, turn, of.carrier.carry(start, turn, []))[0])
    raise ContinuationError("no sliding velocity turns before zero")


def _zero_of(rate: Callable[[float], float], low: float, high: float, fine: float) -> float:
    """Where a rate changes its sign between two times, after Anderson and Bjorck as in `regula_falsi`."""
    r_low, r_high = rate(low), rate(high)
    for _ in range(TRIES):
        t = high - r_high * (high - low) / (r_high - r_low)
        r = rate(t)
        if r == 0 or abs(t - high) <= fine:
            return t
        if r * r_high < 0:
            low, r_low = high, r_high
        else:
            shrink = 1 - r / r_high
            r_low *= shrink if shrink > 0 else 0.5
        high, r_high = t, r
    return high


def _sampled_slip(of: ReturnMap, node: Node, part: Any) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] of a period, and the sliding velocity of a friction at them."""
    at = of.coordinates
    scene = placed(of.scene, at.state(node.point.end.X), node.point.period)
    step = Fraction(node.point.period / SAMPLES).limit_denominator(10**9)
    sampled = replace(scene, every_num=step.numerator, every_den=step.denominator)
    blocks = [block.samples for block in open_trajectory(sampled, of.carrier.engine).blocks()]
    n = len(scene.bodies)
    names = ("time", *at.columns[n : 2 * n])
    times, *v = (np.concatenate([block[name] for block in blocks]) for name in names)
    return times, apart(part, v, motion_of_base(scene, times)[1]) - part.belt


def _slip_of(scene: Any, friction: Any, t: float, there: Any) -> tuple[float, float]:
    """Sliding velocity of a friction and its rate, where a motion has come to."""
    n, base = len(scene.bodies), motion_of_base(scene, t)
    v, a = apart(friction, there.state[n:], base[1]), apart(friction, there.rate[n:], base[2])
    return float(v) - friction.belt, float(a)

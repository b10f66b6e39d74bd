"""Kinds of special points of a branch between two of its points, and their names; corners."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np

from vibsim.engine.modes.row_maker import RowMaker
from vibsim.engine.trajectory import open_trajectory
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.family import Family
from vibsim.orbits.branches.node import Node, node_at
from vibsim.orbits.coordinates import placed
from vibsim.orbits.return_map import Return, ReturnMap
from vibsim.orbits.stability import excess, length_of
from vibsim.orbits.words import Word, changes, without_sequences
from vibsim.physics.formula_values import apart, motion_of_base, motion_of_belt
from vibsim.physics.numbers import Doubles
from vibsim.physics.parts import Scene

FOLD, DOUBLING, TORUS, BRANCHING = "fold", "doubling", "neimark-sacker", "branch point"
GRAZING, STICKING, TURNING, ORDER, CORNER = "grazing", "sticking", "turn", "order", "corner"
UNRESOLVED, HOPF = "unresolved", "hopf"
LABELS = {
    FOLD: "F",
    DOUBLING: "PD",
    TORUS: "NS",
    BRANCHING: "BP",
    GRAZING: "GR",
    STICKING: "ST",
    TURNING: "TU",
    ORDER: "OR",
    CORNER: "CO",
    UNRESOLVED: "UR",
    HOPF: "HO",
}
NAMES = {  # as they are called in sentences
    FOLD: "a fold",
    DOUBLING: "a doubling",
    TORUS: "a Neimark-Sacker point",
    BRANCHING: "a branch point",
    GRAZING: "a grazing",
    STICKING: "a stick phase that comes or goes",
    TURNING: "a sliding velocity that touches zero",
    ORDER: "a change of the order of events alone",
    CORNER: "a corner",
    UNRESOLVED: "not resolved",
    HOPF: "a Hopf point",
}
CONTACTS = ("contact_begin", "contact_end", "impact", "transmitted")
BIFURCATIONS = (FOLD, DOUBLING, TORUS, BRANCHING, CORNER, UNRESOLVED, HOPF)


@dataclass(frozen=True)
class Special:
    """A special point of a branch.

    kind : one of `LABELS`; node : where it is
    before, after : the branch on both sides of it, as near as it was bracketed
    told : the words on both sides, where those of `before` and `after` are not they
    """

    kind: str
    node: Node
    before: Node
    after: Node
    told: tuple[Word, Word] | None = None

    @property
    def words(self) -> tuple[Word, Word]:
        """On both sides."""
        return self.told or (self.before.word, self.after.word)

    @property
    def jump(self) -> int:
        """Number of multipliers that leave the unit circle there (negative: that enter it)."""
        return 0 if self.told else self.after.index - self.before.index


def kind_of_change(before: Word, after: Word) -> str:
    """Kind of a change of the order of events: contacts or stick phases that come or go, reversals, or the
    order alone. A stick phase goes where impacts that a chatter ends follow each other without one between.
    """
    gone, come = changes(without_sequences(before), without_sequences(after))
    changed = {kind for kind, _ in gone + come}
    if not changed and Counter(before) != Counter(after):
        return STICKING
    if changed & set(CONTACTS):
        return GRAZING
    if changed & {"stick_begin", "stick_end", "rest_begin", "rest_end"}:
        return STICKING
    return TURNING if changed else ORDER


# Where a reversal of a sliding velocity becomes a stick: the test value of such a change.
#
# Where the sliding velocity comes to zero a tie would have to pass a force S. Beyond the limit the ends slide
# back, below it they stick; at the change the two are equal. How far |S| is beyond the limit is a smooth
# function of the orbit on either side. The return map has a kink there, so derivatives are taken a little
# beside it, on the side on which an orbit is.


STOPPED = ("reversal", "stick_begin")  # events at which a sliding velocity is zero
STICK = Counter(stick_begin=1, stick_end=1)  # what happens there instead of a reversal


def held(before: Word, after: Word) -> int | None:
    """Number of the friction of which a reversal becomes a stick, or a stick a reversal, between two words,
    one or several at once, as of a motion that is its own mirror image; None where another thing happens.
    """
    gone, come = changes(before, after)
    frictions = {part for _, part in gone + come}
    sides = [kinds_of(gone), kinds_of(come)]
    count = (sides[0] + sides[1])["reversal"]
    stick, back = Counter(dict.fromkeys(STICK, count)), Counter(reversal=count)
    return frictions.pop() if len(frictions) == 1 and sides in ([stick, back], [back, stick]) else None


def kinds_of(events: Counter[tuple[str, int]]) -> Counter[str]:
    """Count of each kind among events."""
    return Counter(kind for kind, _ in events.elements())


def stops_of(scene: Scene, end: Return, friction: int) -> list[tuple[float, float]]:
    """Zeros of the sliding velocity of a friction [s / period], and how far the force that would
    hold it there is beyond its limit [N], below 0 where it holds; scene: with the numbers of the motion.

    Raises ContinuationError where it never does.
    """
    carried, maker = end.carried, RowMaker(scene, Doubles)
    rows = zip(carried.events, carried.times, carried.states, carried.codes.tolist(), strict=True)
    stops = [
        (float(t) / end.T, excess(scene, maker, friction, t, state, codes))
        for (kind, part), t, state, codes in rows
        if part == friction and kind in STOPPED
    ]
    if not stops:
        raise ContinuationError("the sliding velocity comes to zero no more")
    return stops


def critical_share(scene: Scene, end: Return, friction: int) -> float:
    """Instant [s / period] at which the holding force is nearest to its limit. Raises ContinuationError."""
    return min(stops_of(scene, end, friction), key=lambda stop: abs(stop[1]))[0]


def excess_at(scene: Scene, end: Return, friction: int, share: float) -> float:
    """Excess of the force over its limit [N] at the stop nearest to a share of the period.

    Raises ContinuationError where there is none.
    """
    return min(stops_of(scene, end, friction), key=lambda stop: _apart(stop[0], share))[1]


def _apart(one: float, other: float) -> float:
    """Distance on the circle."""
    apart = abs(one - other) % 1.0
    return min(apart, 1.0 - apart)


# Where a branch turns back at a change of order, as where a sliding velocity touches zero.
#
# Some orbits slide all the time at a friction, others stick on it for a while: as both come to the touch they
# become one, and beyond it there is neither. The return map has a kink there, and no step of the branch gets
# across. It goes on among the orbits of the other kind, back in the parameter: a fold without a multiplier 1
# (Leine and van Campen 2006). So it is where a stick begins just before an impact, at which it ends: then
# det(P' - I) has one sign on either side and the other on the other, and the place is where the orbits meet.


# scaled: how far back in the parameter orbits of the other kind are looked for; the last two where these have
# a fold of their own near by
BACK = (1e-4, 1e-3, 1e-2, 1e-5, 1e-6)
ASIDE = (0.25, 1.0, 4.0, 16.0)  # times that: how far a state is moved to be of the other kind
NEAR_CORNER = 200.0  # times that: how far such an orbit may be
CORNER_SAMPLES = 256  # of a period, among which the touch is looked for
FIRST = 1e-9  # of it: a motion takes some time
CORNER_SHARE = 0.1  # of the slip that is left, at the next orbit on the way to the touch
TOUCHED = 1e-12  # of the first slip that is left: the touch
TRIES = 40
TENTHS = 6  # of the way to a change of order that orbits behind it are followed
MET = 1e-13  # scaled distance of two orbits that are one: Newton's method leaves as much


def corner_near(family: Family, node: Node, risen: float) -> tuple[Special, Node] | None:
    """The change of order near the last node of a branch at which it turns back, and the node behind it; None
    where there is none.

    risen : above 0 where the parameter has risen to the node
    """
    for back in BACK:
        change = float(np.copysign(back, risen))
        for start in _beside(family, node, -change, back):
            try:
                behind = node_at(family, start, None, None, NEAR_CORNER * back)
                if length_of(behind.z - node.z) > NEAR_CORNER * back:
                    continue
                at = _corner_of(family, node, behind, change)
            except ContinuationError:
                continue
            away = Node(behind.point, behind.z - at.z, behind.iterations)
            return Special(CORNER, at, node, away), away
    return None


def beyond_the_change(family: Family, node: Node) -> Node | None:
    """The node just behind a change of order near the last node of a branch, at which the slope of the branch
    jumps so much that no step along its tangent gets across; None where there is none.
    """
    if node.ahead == 0:
        return None
    for beyond in sorted(BACK):
        for start in _beside(family, node, float(np.copysign(beyond, node.ahead)), beyond):
            try:
                behind = node_at(family, start, None, None, NEAR_CORNER * beyond)
            except ContinuationError:
                continue
            if node.fold * behind.fold > 0 and _slips_apart(node.word, behind.word):
                behind.go_like((node,))
                nearest = _nearest_of_kind(family, node, behind)
                away = abs(nearest.z[-1] - node.z[-1])
                if away <= min(BACK) and length_of(nearest.z - node.z) <= NEAR_CORNER * away:
                    return behind
    return None


def _nearest_of_kind(family: Family, node: Node, behind: Node) -> Node:
    """The orbit of the kind of a second node that is nearest to the first, in steps to a tenth of the way."""
    for _ in range(TENTHS):
        try:
            parameter = node.z[-1] + CORNER_SHARE * (behind.z[-1] - node.z[-1])
            behind = _near(family, behind, parameter)
        except ContinuationError:
            break
    return behind


def _corner_of(family: Family, node: Node, behind: Node, change: float) -> Node:
    """The orbit that the orbits of both kinds become, one of each known; `change` of the scaled parameter
    leads there from the second. Raises ContinuationError where they do not, or det(P' - I) has one sign on
    both sides.
    """
    if not node.fold * behind.fold < 0:
        raise ContinuationError("the orbits of two kinds do not end each other")
    friction = _sticks_apart(node.word, behind.word)
    if friction is not None:
        slipping = min((node, behind), key=lambda one: len(one.word))
        try:
            return _touch(family, _near(family, slipping, behind.z[-1]), friction, change)
        except ContinuationError:
            pass
    return _meeting(family, node, behind)


def _meeting(family: Family, node: Node, behind: Node) -> Node:
    """The orbit at which those of two kinds meet, from one of each: their distance is proportional to that in
    the parameter. Raises ContinuationError where they do not.
    """
    if not _slips_apart(node.word, behind.word):
        raise ContinuationError("the orbits are of one kind")
    words, one, other = (node.word, behind.word), _near(family, node, behind.z[-1]), behind
    places: list[float] = []
    gaps: list[float] = []
    for _ in range(TRIES):
        if (one.word, other.word) != words:
            raise ContinuationError("the way to the corner leads elsewhere")
        difference = one.z - other.z
        if not gaps:
            widest = int(np.argmax(np.abs(difference)))
        places.append(one.z[-1])
        gaps.append(difference[widest])
        if abs(gaps[-1]) <= MET:
            return one
        share = 1 - CORNER_SHARE
        if len(gaps) > 1:
            slope = (places[-1] - places[-2]) / (gaps[-1] - gaps[-2])
            parameter = places[-1] - share * gaps[-1] * slope
        else:
            parameter = places[-1] + share * (node.z[-1] - places[-1])
        one, other = (_near(family, each, parameter) for each in (one, other))
    raise ContinuationError("the orbits of two kinds do not meet")


def _beside(family: Family, node: Node, change: float, size: float) -> Iterator[np.ndarray]:
    """Scaled unknowns about the size beside those of a node, at a parameter changed, with another order of
    events.
    """
    count = len(node.point.end.X)
    for times in ASIDE:
        for shift in (*np.eye(count), *-np.eye(count)):
            z = node.z.copy()
            z[:count] += times * size * shift
            z[-1] += change
            try:
                if _slips_apart(node.word, family(z).word):
                    yield z
            except ContinuationError:
                continue


def _slips_apart(one: Word, other: Word) -> bool:
    """Whether two words differ, and have the same contacts and impacts, each as often."""
    gone, come = changes(one, other)
    return one != other and not set(kinds_of(gone + come)) & set(CONTACTS)


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
    beside = node if change == 0 else node_at(family, _along(node, change), None, None, NEAR_CORNER)
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
            start = places[-1] - (1 - CORNER_SHARE) * slips[-1] * slope
        else:
            start = _along(node, CORNER_SHARE * distance)
        following = node_at(family, start, None, None, NEAR_CORNER)
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
    """Zero of a rate between two times [s], after Anderson and Bjorck as in `regula_falsi`."""
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
    step = Fraction(node.point.period / CORNER_SAMPLES).limit_denominator(10**9)
    sampled = replace(scene, every_num=step.numerator, every_den=step.denominator)
    blocks = [block.samples for block in open_trajectory(sampled).blocks()]
    n = len(scene.bodies)
    times = np.concatenate([block["time"] for block in blocks])
    v = list(np.concatenate([at.gathered(block)[:, n : 2 * n] for block in blocks]).T)
    return times, apart(part, v, motion_of_base(scene, times)[1]) - motion_of_belt(part, times)[0]


def _slip_of(scene: Any, friction: Any, t: float, there: Any) -> tuple[float, float]:
    """Sliding velocity of a friction and its rate, where a motion has come to."""
    n, base = len(scene.bodies), motion_of_base(scene, t)
    v, a = apart(friction, there.state[n:], base[1]), apart(friction, there.rate[n:], base[2])
    belt = motion_of_belt(friction, t)
    return float(v) - float(belt[0]), float(a) - float(belt[1])

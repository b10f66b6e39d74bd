"""Where a reversal of a sliding velocity becomes a stick: the test value of such a change.

Where the sliding velocity comes to zero a tie would have to pass a force S. Beyond the limit the ends slide
back, below it they stick; at the change the two are equal. How far |S| is beyond the limit is a smooth
function of the orbit on either side. The return map has a kink there, so derivatives are taken a little
beside it, on the side on which an orbit is.
"""

from collections import Counter

from vibsim.branches.curve.arclength import ContinuationError
from vibsim.engine.modes.row_maker import RowMaker
from vibsim.orbits.returns.return_map import Return
from vibsim.orbits.returns.word import Word, changes
from vibsim.orbits.sliding import excess
from vibsim.physics.arithmetic.numbers import Doubles
from vibsim.physics.parts import Scene

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
    """How often each kind is among events."""
    return Counter(kind for kind, _ in events.elements())


def stops_of(scene: Scene, end: Return, friction: int) -> list[tuple[float, float]]:
    """When the sliding velocity of a friction comes to zero [s / period], and how far the force that would
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
    """When the force that would hold is nearest to its limit [s / period]. Raises ContinuationError."""
    return min(stops_of(scene, end, friction), key=lambda stop: abs(stop[1]))[0]


def excess_at(scene: Scene, end: Return, friction: int, share: float) -> float:
    """How far the force is beyond its limit [N] at the stop nearest to a share of the period.

    Raises ContinuationError where there is none.
    """
    return min(stops_of(scene, end, friction), key=lambda stop: _apart(stop[0], share))[1]


def _apart(one: float, other: float) -> float:
    """Distance on the circle."""
    apart = abs(one - other) % 1.0
    return min(apart, 1.0 - apart)

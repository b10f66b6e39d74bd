"""Kinds of special points of a branch between two of its points, and their names."""

from collections import Counter
from dataclasses import dataclass

from vibsim.engine.modes.row_maker import RowMaker
from vibsim.orbits.branches.correction import ContinuationError
from vibsim.orbits.branches.node import Node
from vibsim.orbits.coordinates import Word, changes, without_sequences
from vibsim.orbits.return_map import Return
from vibsim.orbits.stability import excess
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
    STICKING: "a stick that comes or goes",
    TURNING: "a sliding velocity that touches zero",
    ORDER: "a change of the order of events alone",
    CORNER: "a corner",
    UNRESOLVED: "not resolved",
    HOPF: "a Hopf point",
}
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
        """How many more multipliers are outside the unit circle behind it."""
        return 0 if self.told else self.after.index - self.before.index


def kind_of_change(before: Word, after: Word) -> str:
    """Kind of a change of the order of events: contacts or sticks that come or go, reversals, or the order
    alone. A stick goes where impacts that a chatter ends follow each other without one between.
    """
    gone, come = changes(without_sequences(before), without_sequences(after))
    changed = {kind for kind, _ in gone + come}
    if not changed and Counter(before) != Counter(after):
        return STICKING
    if changed & {"contact_begin", "contact_end", "impact", "transmitted"}:
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

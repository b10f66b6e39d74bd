"""What happens on a branch between two of its points, and how it is called."""

from collections import Counter
from dataclasses import dataclass

from vibsim.branches.curve.node import Node
from vibsim.orbits.returns.word import Word, changes, without_sequences

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
    """What a change of the order of events is: contacts or sticks that come or go, reversals, or the order
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

"""Events found, missed and made up, kind by kind.

A found event is a true one where it is of the same kind and near: not farther than half the way to the next
true event of that kind, so that the windows of two true events never overlap, and not farther than a quarter
of the shortest period of the motion, beyond which the blocks are doing something else.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from vibsim.evidence.verification.truths.event_matching import Event, match_events, reach
from vibsim.physics.modes import EVENT_KINDS, EVENT_NAMES


@dataclass(frozen=True)
class EventCount:
    """Events of one kind up to some instant."""

    found: int
    missed: int
    spurious: int


def _reach(events: Sequence[Event]) -> list[float]:
    """Half the time [s] from each event to the nearest of its kind at another instant: those of one kind at
    one instant are of several parts.
    """
    instants = list(dict.fromkeys(events))
    halves = dict(zip(instants, reach(instants), strict=True))
    return [halves[event] for event in events]


def count_events(
    true: Mapping[str, np.ndarray], events: Sequence[tuple[float, int]], until: float, widest: float
) -> dict[str, EventCount]:
    """Counts of the events up to `until` [s] by name of kind, for every kind that has a code.

    true : columns t [s], kind; events : (time [s], kind), ascending; widest : half width of the widest
    window [s]. The first event in a window is the true one, others in it are spurious.
    """
    truth = [
        (EVENT_NAMES[kind], Decimal(t))
        for t, kind in zip(true["t"].tolist(), true["kind"].tolist(), strict=True)
    ]
    named = [(EVENT_NAMES[kind], Decimal(t)) for t, kind in events]
    within = [min(half, widest) for half in _reach(truth)]
    matching = match_events(truth, within, named)
    hits = Counter(truth[i][0] for i, _ in matching.pairs if truth[i][1] <= until)
    missed = Counter(truth[i][0] for i in matching.missed if truth[i][1] <= until)
    spurious = Counter(named[j][0] for j in matching.spurious if named[j][1] <= until)
    return {name: EventCount(hits[name], missed[name], spurious[name]) for name in EVENT_KINDS}

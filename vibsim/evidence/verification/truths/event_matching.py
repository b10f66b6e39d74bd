"""Which events of a run are those of the truth, which are missed and which are spurious."""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from math import inf

Event = tuple[str, Decimal]  # kind, time [s]
Window = tuple[Decimal, Decimal]


@dataclass(frozen=True)
class Matching:
    """What became of two sequences of events.

    pairs : (index in the truth, index in the run); missed, spurious : indices of those without counterpart
    """

    pairs: list[tuple[int, int]]
    missed: list[int]
    spurious: list[int]


def match_events(truth: Sequence[Event], within: Sequence[float], events: Sequence[Event]) -> Matching:
    """Pair each event of the truth with one of its kind, at most `within` [s] of its own away.

    Both sequences ascend in time. Kinds are matched one by one: two events at one instant have no order.
    """
    pairs: list[tuple[int, int]] = []
    for kind in {kind for kind, _ in truth}:
        ours = [i for i, event in enumerate(truth) if event[0] == kind]
        theirs = [j for j, event in enumerate(events) if event[0] == kind]
        while ours and theirs:
            i, j = ours[0], theirs[0]
            late = events[j][1] - truth[i][1]
            if abs(late) <= within[i]:
                pairs.append((i, j))
            if late >= -within[i]:
                del ours[0]
            if late <= within[i]:
                del theirs[0]
    missed = set(range(len(truth))).difference(i for i, _ in pairs)
    spurious = set(range(len(events))).difference(j for _, j in pairs)
    return Matching(sorted(pairs), sorted(missed), sorted(spurious))


def reach(events: Sequence[Event]) -> list[float]:
    """Half the time [s] from each event to the nearest other one of its kind; infinite where it is alone."""
    near = [inf] * len(events)
    last: dict[str, int] = {}
    for i, (kind, t) in enumerate(events):
        if kind in last:
            half = float(t - events[last[kind]][1]) / 2
            near[last[kind]], near[i] = min(near[last[kind]], half), half
        last[kind] = i
    return near


def outside(events: Sequence[Event], windows: Sequence[Window]) -> list[Event]:
    """The events that lie in none of the windows."""
    return [event for event in events if not any(low <= event[1] <= high for low, high in windows)]

"""How far runs lie apart: their states, the times of their events, and where they disagree about events."""

from decimal import Decimal

from vibsim.evidence.verification.digits_runs import Run
from vibsim.evidence.verification.truths.event_matching import Event, Window, match_events, reach

KEPT = 25  # digits of a stored number
WIDENED = 4  # a touch may last some times as long as in the runs that showed it


def states_apart(truth: Run, runs: list[Run]) -> dict[str, list[float]]:
    """Largest distance of the runs from the truth, by column and instant."""
    return {
        name: [
            rounded(max(abs(run.states[name][i] - value) for run in runs)) for i, value in enumerate(column)
        ]
        for name, column in truth.states.items()
    }


def times_apart(events: list[Event], runs: list[Run]) -> list[float]:
    """Largest distance in time [s] of the runs' events from those of the truth."""
    apart, near = [Decimal(0)] * len(events), reach(events)
    for run in runs:
        for i, j in match_events(events, near, run.events).pairs:
            apart[i] = max(apart[i], abs(run.events[j][1] - events[i][1]))
    return [rounded(value) for value in apart]


def undecided_spans(truth: list[Event], runs: list[Run]) -> list[Window]:
    """Spans [s] around the touches, pairs of events, that the truth has and some run has not, or the reverse.

    Every span is as wide as the longest touch asks for: which of them are seen, and how long, is luck.
    """
    late = times_apart(truth, runs)
    touches, longest = [], Decimal(0)
    for run in runs:
        matching = match_events(truth, reach(truth), run.events)
        alone = [(truth[i][1], late[i]) for i in matching.missed]
        alone += [(run.events[j][1], 0.0) for j in matching.spurious]
        if len(alone) % 2:
            raise ValueError(f"an event without its counterpart among those at {alone}")
        alone.sort()
        for (begin, before), (end, behind) in zip(alone[::2], alone[1::2], strict=True):
            touches.append((begin, end))
            longest = max(longest, end - begin + Decimal(max(before, behind)))
    return merged([(begin - WIDENED * longest, end + WIDENED * longest) for begin, end in touches])


def merged(spans: list[Window]) -> list[Window]:
    """The same spans, those that overlap made one."""
    windows: list[Window] = []
    for low, high in sorted(spans):
        if windows and low <= windows[-1][1]:
            windows[-1] = windows[-1][0], max(high, windows[-1][1])
        else:
            windows.append((low, high))
    return [(stored_digits(low), stored_digits(high)) for low, high in windows]


def stored_digits(value: Decimal) -> Decimal:
    """`value` to the digits that are stored."""
    return Decimal(f"{value:.{KEPT - 1}e}")


def rounded(value: Decimal) -> float:
    """A distance to two digits."""
    return float(f"{value:.1e}")

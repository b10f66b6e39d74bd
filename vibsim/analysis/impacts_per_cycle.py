"""What happens in each cycle of the source: impacts, sticks, and the word that the events spell."""

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.event_rows import events_within
from vibsim.analysis.span import Span, steady_span
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.sums import mean
from vibsim.results.result import Result
from vibsim.results.windows import Window

# letter of each event in a word; c ... o is a contact, s ... g a stick, r a reversal
LETTERS = {"contact_begin": "c", "contact_end": "o", "reversal": "r", "stick_begin": "s", "stick_end": "g"}
MOST_WORDS = 8  # listed


@dataclass(frozen=True)
class Spread:
    """Distribution of a quantity: number, mean, least, median, greatest, and their unit."""

    count: int
    mean: float
    least: float
    median: float
    greatest: float
    unit: str


@dataclass(frozen=True)
class ImpactsPerCycle:
    """What happens in the cycles of the source within a span.

    Attributes
    ----------
    verdict : "every cycle", "some cycles", "no impacts" or "undecided"
    reason : in words
    cycles : whole cycles counted
    impacts, sticks : mean per cycle; None without a cycle
    impact_counts, stick_counts : number of events in a cycle -> number of such cycles
    words : the commonest words -> number of cycles, see LETTERS; "" is a cycle without events
    distinct_words : how many there are
    velocity : relative speed of the blocks at impact [m/s]; None without impacts
    """

    verdict: str
    reason: str
    span: Span
    cycles: int = 0
    impacts: float | None = None
    sticks: float | None = None
    impact_counts: dict[int, int] | None = None
    stick_counts: dict[int, int] | None = None
    words: dict[str, int] | None = None
    distinct_words: int = 0
    velocity: Spread | None = None


def count_impacts(result: Result, window: Window | None = None) -> ImpactsPerCycle:
    """Impacts and sticks per cycle within `window` [s], by default the second half of the run.

    Raises ValueError for a window outside the run.
    """
    span = steady_span(result, window)
    ends = cycle_ends(result, span.window)
    if len(ends) < 2:
        return ImpactsPerCycle("undecided", "no whole cycle of a source", span, velocity=speeds(result, span))
    words = words_of(result, ends)
    impacts, sticks = ([word.count(letter) for word in words] for letter in "cs")
    cycles, struck = len(words), sum(map(bool, impacts))
    verdict = "no impacts" if not struck else "every cycle" if struck == cycles else "some cycles"
    return ImpactsPerCycle(
        verdict,
        f"impacts in {struck} of {cycles} cycles",
        span,
        cycles,
        sum(impacts) / cycles,
        sum(sticks) / cycles,
        dict(sorted(Counter(impacts).items())),
        dict(sorted(Counter(sticks).items())),
        dict(Counter(words).most_common(MOST_WORDS)),
        len(set(words)),
        speeds(result, span),
    )


def words_of(result: Result, ends: np.ndarray) -> list[str]:
    """The word of each cycle between ascending `ends` [s]: an event at an end belongs to the next cycle."""
    letters = {EVENT_KINDS[kind]: letter for kind, letter in LETTERS.items()}
    events = events_within(result, (float(ends[0]), float(ends[-1])), "t", "kind")
    text = "".join(letters.get(kind, " ") for kind in events["kind"].tolist())
    edges = np.searchsorted(events["t"], ends, side="left").tolist()
    return [text[a:b].replace(" ", "") for a, b in pairwise(edges)]


def speeds(result: Result, span: Span) -> Spread | None:
    """|v1 - v2| at the impacts within the span; None without impacts."""
    events = events_within(result, span.window, "kind", *(name for name in ("v1", "v2") if name in result))
    begun = events["kind"] == EVENT_KINDS["contact_begin"]
    if not begun.any():
        return None
    return spread(np.abs(events["v1"] - events.get("v2", 0.0))[begun], "m/s")


def spread(values: np.ndarray, unit: str) -> Spread:
    """The distribution of at least one value."""
    least, median, greatest = (float(value) for value in np.quantile(values, [0, 0.5, 1]))
    return Spread(len(values), float(mean(values)), least, median, greatest, unit)

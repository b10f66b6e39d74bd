"""What happens in each cycle of the source: impacts, sticks, and the word that the events spell."""

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.span import Span, steady_span
from vibsim.physics.modes import EVENT_KINDS
from vibsim.results.result import Result
from vibsim.results.windows import Window, rows_within

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
    times, kinds = result.events["t"], result.events["kind"]
    text = "".join(letters.get(kind, " ") for kind in kinds.tolist())
    edges = np.searchsorted(times, ends, side="left").tolist()
    return [text[a:b].replace(" ", "") for a, b in pairwise(edges)]


def speeds(result: Result, span: Span) -> Spread | None:
    """|v1 - v2| at the impacts within the span; None without impacts."""
    rows = rows_within(result.events["t"], span.window)
    begun = result.events["kind"][rows] == EVENT_KINDS["contact_begin"]
    if not begun.any():
        return None
    v = result.events["v1"][rows][begun]
    if "v2" in result.events:
        v = v - result.events["v2"][rows][begun]
    return spread(np.abs(v), "m/s")


def spread(values: np.ndarray, unit: str) -> Spread:
    """The distribution of at least one value."""
    least, median, greatest = (float(value) for value in np.quantile(values, [0, 0.5, 1]))
    return Spread(len(values), float(values.mean()), least, median, greatest, unit)

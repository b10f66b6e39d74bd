"""What happens in each cycle of the source: impacts, sticks, and the word that the events spell."""

from collections import Counter
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from vibsim.analysis.cycles import cycle_ends
from vibsim.analysis.event_rows import events_within
from vibsim.analysis.span import Span, steady_span
from vibsim.analysis.verdicts import ImpactsVerdict, name_verdict
from vibsim.physics.arithmetic.sums import mean
from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.parts import Scene
from vibsim.results.columns import part_names
from vibsim.results.motion.closing_velocity import closing_velocities
from vibsim.results.result import Result
from vibsim.results.windows import Window

# letter of each event in a word; c ... o is a contact, s ... g a stick, r a reversal; of a rigid stop i is an
# impact, t one passed on to it, h the end of a sequence, b ... e a rest
LETTERS = {"contact_begin": "c", "contact_end": "o", "reversal": "r", "stick_begin": "s", "stick_end": "g"}
LETTERS |= {"impact": "i", "transmitted": "t", "chatter": "h", "rest_begin": "b", "rest_end": "e"}
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
    verdict : "every cycle", "some cycles", "no impacts" (of a friction "no sticks") or "undecided"
    reason : in words
    cycles : whole cycles counted
    impacts, sticks : mean per cycle; None without a cycle, and of a part that has none by its kind
    impact_counts, stick_counts : number of events in a cycle -> number of such cycles
    words : the commonest words -> number of cycles, see LETTERS; "" is a cycle without events
    distinct_words : how many there are
    velocity : relative speed of the ends of the stop at impact [m/s]; None without impacts
    """

    verdict: ImpactsVerdict | str
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

    def __post_init__(self) -> None:
        name_verdict(self, ImpactsVerdict)


def counted_parts(scene: Scene) -> tuple[str, ...]:
    """The parts whose events are counted one by one: stops and frictions where there is a stop, and more than
    one of either; none where all events are counted together.
    """
    if len(scene.stops) <= 1 and len(scene.frictions) <= 1:
        return ()
    parts: tuple[Any, ...] = (*scene.stops, *scene.frictions)
    return tuple(part.name for part in parts)


def count_impacts(result: Result, window: Window | None = None, part: str | None = None) -> ImpactsPerCycle:
    """Impacts and sticks per cycle within `window` [s], by default the second half of the run.

    part : the stop or friction whose events count; None: all events

    Raises ValueError for a window outside the run, and where there is no such part.
    """
    scene = result.case.scene()
    stops = [stop.name for stop in scene.stops]
    frictions = [friction.name for friction in scene.frictions]
    if part not in (None, *stops, *frictions):
        raise ValueError(f"part must be one of {', '.join((*stops, *frictions))}, got {part!r}")
    span = steady_span(result, window)
    ends = cycle_ends(result, span.window)
    speed = speeds(result, span, part)
    if len(ends) < 2:
        return ImpactsPerCycle("undecided", "no whole cycle of a source", span, velocity=speed)
    words = words_of(result, ends, part)
    impacts, sticks = ([sum(map(word.count, letters)) for word in words] for letters in ("ci", "s"))
    own, noun = (sticks, "sticks") if part in frictions else (impacts, "impacts")
    cycles, happened = len(words), sum(map(bool, own))
    verdict = f"no {noun}" if not happened else "every cycle" if happened == cycles else "some cycles"
    counts = ImpactsPerCycle(
        verdict,
        f"{noun} in {happened} of {cycles} cycles",
        span,
        cycles,
        sum(impacts) / cycles,
        sum(sticks) / cycles,
        dict(sorted(Counter(impacts).items())),
        dict(sorted(Counter(sticks).items())),
        dict(Counter(words).most_common(MOST_WORDS)),
        len(set(words)),
        speed,
    )
    if part in stops:
        return replace(counts, sticks=None, stick_counts=None)
    return replace(counts, impacts=None, impact_counts=None) if part in frictions else counts


def words_of(result: Result, ends: np.ndarray, part: str | None = None) -> list[str]:
    """The word of each cycle between ascending `ends` [s]: an event at an end belongs to the next cycle.

    part : whose events count; None: those of all parts
    """
    events = events_within(result, (float(ends[0]), float(ends[-1])), "t", "kind", "part")
    if part is not None:
        own = events["part"] == part_names(result.case.scene()).index(part)
        events = {name: column[own] for name, column in events.items()}
    letters = {EVENT_KINDS[kind]: letter for kind, letter in LETTERS.items()}
    text = "".join(letters.get(kind, " ") for kind in events["kind"].tolist())
    edges = np.searchsorted(events["t"], ends, side="left").tolist()
    return [text[a:b].replace(" ", "") for a, b in pairwise(edges)]


def happenings(result: Result, ends: np.ndarray) -> list[bytes]:
    """What happens in each cycle between ascending `ends` [s]: kinds and parts of the events, in order."""
    events = events_within(result, (float(ends[0]), float(ends[-1])), "t", "kind", "part")
    counted = np.isin(events["kind"], [EVENT_KINDS[kind] for kind in LETTERS])
    codes = np.stack([events["kind"], events["part"]], axis=1).astype("i4")[counted]
    edges = np.searchsorted(events["t"][counted], ends, side="left").tolist()
    return [codes[a:b].tobytes() for a, b in pairwise(edges)]


def speeds(result: Result, span: Span, part: str | None = None) -> Spread | None:
    """Relative speed |v_P - v_Q| of the ends of the stop `part`, of all stops if None, at the impacts within
    the span; None without impacts.
    """
    scene = result.case.scene()
    events = events_within(result, span.window)
    values = np.abs(closing_velocities(scene, events))
    own = np.isin(events["part"], [i for i, stop in enumerate(scene.stops) if part in (None, stop.name)])
    values = values[own & ~np.isnan(values)]
    return spread(values, "m/s") if len(values) else None


def spread(values: np.ndarray, unit: str) -> Spread:
    """The distribution of at least one value."""
    least, median, greatest = (float(value) for value in np.quantile(values, [0, 0.5, 1]))
    return Spread(len(values), float(mean(values)), least, median, greatest, unit)

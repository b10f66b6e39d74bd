"""The word of an orbit: the events of one period in their order, read as a circle."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache

import numpy as np

from vibsim.physics.formula_values import apart, gap_of, motion_of_base, motion_of_belt
from vibsim.physics.parts import Scene

Word = tuple[tuple[str, int], ...]  # kinds of events, and the parts that they happen to


LETTERS = {
    "contact_begin": "b",
    "contact_end": "e",
    "reversal": "r",
    "stick_begin": "s",
    "stick_end": "u",
    "impact": "i",
    "transmitted": "t",
    "chatter": "c",
    "rest_begin": "h",
    "rest_end": "o",
}
TOGETHER = 1e-12  # of the period, between events of one kind at different parts
NEAR = 1e-3  # the same of events that may come together although slowness keeps their times apart
STICKS = ("stick_begin", "stick_end")
OF_FRICTION = ("reversal", "stick_begin", "stick_end")


def word_of(events: Iterable[tuple[str, int]]) -> Word:
    """The events that make an orbit's word: all but those that exert no force (limits that are watched)."""
    return tuple((kind, part) for kind, part in events if kind in LETTERS)


def in_order(
    events: Sequence[tuple[str, int]],
    times: Sequence[float],
    period: float,
    at_once: Callable[[int], bool],
) -> list[tuple[str, int]]:
    """Events with those of one kind that come together, as where bodies move alike, in the order of their
    parts: rounding would else say which is first.

    at_once : whether an event of the same kind as the one before it, at another part, is due with that; it is
        asked where their times are not the same but near
    """
    ordered, begin = list(events), 0
    for i in range(1, len(ordered) + 1):
        together = i < len(events) and events[i][0] == events[i - 1][0]
        if together:
            apart = (times[i] - times[i - 1]) / period
            together = apart <= TOGETHER or (apart <= NEAR and events[i] != events[i - 1] and at_once(i))
        if not together:
            ordered[begin:i] = sorted(ordered[begin:i])
            begin = i
    return ordered


def counted(events: Sequence[tuple[str, int]]) -> list[bool]:
    """For each event of a circle, whether its word has it: all but the impacts that a chatter ends, and the
    slips that each of them begins and that end before the next.

    There are infinitely many of them; how many are told one by one depends on rounding alone, and that number
    changes along a branch without anything happening.
    """
    kept, ending = [True] * len(events), set[int]()
    slips: list[int] = []  # behind the impact that is looked for
    for i in reversed(range(-len(events), len(events))):  # twice round: the section may cut a sequence
        kind, part = events[i]
        if kind == "chatter":
            ending, slips = {part}, []
        elif kind == "impact" and part in ending and _over([events[j] for j in reversed(slips)]):
            for j in (i, *slips):
                kept[j] = False
            slips = []
        elif kind in STICKS:
            slips.append(i)
        else:
            ending = set()
    return kept


def without_sequences(word: Word) -> Word:
    """A word without the impacts that a chatter brings to an end, and what sticks and slips among them."""
    kept, ending = [True] * len(word), set[int]()
    for i in reversed(range(-len(word), len(word))):
        kind, part = word[i]
        if kind == "chatter":
            ending = {part}
        elif (kind == "impact" and part in ending) or (kind in STICKS and ending):
            kept[i] = False
        else:
            ending = set()
    return tuple(event for event, told in zip(word, kept, strict=True) if told)


def without_landings(word: Word) -> Word:
    """A word without the impacts after which bodies rest at once.

    The speed of such an impact is rounding where the flight before it has just begun: then the engine has the
    bodies rest without one.
    """
    following = word[1:] + word[:1]
    return cyclic(
        tuple(
            (kind, part)
            for (kind, part), after in zip(word, following, strict=True)
            if not (kind == "impact" and after == ("rest_begin", part))
        )
    )


def _over(slips: Iterable[tuple[str, int]]) -> bool:
    """Whether slips among ends and beginnings of stick phases all begin and end among them."""
    sliding = set[int]()
    for kind, part in slips:
        if (kind == "stick_end") == (part in sliding):
            return False
        sliding ^= {part}
    return not sliding


def circle(events: Word) -> Word:
    """The word of the events of one period, wherever the section cuts it."""
    if any(kind == "chatter" for kind, _ in events):
        events = tuple(event for event, told in zip(events, counted(events), strict=True) if told)
    return cyclic(events)


@lru_cache(maxsize=4096)
def cyclic(word: Word) -> Word:
    """The least of all rotations of a word: orbits are compared by it, wherever the section cuts them."""
    doubled = word + word
    return min((doubled[i : i + len(word)] for i in range(len(word))), default=word)


def changes(before: Word, after: Word) -> tuple[Counter[tuple[str, int]], Counter[tuple[str, int]]]:
    """The events that a word has more often than another, and those that it has less often."""
    one, other = Counter(before), Counter(after)
    return one - other, other - one


def spelled(scene: Scene, word: Word) -> str:
    """A word in letters, e.g. "rbre"; where a scene has several stops or frictions, with the number of the
    part behind each letter, e.g. "b1 r2 e1 r2".
    """
    numbered = {True: len(scene.frictions) > 1, False: len(scene.stops) > 1}
    letters = [
        LETTERS[kind] + (str(part + 1) if numbered[kind in OF_FRICTION] else "") for kind, part in word
    ]
    return (" " if any(numbered.values()) else "").join(letters)


# Events that are due at once.


ROUNDING = 2e-12  # of the size of a motion: what rounding and Newton's method leave of a gap that is zero
OF_STOPS = ("contact_begin", "contact_end", "impact", "transmitted")


def at_once(scene: Scene, kind: str, part: int, t: float, state: np.ndarray) -> bool:
    """Whether an event of a kind at a part is due at the time t [s] of another but for rounding: its gap, or
    its sliding velocity, is zero to a share of the displacements, or velocities, there.
    """
    n = len(scene.bodies)
    if kind in OF_STOPS:
        gap = gap_of(scene, part, t, state)[0]
        return bool(abs(gap) <= ROUNDING * max(abs(state[:n]).max(), abs(scene.stops[part].gap)))
    if kind in OF_FRICTION:
        friction = scene.frictions[part]
        slip = apart(friction, state[n:], motion_of_base(scene, t)[1]) - motion_of_belt(friction, t)[0]
        return bool(abs(slip) <= ROUNDING * max(abs(state[n : 2 * n]).max(), abs(friction.belt)))
    return False

"""What an event leads to: the mode behind it, what is told of it, and what is zero there."""

from __future__ import annotations

from vibsim.engine.modes.rows import SLIDE, STRIKE, Known
from vibsim.engine.modes.status import OPEN, RESTING, STICK, Status

Happened = list[tuple[str, int]]  # kinds of events by name, and the parts that they happen to
Taken = tuple[Status, Happened, Known]  # the mode behind an event, what happened, and what is zero there


def changes(before: Status, after: Status, known: Known) -> Happened:
    """Events of frictions and rigid stops whose status differs; adds the zeros of those that begin to
    slip or part to `known`.
    """
    happened: Happened = []
    for i, (old, new) in enumerate(zip(before.frictions, after.frictions, strict=True)):
        if new != STICK and new != old:
            known.setdefault((SLIDE, i), 1)
            happened.append(("stick_end" if old == STICK else "reversal", i))
        elif new != old:
            happened.append(("stick_begin", i))
    for i, (old, new) in enumerate(zip(before.stops, after.stops, strict=True)):
        if (old, new) == (RESTING, OPEN):
            known[STRIKE, i] = 2
            happened.append(("rest_end", i))
        elif (old, new) == (OPEN, RESTING):
            happened.append(("rest_begin", i))
    return happened

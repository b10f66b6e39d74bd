"""Records of an event: the mode behind it, what is reported of it, and what is zero there."""

from __future__ import annotations

from math import inf

from vibsim.engine.modes.rows import SLIDE, STRIKE, Known
from vibsim.engine.modes.status import OPEN, RESTING, STICK, Status
from vibsim.physics.numbers import Kit, N

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


# What rounding leaves open of times and sums at a rigid stop.


NEXT, LAST = 2, 8  # units in the last place of the time
ROUNDING = 8  # of a sum or a difference of two numbers, in units of eps


def unit_of(kit: Kit[N], t: N) -> N:
    """One unit in the last place of a time [s]."""
    return kit.next_after(t, inf) - t

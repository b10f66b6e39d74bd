"""Records of an event: the mode behind it, what is reported of it, and what is zero there."""

from __future__ import annotations

from math import inf
from typing import Generic

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


# What a run has proved about its events, and how close it came to one more.
#
# A stretch between two events is certified where every event function is known to stay positive on it, by
# more than the bound of its rounding and truncation. An event is certified where its function is known to
# cross zero, by more than that bound too. Of two events, the first is certified to be the first where their
# times are further apart than rounding blurs them. All else is a doubt: counted, and the first one timed.


class Certificate(Generic[N]):
    """Doubts of a run, and its grazing margin: the smallest gap [m] at a turn of the gap function."""

    def __init__(self, kit: Kit[N]) -> None:
        self.margin, self.margin_time = kit.inf, kit.number(0)
        self.uncertified, self.first_doubt = 0, kit.number(0)
        self.doubted: N | None = None

    def doubt(self, anchor: N) -> None:
        """Count the stretch that starts at time `anchor` as not proved, once."""
        if anchor != self.doubted:
            if self.uncertified == 0:
                self.first_doubt = anchor
            self.uncertified += 1
            self.doubted = anchor

    def keep_turn(self, value: N, t: N) -> None:
        """Keep a minimum of the gap function, of height `value` [m] at time `t` [s]."""
        value = value if value > 0 else 0 * value
        if value < self.margin:
            self.margin, self.margin_time = value, t


def crosses(slope: N, bound: N, error: N) -> bool:
    """Whether a function that is zero here with this slope falls below -error: its upper parabola does,
    which is lowest, at -slope^2 / (2 bound), where its slope is zero.

    bound: on its absolute second derivative ahead. A touch from above by less than `error` does not.
    """
    return slope < 0 and -slope > 2 * bound * (error / -slope)

"""What rounding leaves open of times and sums at a rigid stop."""

from __future__ import annotations

from math import inf

from vibsim.physics.arithmetic.numbers import Kit, N

NEXT, LAST = 2, 8  # units in the last place of the time
ROUNDING = 8  # of a sum or a difference of two numbers, in units of eps


def unit_of(kit: Kit[N], t: N) -> N:
    """One unit in the last place of a time [s]."""
    return kit.next_after(t, inf) - t

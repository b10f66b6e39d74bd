"""What C is told of an event beforehand: the mode behind it, where that is simple."""

from typing import NamedTuple

from vibsim.engine.modes.rows import EventKey
from vibsim.engine.modes.status import Status

ASK, CROSS, STAND, STRUCK, BEAR = range(5)  # kinds of rules, as in rules.c; ASK: Python decides


class Rule(NamedTuple):
    """A rule of one event of a mode.

    target : the mode behind it; other : of STAND, the mode where HOLD event number `hold` of the target is
        overloaded; None and -1 where there is none
    happened, part : kind of the event by name, and the part that it happens to
    key, order : of the event function that is zero behind it
    """

    kind: int
    target: Status
    other: Status | None
    hold: int
    happened: str
    part: int
    key: EventKey
    order: int

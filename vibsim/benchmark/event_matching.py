"""Events found, missed and made up: two tables of events compared, kind by kind.

A found event is a true one where it is of the same kind and near: not farther than half the way to the next
true event of that kind, so that the windows of two true events never overlap, and not farther than a quarter
of the shortest period of the motion, beyond which the blocks are doing something else.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vibsim.physics.modes import EVENT_KINDS


@dataclass(frozen=True)
class EventCount:
    """Events of one kind up to some instant."""

    found: int
    missed: int
    spurious: int


def count_events(
    true: Mapping[str, np.ndarray], events: Sequence[tuple[float, int]], until: float, widest: float
) -> dict[str, EventCount]:
    """Counts of the events up to `until` [s] by name of kind, for every kind that has a code.

    true : columns t [s], kind; events : (time [s], kind); widest : half width of the widest window [s]
    """
    times = np.array([t for t, _ in events], dtype="f8")
    codes = np.array([kind for _, kind in events], dtype="i8")
    return {
        name: match_times(true["t"][true["kind"] == code], np.sort(times[codes == code]), until, widest)
        for name, code in EVENT_KINDS.items()
    }


def match_times(true: np.ndarray, found: np.ndarray, until: float, widest: float) -> EventCount:
    """Count ascending times [s] of one kind. The first event in a window is the true one, others in it are
    spurious, and so are those outside all windows.
    """
    windows = half_widths(true, widest)
    first = np.searchsorted(found, true - windows, side="left")
    behind = np.searchsorted(found, true + windows, side="left")
    hit = behind > first
    matched = np.zeros(len(found), dtype=bool)
    matched[first[hit]] = True
    inside = true <= until
    return EventCount(
        found=int(np.count_nonzero(hit & inside)),
        missed=int(np.count_nonzero(~hit & inside)),
        spurious=int(np.count_nonzero(~matched & (found <= until))),
    )


def half_widths(true: np.ndarray, widest: float) -> np.ndarray:
    """Half width of the window of each true event [s]."""
    apart = np.diff(true, prepend=-np.inf, append=np.inf)
    return np.minimum(np.minimum(apart[:-1], apart[1:]) / 2, widest)

"""By how much a companion is too near: told by a third run, where the distance has grown.

A run and its companion may share the error in the direction that grows, and then the distance is too small
from there on. Where it has grown by four decades it lies in that direction: if a third run lies further away
there, the distance is multiplied by as much behind it. To be far too low by bad luck takes two runs that
share the error of the first.
"""

from collections.abc import Callable

import numpy as np

GROWN = 1e4  # of a distance by its rounding, where the third run is asked
WINDOW = 16  # samples at which it is
MOST = 2.0**200  # of a factor: nothing is known
# displacements [m] of the third run, shape (bodies, last), as third(count, last, until): at the `last` of its
# first `count` samples, which end at the time `until` [s]. NaN where it has failed, infinite where nothing
# will be known of it. Raises NotYet
Third = Callable[[int, int, float], np.ndarray]
Window = list[tuple[np.ndarray, np.ndarray]]  # the run at these samples, and its distances


class NotYet(Exception):
    """The third run has not come so far; who asks may ask again."""


class Share:
    """What to multiply distances by, sample after sample, wherever the blocks of samples begin and end."""

    def __init__(self) -> None:
        self._count = 0  # of the samples so far
        self._asked: int | None = None  # number of the first sample at which the third run is asked
        self._window: Window = []
        self._share: float | None = None  # at least 1

    def of(
        self,
        time: np.ndarray,
        ours: np.ndarray,
        apart: np.ndarray,
        distance: np.ndarray,
        rounding: np.ndarray,
        third: Third,
    ) -> np.ndarray | None:
        """The factors at the next samples; None where all are 1. Where the third run raises NotYet, all is as
        it was.

        ours, apart : displacements of the run (bodies, samples), its distances to the companion; distance :
        the same, held; rounding : of it, all [m]
        """
        begin, asked, window = self._count, self._asked, self._window
        if asked is None:
            grown = distance > GROWN * rounding
            if not grown.any():
                self._count += len(time)
                return None
            asked = begin + int(np.argmax(grown))
        low, high = max(asked - begin, 0), asked + WINDOW - begin
        if self._share is None:
            window = [*window, (ours[:, low:high], apart[low:high])]
            if high <= len(time):
                self._share = compared(window, third(begin + high, WINDOW, float(time[high - 1])))
        self._count, self._asked, self._window = begin + len(time), asked, window
        if self._share is None:
            return None
        self._window = []
        return np.where(np.arange(len(time)) >= high, self._share, 1.0) if self._share > 1 else None


def compared(window: Window, theirs: np.ndarray) -> float:
    """How much further away the third run is than the companion, at least 1; 1 where it has failed."""
    ours, apart = (np.concatenate(parts, axis=-1) for parts in zip(*window, strict=True))
    share = float(np.abs(ours - theirs).max() / apart.max())
    return min(share, MOST) if share > 1 else 1.0

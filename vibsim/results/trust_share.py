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
# displacements [m] of the third run, shape (bodies, last), as third(count, last, until): at the `last` of its
# first `count` samples, which end at the time `until` [s]
Third = Callable[[int, int, float], np.ndarray]


class Share:
    """What to multiply distances by, sample after sample, wherever the blocks of samples begin and end."""

    def __init__(self) -> None:
        self._count = 0  # of the samples so far
        self._asked: int | None = None  # number of the first sample at which the third run is asked
        self._window: list[tuple[np.ndarray, np.ndarray]] = []  # the run there, and its distances
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
        """The factors at the next samples; None where all are 1.

        ours, apart : displacements of the run (bodies, samples), its distances to the companion; distance :
        the same, held; rounding : of it, all [m]
        """
        begin, self._count = self._count, self._count + len(time)
        if self._asked is None:
            grown = distance > GROWN * rounding
            if not grown.any():
                return None
            self._asked = begin + int(np.argmax(grown))
        low, high = max(self._asked - begin, 0), self._asked + WINDOW - begin
        if self._share is None:
            self._window.append((ours[:, low:high], apart[low:high]))
            if high > len(time):
                return None
            self._share = self._compared(third(begin + high, WINDOW, float(time[high - 1])))
        return np.where(np.arange(len(time)) >= high, self._share, 1.0) if self._share > 1 else None

    def _compared(self, theirs: np.ndarray) -> float:
        """How much further away the third run is than the companion, at least 1; 1 where it has failed."""
        ours, apart = (np.concatenate(parts, axis=-1) for parts in zip(*self._window, strict=True))
        self._window = []
        share = float(np.abs(ours - theirs).max() / apart.max())
        return share if share > 1 else 1.0

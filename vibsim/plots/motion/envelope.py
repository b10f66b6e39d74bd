"""Long series reduced to what a picture can show, without losing an extreme.

Of all samples that fall into one pixel column, a drawn line shows the first, the least, the greatest and the
last; the others cannot be seen. Keeping those four (the M4 aggregation, Jugel, Jerzak, Hackenbroich and
Markl, "M4: a visualization-oriented time series data aggregation", PVLDB 7, 2014) leaves the picture as it
was.
"""

from __future__ import annotations

import numpy as np

FIRST, LEAST, GREATEST, LAST = range(4)


class Envelope:
    """First, least, greatest and last sample of every pixel column, fed block by block.

    Parameters
    ----------
    start, stop : the span of the axis [s]
    columns : number of pixel columns across it

    Memory is 8 numbers per column, whatever the length of the series.
    """

    def __init__(self, start: float, stop: float, columns: int) -> None:
        self._start, self._columns = start, columns
        self._per_second = columns / (stop - start) if stop > start else 0.0
        self._t = np.full((columns, 4), np.nan)
        self._value = np.full((columns, 4), np.nan)

    def add(self, t: np.ndarray, values: np.ndarray) -> None:
        """Take in the next samples: ascending instants t (n) [s] and values (n)."""
        column = np.clip(((t - self._start) * self._per_second).astype(np.int64), 0, self._columns - 1)
        first = np.flatnonzero(np.diff(column, prepend=-1))
        for begin, end in zip(first, [*first[1:], len(t)], strict=True):
            self._merge(int(column[begin]), t[begin:end], values[begin:end])

    def _merge(self, column: int, t: np.ndarray, values: np.ndarray) -> None:
        kept_t, merged = self._t[column], self._value[column]
        rows = (0, int(np.argmin(values)), int(np.argmax(values)), len(t) - 1)
        fresh = np.isnan(kept_t[FIRST])
        replace = (
            fresh,
            fresh or values[rows[LEAST]] < merged[LEAST],
            fresh or values[rows[GREATEST]] > merged[GREATEST],
            True,
        )
        for which, row in enumerate(rows):
            if replace[which]:
                kept_t[which], merged[which] = t[row], values[row]

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """The samples kept, (t, values), in ascending time and without repetition."""
        filled = ~np.isnan(self._t[:, FIRST])
        t, order = self._t[filled], np.argsort(self._t[filled], axis=1, kind="stable")
        t = np.take_along_axis(t, order, axis=1).ravel()
        values = np.take_along_axis(self._value[filled], order, axis=1).ravel()
        distinct = np.diff(t, prepend=-np.inf) > 0
        return t[distinct], values[distinct]

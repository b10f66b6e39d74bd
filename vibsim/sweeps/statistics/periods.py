"""Peak-to-peak displacements of each excitation period, gathered stretch by stretch."""

import numpy as np


class PeriodExtremes:
    """Peak-to-peak of every whole period, from one stroboscopic point to the next, both included.

    Memory grows by one number per period and quantity, not with the number of rows.
    """

    def __init__(self, quantities: int):
        self.low = np.full(quantities, np.inf)  # over everything so far
        self.high = np.full(quantities, -np.inf)
        self._open: tuple[np.ndarray, np.ndarray] | None = None  # extremes of the period that has begun
        self._closed: list[np.ndarray] = []

    def add(self, rows: np.ndarray, low: np.ndarray, high: np.ndarray, section: np.ndarray) -> None:
        """Take the next rows, of which the first follows on what was taken before.

        Parameters
        ----------
        rows : displacements of the rows (quantities, n)
        low, high : least and greatest from each row to before the next, of the same shape
        section : positions of the rows that end a period and begin the next, ascending
        """
        ends = rows[:, section]
        lows, highs = _pieces(np.minimum, low, ends, section), _pieces(np.maximum, high, ends, section)
        self.low, self.high = np.minimum(self.low, lows.min(axis=1)), np.maximum(self.high, highs.max(axis=1))
        if self._open is not None:
            lows[:, 0] = np.minimum(self._open[0], lows[:, 0])
            highs[:, 0] = np.maximum(self._open[1], highs[:, 0])
        if self._open is not None or len(section):
            whole = slice(0 if self._open is not None else 1, -1)
            self._closed.append(highs[:, whole] - lows[:, whole])
            self._open = lows[:, -1], highs[:, -1]

    def peak_to_peak(self) -> np.ndarray:
        """Of each whole period (quantities, periods); of everything (quantities, 1) where there is none."""
        closed = np.concatenate([np.empty((len(self.low), 0)), *self._closed], axis=1)
        return closed if closed.shape[1] else (self.high - self.low)[:, np.newaxis]


def _pieces(extreme: np.ufunc, values: np.ndarray, ends: np.ndarray, section: np.ndarray) -> np.ndarray:
    """Extreme up to the first section, then from each to the next: (quantities, sections + 1)."""
    pieces = extreme.reduceat(values, [0, *section], axis=1)
    if len(section) and section[0] == 0:
        pieces[:, 0] = ends[:, 0]  # reduceat takes an empty piece for its first element
    pieces[:, :-1] = extreme(pieces[:, :-1], ends)
    return pieces

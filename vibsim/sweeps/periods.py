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

    def add(self, low: np.ndarray, high: np.ndarray, section: np.ndarray) -> None:
        """Take the next rows: least and greatest value from each row to the next, (quantities, n) each.

        section : the rows that begin a period, ascending; the first row follows on what was taken before
        """
        lows, highs = _pieces(np.minimum, low, section), _pieces(np.maximum, high, section)
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


def _pieces(extreme: np.ufunc, values: np.ndarray, section: np.ndarray) -> np.ndarray:
    """Extreme up to the first section, then from each section to the next: (quantities, len(section) + 1)."""
    pieces = extreme.reduceat(values, [0, *section], axis=1)
    pieces[:, :-1] = extreme(pieces[:, :-1], values[:, section])  # the row that ends a piece belongs to it
    return pieces

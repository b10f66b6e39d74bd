"""Long portraits reduced to one sample per pixel."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

Blocks = Callable[[], Iterable[tuple[np.ndarray, np.ndarray]]]


def one_per_pixel(blocks: Blocks, pixels: tuple[int, int] = (1200, 900)) -> tuple[np.ndarray, np.ndarray]:
    """The first sample (x, y) to fall into each pixel of the picture, of a series too long to draw.

    Parameters
    ----------
    blocks : called twice, yields the series block by block as (x, y), each (n)
    pixels : size of the grid laid over the range of the data

    Every point returned is a sample, and no sample lies farther than one pixel from a point returned.
    """
    x_low, x_span, y_low, y_span = _range(blocks)
    wide, high = pixels
    painted = np.zeros(wide * high, dtype=bool)
    kept_x, kept_y = [], []
    for x, y in blocks():
        column = np.minimum(((x - x_low) / x_span * wide).astype(np.int64), wide - 1)
        row = np.minimum(((y - y_low) / y_span * high).astype(np.int64), high - 1)
        pixel, first = np.unique(row * wide + column, return_index=True)
        first = first[~painted[pixel]]
        painted[pixel] = True
        kept_x.append(x[first])
        kept_y.append(y[first])
    return np.concatenate(kept_x), np.concatenate(kept_y)


def _range(blocks: Blocks) -> tuple[float, float, float, float]:
    x_low = y_low = np.inf
    x_high = y_high = -np.inf
    for x, y in blocks():
        x_low, x_high = min(x_low, x.min()), max(x_high, x.max())
        y_low, y_high = min(y_low, y.min()), max(y_high, y.max())
    return x_low, (x_high - x_low) or 1.0, y_low, (y_high - y_low) or 1.0

"""Does the next point of a section follow from the last one?

Of a deterministic motion, points that lie close are followed by points that lie close; of noise, by any. The
measure is the error of predicting each point by what followed the nearest neighbour of the one before it,
relative to the error of guessing.
"""

import numpy as np

from vibsim.physics.arithmetic.sums import total

APART = 5  # points between neighbours, at least: those next to each other in time say nothing
MOST = 2000  # points looked at, the last ones
PIECE = 500  # points whose distances are worked out at a time


def prediction_error(points: np.ndarray) -> float:
    """Median error of prediction over the median distance of any two points: near 0, or 1 for noise.

    points : (n, d); nan where there are too few, or all are the same
    """
    points = points[-MOST:]
    count = len(points) - 1
    if count < 4 * APART:
        return float("nan")
    following = points[1:]
    neighbours = np.concatenate([_nearest(points[:-1], start) for start in range(0, count, PIECE)])
    errors = _lengths(following - following[neighbours])
    shuffled = np.roll(following, count // 2, axis=0)
    guess = float(np.median(_lengths(following - shuffled)))
    return float(np.median(errors)) / guess if guess else float("nan")


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Euclidean lengths of vectors (n, d)."""
    return np.asarray(np.sqrt(total(vectors * vectors)))


def _nearest(points: np.ndarray, start: int) -> np.ndarray:
    """Positions of the nearest neighbours of a piece of the points."""
    piece = points[start : start + PIECE]
    squares = sum(np.subtract.outer(piece[:, i], points[:, i]) ** 2 for i in range(points.shape[1]))
    places = np.arange(start, start + len(piece))
    squares[np.abs(places[:, np.newaxis] - np.arange(len(points))[np.newaxis, :]) < APART] = np.inf
    return np.asarray(np.argmin(squares, axis=1))

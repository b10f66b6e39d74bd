"""The 0-1 test for chaos: K near 1 for a chaotic series, near 0 for a regular one.

Gottwald and Melbourne, "On the implementation of the 0-1 test for chaos", SIAM J. Appl. Dyn. Syst. 8 (2009)
129: the modified mean square displacement, the correlation method, and the median over many frequencies c.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vibsim.physics.elementary import dot, mean, sine_cosine_of_arrays, total

FREQUENCIES = 100
LOWEST, HIGHEST = np.pi / 5, 4 * np.pi / 5  # of c; nearer to 0 and pi lie resonances of every series
SHARE = 10  # displacements over up to 1/10 of the series
GOLDEN = (np.sqrt(5) - 1) / 2


def zero_one(series: np.ndarray) -> float:
    """K of a series (n) sampled so far apart that neighbours are not alike; nan for a constant one.

    For each c the path p + iq = sum of phi_j exp(i c j) is formed, then its mean square displacement M over n
    steps, then D = M less the oscillating part (mean phi)^2 (1 - cos nc)/(1 - cos c). D grows with n where
    the path diffuses, as under chaos, and stays bounded else: K is the correlation of D with n.
    """
    series = np.asarray(series, dtype=float)
    spread = float(np.ptp(series))
    if not spread:
        return float("nan")
    series = (series - series.min()) / spread
    steps = np.arange(1, max(2, len(series) // SHARE) + 1)
    c = frequencies()[:, np.newaxis]
    sine, cosine = sine_cosine_of_arrays(c * np.arange(1, len(series) + 1))
    p, q = np.cumsum(series * cosine, axis=1), np.cumsum(series * sine, axis=1)
    oscillating = mean(series) ** 2 * (1 - cosine[:, steps - 1]) / (1 - cosine[:, :1])
    return float(np.median(correlations(steps, square_displacements(p, q, steps) - oscillating)))


def frequencies() -> np.ndarray:
    """Values of c that fill the range evenly and are no fractions of pi."""
    places = (0.5 + GOLDEN * np.arange(FREQUENCIES)) % 1.0
    return np.asarray(LOWEST + (HIGHEST - LOWEST) * places)


def square_displacements(p: np.ndarray, q: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Mean of (p[j + n] - p[j])^2 + (q[j + n] - q[j])^2 over the first j, for the n of `steps` (m).

    p, q (k, count); result (k, m), the same j for all n. (b - a)^2 = b^2 + a^2 - 2 a b: sums, and Fourier
    transforms for the products.
    """
    count = p.shape[1]
    starts = count - int(steps[-1])
    products = _lagged_products(p, starts, steps) + _lagged_products(q, starts, steps)
    sums = np.cumsum(p * p + q * q, axis=1)
    later = sums[:, steps + starts - 1] - sums[:, steps - 1]
    return np.asarray((later + sums[:, starts - 1 : starts] - 2 * products) / starts)


def _lagged_products(x: np.ndarray, starts: int, steps: np.ndarray) -> np.ndarray:
    """Sums of x[j] x[j + n] over the first `starts` j, for the n of `steps`: (k, m).

    Complex numbers are multiplied in parts: numpy's own products round differently on processors with FMA.
    """
    length = 2 ** (x.shape[1] + starts).bit_length()
    first, whole = np.fft.rfft(x[:, :starts], length), np.fft.rfft(x, length)
    spectrum = np.empty_like(whole)
    spectrum.real = first.real * whole.real + first.imag * whole.imag
    spectrum.imag = first.real * whole.imag - first.imag * whole.real
    return np.fft.irfft(spectrum, length)[:, steps]


def correlations(steps: np.ndarray, displacements: np.ndarray) -> np.ndarray:
    """Correlation coefficient with the steps (m) of each row (k, m); 0 where nothing moves."""
    a = steps - mean(steps)
    b = displacements - mean(displacements)[:, np.newaxis]
    size = np.sqrt(dot(a, a) * dot(b, b))
    return np.asarray(np.divide(dot(b, a), size, out=np.zeros(len(b)), where=size > 0))


# Does a section repeat itself after k points, since when, and is it still on its way there?


TOLERANCE = 1e-3  # of the vibration, within which points are the same
EXACT = 1e-8  # closer than this, no trend can be asked of rounding errors
LONGEST = 64  # period looked for
REPEATS, LEAST = 5, 40  # how often a period must have been seen, and for how many points
ALL = 200  # so many points that all repeat themselves need no trend
SHRINKS = 0.7  # ratio of later to earlier steps of a motion that settles
MOSTLY = 0.9  # of the steps: chance brings some points of any motion close together
NEAR = 0.03  # steps of a motion that may be said to approach a period


@dataclass(frozen=True)
class Recurrence:
    """A section that repeats itself, or comes closer to it.

    Attributes
    ----------
    period : points after which it does
    onset : position of the first point from which on it does, within TOLERANCE
    step : distance of points a period apart that 9 in 10 keep within, over the last quarter
    trend : that distance over the one in the first quarter
    steady : whether it falls from each quarter to the next
    """

    period: int
    onset: int
    step: float
    trend: float
    steady: bool


def find_period(points: np.ndarray) -> Recurrence | None:
    """The shortest period of the points (n, d) that has lasted up to the last of them; None: there is none.

    From the onset on, all points a multiple of the period apart lie within TOLERANCE of the last of them,
    and they come closer to each other, or lie within EXACT: a slow drift along a curve is no period.
    And no shorter period is being approached: a spiral into a fixed point comes near itself after some turns.
    """
    for period in _periods(points):
        onset = onset_of(points, period)
        if len(points) - onset < max(LEAST, REPEATS * period):
            continue
        return_distance = recurrence(points, period, onset)
        exact = distance_to_last(points[onset:], period).max() <= EXACT
        if exact or (onset == 0 and len(points) >= ALL):
            return return_distance
        if return_distance.trend <= SHRINKS:
            shorter = approached_period(points[onset:])
            return return_distance if shorter is None or shorter.period >= period else None
    return None


def approached_period(points: np.ndarray) -> Recurrence | None:
    """The shortest period of which the points come closer to being; None: of none."""
    for period in _periods(points):
        return_distance = recurrence(points, period, 0)
        if return_distance.step <= NEAR and return_distance.trend <= SHRINKS and return_distance.steady:
            return return_distance
    return None


def _periods(points: np.ndarray) -> range:
    return range(1, min(LONGEST, len(points) // REPEATS) + 1)


def distance_to_last(points: np.ndarray, period: int) -> np.ndarray:
    """Greatest difference of each point (n) from the last one that is a multiple of the period after it."""
    last = points[len(points) - period :]
    place = (np.arange(len(points)) - len(points)) % period
    return np.asarray(np.abs(points - last[place]).max(axis=1))


def onset_of(points: np.ndarray, period: int) -> int:
    """Position from which on all points lie within TOLERANCE of the last one of their place."""
    apart = np.flatnonzero(~(distance_to_last(points, period) <= TOLERANCE))
    return int(apart[-1]) + 1 if len(apart) else 0


def recurrence(points: np.ndarray, period: int, onset: int) -> Recurrence:
    """How far points from the onset on and a period apart are from each other, and whether less and less."""
    stretch = points[onset:]
    steps = np.abs(stretch[period:] - stretch[:-period]).max(axis=1)
    quarters = [float(np.quantile(part, MOSTLY)) for part in np.array_split(steps, 4) if len(part)]
    steady = all(later < earlier for earlier, later in pairwise(quarters))
    before, after = quarters[0], quarters[-1]
    return Recurrence(period, onset, after, after / before if before else 1.0, steady)


# Does the next point of a section follow from the last one?
#
# Of a deterministic motion, points that lie close are followed by points that lie close; of noise, by any.
# The measure is the error of predicting each point by what followed the nearest neighbour of the one before
# it, relative to the error of guessing.


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

"""Does a section repeat itself after k points, since when, and is it still on its way there?"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

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

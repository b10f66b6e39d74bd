"""What the members of an ensemble have in common: means and quantiles, and probabilities with intervals."""

from dataclasses import dataclass

import numpy as np

from vibsim.physics.arithmetic.sums import total

CONFIDENT = 1.959963984540054  # standard deviations either side that hold 95 % of a normal distribution


@dataclass(frozen=True)
class Summary:
    """A statistic over the members, arrays over what is left of the sweep; NaN where no member has it.

    Attributes
    ----------
    count : members that have it
    mean, deviation : mean and standard deviation (of a sample, so NaN for fewer than two members)
    least, median, greatest : quantiles
    """

    count: np.ndarray
    mean: np.ndarray
    deviation: np.ndarray
    least: np.ndarray
    median: np.ndarray
    greatest: np.ndarray


@dataclass(frozen=True)
class Share:
    """A probability, estimated as a share of members.

    Attributes
    ----------
    count : members that count
    estimate : share of them; NaN for none
    low, high : Wilson's interval of 95 %, which holds for shares near 0 and 1 and for few members too
    """

    count: np.ndarray
    estimate: np.ndarray
    low: np.ndarray
    high: np.ndarray


def summary(values: np.ndarray, dimension: int) -> Summary:
    """Sum up `values` along a dimension; NaN does not count."""
    known = ~np.isnan(values)
    count = known.sum(axis=dimension)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = _along(np.where(known, values, 0.0), dimension) / count
        apart = np.where(known, values - np.expand_dims(mean, dimension), 0.0)
        deviation = np.sqrt(_along(apart * apart, dimension) / np.where(count > 1, count - 1, np.nan))
    ordered = np.sort(values, axis=dimension)  # NaN last
    return Summary(
        count, mean, deviation, *(_quantile(ordered, count, dimension, q) for q in (0.0, 0.5, 1.0))
    )


def quantile(values: np.ndarray, dimension: int, q: float) -> np.ndarray:
    """The q-quantile of `values` along a dimension, linear between members; NaN does not count."""
    count = (~np.isnan(values)).sum(axis=dimension)
    return _quantile(np.sort(values, axis=dimension), count, dimension, q)


def _along(values: np.ndarray, dimension: int) -> np.ndarray:
    """Sum along a dimension."""
    return total(np.moveaxis(values, dimension, -1))


def _quantile(ordered: np.ndarray, count: np.ndarray, dimension: int, q: float) -> np.ndarray:
    """Quantile of the first `count` along the dimension, linear between members."""
    place = q * np.maximum(count - 1, 0)
    ends = [np.expand_dims(edge(place).astype(int), dimension) for edge in (np.floor, np.ceil)]
    low, high = (np.take_along_axis(ordered, end, dimension).squeeze(dimension) for end in ends)
    return np.asarray(low + (place - np.floor(place)) * (high - low))


def share(condition: np.ndarray, counts: np.ndarray, dimension: int) -> Share:
    """Share of those that count for which a condition holds, along a dimension; both of one shape, boolean.

    Wilson (1927): centre (p + z^2/2n) / (1 + z^2/n), half width z sqrt(p (1 - p)/n + z^2/4n^2) / (1 + z^2/n).
    """
    n = counts.sum(axis=dimension)
    with np.errstate(invalid="ignore", divide="ignore"):
        p = (condition & counts).sum(axis=dimension) / n
        squared = CONFIDENT * CONFIDENT / n
        centre = (p + squared / 2) / (1 + squared)
        half = CONFIDENT * np.sqrt(p * (1 - p) / n + squared / (4 * n)) / (1 + squared)
    return Share(n, p, np.where(n > 0, np.maximum(centre - half, 0), 0), np.where(n > 0, centre + half, 1))

"""What a long motion does on the average, with confidence intervals from block averages.

The span is cut into blocks of equal length, each of several periods of the source. The averages of the blocks
scatter about the average of the whole; where they are long enough to be nearly independent, their
scatter tells how well it is known. What correlation is left between neighbours widens the interval.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import pi, sqrt

import numpy as np

from vibsim.physics.modes import EVENT_KINDS
from vibsim.physics.sums import dot, mean
from vibsim.physics.two_blocks import TwoBlocks
from vibsim.results.result import Result
from vibsim.results.windows import rows_within

MOST_BLOCKS, FEWEST_BLOCKS = 20, 8
PERIODS = 5  # in a block, at least
FEWEST_SAMPLES = 20  # in a block, four to a period, for statistics of samples
FEWEST_INDEPENDENT = 3.0  # even of blocks that all drift one way: Student's distribution of 2 degrees
UNITS = {"amplitude": "m", "drift rate": "m/s", "motor speed": "Hz", "impact rate": "1/s"}

Span = tuple[float, float]


@dataclass(frozen=True)
class Average:
    """Mean of a statistic over a span, and the half width of its confidence interval, in its unit."""

    mean: float
    half_width: float


def blocks_of(span: Span, period: float) -> list[Span]:
    """The span [s] in blocks of equal length, several periods [s] each; none where it is too short."""
    length = span[1] - span[0]
    count = min(MOST_BLOCKS, int(length / (PERIODS * period)))
    if count < FEWEST_BLOCKS:
        return []
    edges = np.linspace(*span, count + 1).tolist()
    return list(pairwise(edges))


def period_of(scene: TwoBlocks) -> float:
    """Period of the source [s], of the free vibration where there is none; inf where nothing vibrates."""
    rate = {"none": 0.0, "harmonic": scene.omega, "motor": scene.Omega0}[scene.source]
    mobility = 1 / scene.m1 + (1 / scene.m2 if scene.has_block2 else 0.0)
    rate = abs(rate) or sqrt(scene.k1 * mobility)
    return 2 * pi / rate if rate else float("inf")


def block_values(result: Result, blocks: list[Span]) -> dict[str, np.ndarray]:
    """Statistics of every block by name, those that the scene has and that its samples are enough for."""
    time, event_time = result.time, result.events["t"]
    rows = [rows_within(time, block) for block in blocks]
    enough = min(part.stop - part.start for part in rows) >= FEWEST_SAMPLES
    found = [
        (_of_samples(result, part, time) if enough else {}) | _of_events(result, event_time, block)
        for part, block in zip(rows, blocks, strict=True)
    ]
    return {name: np.array([values[name] for values in found]) for name in found[0]}


def averages(values: Mapping[str, np.ndarray], doubt: float) -> dict[str, Average]:
    """Mean of each statistic; its interval misses the true mean with probability `doubt`."""
    return {name: average(blocks, doubt) for name, blocks in values.items()}


def average(blocks: np.ndarray, doubt: float) -> Average:
    """Mean of block averages (1-D), its interval by Student's distribution.

    Of n blocks whose neighbours have the correlation r, n (1 - r)/(1 + r) count as independent.
    """
    from scipy.special import stdtrit

    count, middle = len(blocks), float(mean(blocks))
    apart = blocks - middle
    squares = float(dot(apart, apart))
    variance = squares / (count - 1)
    neighbours = float(dot(apart[1:], apart[:-1])) / squares if squares else 0.0
    correlation = max(neighbours, 0.0)
    independent = max(FEWEST_INDEPENDENT, count * (1 - correlation) / (1 + correlation))
    return Average(middle, float(stdtrit(independent - 1, 1 - doubt / 2)) * sqrt(variance / independent))


def _of_samples(result: Result, rows: slice, time: np.ndarray) -> dict[str, float]:
    """Amplitude (sqrt(2) rms of x1 - x2 about its mean), drift rate of block 2, motor speed."""
    x1 = result.column("x1")[rows]
    x2 = result.column("x2")[rows] if "x2" in result else np.zeros_like(x1)
    y = x1 - x2
    apart = y - mean(y)
    found = {"amplitude": sqrt(2 * float(mean(apart * apart)))}
    if "x2" in result:
        found["drift rate"] = float(x2[-1] - x2[0]) / float(time[rows.stop - 1] - time[rows.start])
    if "phidot" in result:
        found["motor speed"] = float(mean(result.column("phidot")[rows])) / (2 * pi)
    return found


def _of_events(result: Result, times: np.ndarray, block: Span) -> dict[str, float]:
    """Impacts per second, where there is a stop."""
    if "contact" not in result:
        return {}
    kinds = result.events["kind"][rows_within(times, block)]
    return {"impact rate": np.count_nonzero(kinds == EVENT_KINDS["contact_begin"]) / (block[1] - block[0])}

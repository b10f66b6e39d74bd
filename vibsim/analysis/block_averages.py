"""What a long motion does on the average, with confidence intervals from block averages.

The span is cut into blocks of equal length, each of several periods of the source. The averages of the blocks
scatter about the average of the whole; where they are long enough to be nearly independent, their
scatter tells how well it is known. What correlation is left between neighbours widens the interval.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi, sqrt
from typing import Any

import numpy as np

from vibsim.physics.arithmetic.sums import dot, mean
from vibsim.physics.body_sets import drifting_sets, pairs_of
from vibsim.physics.parts import columns_of
from vibsim.results.motion.closing_velocity import IMPACT_CODES
from vibsim.results.motion.relative_motion import RelativeMotion
from vibsim.results.result import Result
from vibsim.results.windows import rows_within

MOST_BLOCKS, FEWEST_BLOCKS = 20, 8
PERIODS = 5  # in a block, at least
FEWEST_SAMPLES = 20  # in a block, four to a period, for statistics of samples
FEWEST_INDEPENDENT = 3.0  # even of blocks that all drift one way: Student's distribution of 2 degrees
OF = " of "  # before the name of the part or body where there are several
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


def unit_of(statistic: str) -> str:
    """The unit of a statistic of `block_values`."""
    return UNITS[statistic.partition(OF)[0]]


def block_values(result: Result, blocks: list[Span]) -> dict[str, np.ndarray]:
    """Statistics of every block by name, those that the scene has and that its samples are enough for.

    amplitude of each relative motion (`pairs_of`), drift rate of each set of bodies that may drift, motor
    speed, impact rate of each stop; of several the part or body is named: "impact rate of wall".
    """
    time, event_time = result.time, result.events["t"]
    rows = [rows_within(time, block) for block in blocks]
    enough = min(part.stop - part.start for part in rows) >= FEWEST_SAMPLES
    averages = [
        (_of_samples(result, part, time) if enough else {}) | _of_events(result, event_time, block)
        for part, block in zip(rows, blocks, strict=True)
    ]
    return {name: np.array([values[name] for values in averages]) for name in averages[0]}


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
    """Amplitude (sqrt(2) rms of x_P - x_Q about its mean), drift rate, motor speed."""
    scene = result.case.scene()
    clock = time[rows]
    averages: dict[str, float] = {}
    pairs = pairs_of(scene)
    for pair in pairs:
        motion = RelativeMotion(scene, pair)
        columns = {name: np.asarray(result.column(name)[rows]) for name in motion.columns}
        y = motion({"time": clock, **columns}, "time")[1]
        apart = y - mean(y)
        averages[_named("amplitude", pair, pairs)] = sqrt(2 * float(mean(apart * apart)))
    moving = [scene.bodies[one.reference] for one in drifting_sets(scene)]
    for body in moving:
        x = result.column(columns_of(body.name)[0])[rows]
        averages[_named("drift rate", body, moving)] = float(x[-1] - x[0]) / float(clock[-1] - clock[0])
    if scene.has_motor:
        averages["motor speed"] = float(mean(result.column("phidot")[rows])) / (2 * pi)
    return averages


def _of_events(result: Result, times: np.ndarray, block: Span) -> dict[str, float]:
    """Impacts per second at each stop."""
    stops = result.case.scene().stops
    if not stops:
        return {}
    rows = rows_within(times, block)
    part = result.events["part"][rows]
    part = part[np.isin(result.events["kind"][rows], IMPACT_CODES)]
    length = block[1] - block[0]
    return {
        _named("impact rate", stop, stops): np.count_nonzero(part == number) / length
        for number, stop in enumerate(stops)
    }


def _named(statistic: str, one: Any, among: Sequence[Any]) -> str:
    """The name of a statistic, with that of its part or body where there are several."""
    return statistic if len(among) == 1 else f"{statistic}{OF}{one.name}"

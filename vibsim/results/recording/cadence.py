"""The instants at which a run is judged, whatever its output: those of its samples, and others between them.

An error that swings with the motion shows at some instants only, and one sample a minute would show none of
it. So where samples are further apart than JUDGED to the longest period, the engine is asked for a whole
multiple of them, at the same instants and between; the judgement takes all, the file those that were asked
for. Output never changes a trajectory, and samples that are close enough cost nothing.
"""

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from math import ceil, isinf
from typing import Any

import numpy as np

from vibsim.physics.rates import longest_period

JUDGED = 8  # instants to the longest period: 16 in the time for which a distance is held
EXACT = 2**53  # whole numbers up to here are doubles, so instants of a sample are the same bit for bit


def instants_per_sample(scene: Any) -> int:
    """Judged instants to each sample of a run of `scene`; 1 where the samples are enough."""
    period = longest_period(scene)
    every = Fraction(scene.every_num, scene.every_den)
    if isinf(period) or every * JUDGED <= Fraction(period):
        return 1
    count = ceil(every * JUDGED / Fraction(period))
    finer = every / count
    exact = Fraction(scene.t_end) * finer.denominator < EXACT and finer.numerator < EXACT
    return count if exact else 1


def sampled_finer(scene: Any, count: int) -> Any:
    """The scene with `count` instants to each of its samples."""
    every = Fraction(scene.every_num, scene.every_den) / count
    return replace(scene, every_num=every.numerator, every_den=every.denominator) if count > 1 else scene


class Thinning:
    """Picks every `count`-th of the rows that come in blocks, the first one first."""

    def __init__(self, count: int):
        self._count, self._skipped = count, 0

    def thinned(self, rows: Mapping[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        """The rows of the next block that count."""
        if self._count == 1:
            return rows
        length, first = len(rows["time"]), self._skipped
        self._skipped = (first - length) % self._count
        return {name: column[first :: self._count] for name, column in rows.items()}

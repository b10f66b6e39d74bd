"""The error of a run at every sample, estimated from the distance to its companion.

    estimate = (1 + decades / 6) x largest distance so far; at least one ulp of the largest displacement

Distance: the larger of |dx1| and |dx2|. Two rounding errors of one size start in different directions,
and what counts is their share in the direction that grows; by bad luck the distance is small where the
error is not. Where nothing grows this averages out; where errors grow it stays. So the distance is
multiplied by a factor that rises with the decades by which it has grown beyond rounding: 1 at the
start, 2.7 when 1e-16 m has become 1e-6 m. The estimate never falls. When the two runs have nothing to
do with each other any more, it stays at the largest distance that they reach: it saturates at the size
of the motion.
"""

import numpy as np

ULP = 2.0**-52
BITS_DROPPED = 43  # of 52: three digits are more than an estimate has, and zeros take no room on file
DECADES = 6.0  # of growth for which the distance counts once more


class ErrorEstimate:
    """Running estimate over blocks of samples, and the horizon: until when it is within `tolerance` [m]."""

    def __init__(self, tolerance: float):
        self.tolerance = tolerance
        self.latest = 0.0  # estimate at the last sample [m]
        self._distance = self._size = 0.0
        self._within = 0.0  # time of the last sample within the tolerance [s]
        self._passed = False

    def update(self, time: np.ndarray, ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
        """Estimates [m] at the next samples, shape of `time` [s].

        ours, theirs : displacements [m] of the run and its companion, shape (blocks that move, samples). NaN
        where the companion has failed: nothing is known any more, and the estimate is the size of the motion.
        """
        if not len(time):
            return np.empty(0)
        size = np.maximum.accumulate(np.maximum(np.abs(ours).max(axis=0), self._size))
        apart = np.abs(ours - theirs).max(axis=0)
        apart = np.where(np.isnan(apart), size, apart)
        distance = np.maximum.accumulate(np.maximum(apart, self._distance))
        estimate = rounded_up(widened(distance, ULP * size))
        self._distance, self._size, self.latest = distance[-1], size[-1], float(estimate[-1])
        self._note(time, estimate)
        return estimate

    def horizon(self, t_reached: float) -> float:
        """Time of the last sample before the estimate passes the tolerance [s]; else `t_reached`."""
        return self._within if self._passed else t_reached

    def _note(self, time: np.ndarray, estimate: np.ndarray) -> None:
        if self._passed:
            return
        inside = int(np.searchsorted(estimate, self.tolerance, side="right"))  # it never falls
        if inside:
            self._within = float(time[inside - 1])
        self._passed = inside < len(estimate)


def widened(distance: np.ndarray, rounding: np.ndarray) -> np.ndarray:
    """Estimate [m] from the largest distance so far and the rounding of the states, both [m]."""
    grown = np.maximum(distance, rounding)
    ratio = np.divide(grown, rounding, out=np.ones_like(grown), where=rounding > 0)
    return grown * (1 + np.log10(ratio) / DECADES)


def rounded_up(values: np.ndarray) -> np.ndarray:
    """Positive doubles rounded up to three digits."""
    rest = (1 << BITS_DROPPED) - 1
    return ((values.view("i8") + rest) & ~rest).view("f8")

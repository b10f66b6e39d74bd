"""The error of a run at every sample, estimated from the distance to its companion.

    distance = the largest |dx| of any body, at least one ulp of the largest displacement so far
    estimate = (1 + decades / 8) x distance, held for about two periods

The distance swings with the motion, so the largest of the last periods counts: a value fades by the
factor e in two periods, along straight lines from one power of two to the next. Where errors die out, as in a
damped motion under a steady force, the estimate follows them down.

Two rounding errors of one size start in different directions, and what counts is their share in the
direction that grows; by bad luck the distance is small where the error is not. Where nothing grows this
averages out; where errors grow it stays. So the distance is multiplied by a factor that rises with the
decades by which it has grown beyond rounding: 1 at the start, 2.25 when 1e-16 m has become 1e-6 m; and by
what a third run tells (`trust_share`). The companion's data and the times of its events are one unit in the
last place from those of the run, which are at most half of one from the true ones.

When the two runs have nothing to do with each other any more, the estimate says how far apart such runs are:
it saturates at the size of the motion.
"""

from math import log, log10

import numpy as np

from vibsim.physics.parts import Scene
from vibsim.physics.rates import longest_period
from vibsim.results.trust.share import MOST, Share, Third

ULP = 2.0**-52
DECADES = 8.0  # of growth for which the distance counts once more
PERIODS_HELD = 2.0
BITS_BELOW = 12  # of a double, left out of its logarithm: room for sums
UNIT = 2.0 ** (52 - BITS_BELOW)  # of the logarithm: so many to a power of two
BITS_DROPPED = 43  # of 52: three digits are more than an estimate has, and zeros take no room on file


class ErrorEstimate:
    """Running estimate over blocks of samples, and the horizon: until when it is within `tolerance` [m].

    scene : what is run; it sets the time for which a distance is held
    """

    def __init__(self, scene: Scene, tolerance: float):
        self.tolerance = tolerance
        self.largest = 0.0  # estimate so far [m]
        self._fading = 1 / (PERIODS_HELD * longest_period(scene))  # [1/s]
        self._time = self._distance = self._size = 0.0  # at the last sample
        self._within = 0.0  # time of the last sample before the estimate passes the tolerance [s]
        self._passed = False
        self.known_to: float | None = None  # time of the last sample before nothing is known [s]
        self._share = Share()

    def update(
        self,
        time: np.ndarray,
        ours: np.ndarray,
        theirs: np.ndarray,
        left_out: np.ndarray | float = 0.0,
        third: Third | None = None,
    ) -> np.ndarray:
        """Estimates [m] at the next samples, shape of `time` [s].

        ours, theirs : displacements [m] of the run and its companion, shape (bodies, samples). NaN
        where the companion has failed: nothing is known any more, and the estimate is the size of the motion.
        left_out : a distance [m] that both are known to lack, at least
        third : a third run, by which distances are widened; the same in every call. Where it raises NotYet,
        these samples have to be given again
        """
        if not len(time):
            return np.empty(0)
        size = np.maximum.accumulate(np.maximum(np.abs(ours).max(axis=0), self._size))
        apart = np.abs(ours - theirs).max(axis=0)
        unknown = np.isnan(apart)
        apart = np.maximum(np.where(unknown, size, apart), left_out)
        times, apart = np.append(self._time, time), np.append(self._distance, apart)
        distance = held(times, apart, self._fading)[1:]
        rounding = ULP * size
        share = self._share.of(time, ours, apart[1:], distance, rounding, third) if third else None
        if share is not None:
            unknown |= share >= MOST
        bounded = distance if share is None else np.minimum(distance * share, np.maximum(distance, size))
        estimate = rounded_up(widened(bounded, rounding))
        self._note(time, estimate, unknown)
        self._time, self._distance, self._size = time[-1], distance[-1], size[-1]
        return estimate

    def horizon(self, t_reached: float) -> float:
        """Time of the last sample before the estimate passes the tolerance, or nothing is known [s]; else
        `t_reached`.
        """
        return self._within if self._passed else t_reached

    def _note(self, time: np.ndarray, estimate: np.ndarray, unknown: np.ndarray) -> None:
        self.largest = max(self.largest, float(estimate.max()))
        if self.known_to is None and unknown.any():
            first = int(np.argmax(unknown))
            self.known_to = float(time[first - 1] if first else self._time)
        if self._passed:
            return
        beyond = np.flatnonzero((estimate > self.tolerance) | unknown)
        inside = int(beyond[0]) if len(beyond) else len(estimate)
        if inside:
            self._within = float(time[inside - 1])
        self._passed = len(beyond) > 0


def held(time: np.ndarray, values: np.ndarray, fading: float) -> np.ndarray:
    """At each time [s] the largest of the values up to then, each faded by e in 1/fading [s] of its age.

    Ages are differences of whole numbers, the same wherever a block of samples begins.
    """
    ticks = np.rint(time * (fading * UNIT / log(2)))
    age = (ticks - ticks[0]).astype("i8")
    faded = np.maximum.accumulate(logarithm(values) + age) - age
    return np.asarray((faded << BITS_BELOW).view("f8"))


def logarithm(values: np.ndarray) -> np.ndarray:
    """Logarithms of doubles from 0 up, UNIT to a power of two, linear between these: their very bits.

    Whole numbers, so the same everywhere, which numpy's logarithms are not; rounded up.
    """
    return (values.view("i8") + (1 << BITS_BELOW) - 1) >> BITS_BELOW


def widened(distance: np.ndarray, rounding: np.ndarray) -> np.ndarray:
    """Estimate [m] from the distance and the rounding of the states, both [m]."""
    grown = np.maximum(distance, rounding)
    growth = np.where(rounding > 0, logarithm(grown) - logarithm(rounding), 0)  # to 0.09 of a power of two
    return np.asarray(grown * (1 + growth * (log10(2) / UNIT / DECADES)))


def rounded_up(values: np.ndarray) -> np.ndarray:
    """Doubles that are not negative, rounded up to three digits."""
    rest = (1 << BITS_DROPPED) - 1
    return ((values.view("i8") + rest) & ~rest).view("f8")

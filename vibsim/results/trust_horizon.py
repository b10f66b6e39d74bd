"""The trust horizon of a run, until which it is right, and its error at every sample."""

import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from math import inf, log, log10
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from vibsim.engine.blocks_ahead import Cores, available_cores
from vibsim.physics.parts import Scene
from vibsim.physics.rates import longest_period
from vibsim.results.columns import tables_of
from vibsim.results.parallel_runs import (
    MOST,
    Companion,
    GoOn,
    NotYet,
    Third,
    ThirdRun,
    ThirdRunFactor,
    companion_scene,
    described,
    most_events,
)

if TYPE_CHECKING:
    from vibsim.cases import Case


COLUMN = "error_estimate"
HELD = 4  # blocks of samples that wait to be judged before the run itself does
GRACE = 1.0  # seconds in which a run that is stopped waits for what judges it
Rows = Mapping[str, np.ndarray]
Tag = TypeVar("Tag")  # whatever goes with a block


@dataclass
class Unjudged(Generic[Tag]):
    """A block of samples that waits to be judged, with the displacements of the companion [m] once known.

    left_out, tag : as of `Trust.judged`; most : events that the companion may take up to each sample
    """

    samples: Rows
    most: np.ndarray
    left_out: np.ndarray | float
    tag: Tag
    theirs: np.ndarray | None = None


class NoTrust(Generic[Tag]):
    """Stands in for `Trust` in a run that is not judged."""

    columns: tuple[str, ...] = ()
    t_reached = inf  # of what judges [s]

    def start(self) -> None:
        """Nothing runs beside."""

    def close(self) -> None:
        """Nothing runs beside."""

    def judged(
        self,
        samples: Rows,
        happened: np.ndarray,
        left_out: np.ndarray | float,
        tag: Tag,
        go_on: GoOn,
        waits: bool = True,
    ) -> Iterator[tuple[Rows, Tag]]:
        """The samples as they are."""
        yield samples, tag

    def ready(self, go_on: GoOn) -> Iterator[tuple[Rows, Tag]]:
        """Nothing waits."""
        return iter(())

    def rest(self, go_on: GoOn) -> Iterator[tuple[Rows, Tag]]:
        """Nothing waits."""
        return iter(())

    def attrs(self, t_reached: float) -> dict[str, Any]:
        """Nothing is known."""
        return {}


class Trust(NoTrust[Tag]):
    """Judges a run of `case` while it is computed, by a companion.

    case, scene : what is run. To be started, and closed at the end.
    tell_news : called, in another thread, whenever `ready` may have more
    """

    columns = (COLUMN,)

    def __init__(self, case: "Case", scene: Scene, tell_news: Callable[[], None]):
        self._case, self._scene, self._tell_news = case, scene, tell_news
        self._estimate = ErrorEstimate(scene, case.number("run.trust_tolerance"))
        self._names = tables_of(scene).deciding
        self._held: deque[Unjudged[Tag]] = deque()
        self._taken = 0  # events of the run
        self._cores = Cores(max(available_cores() - 1, 1))  # one is for the run itself, until that has ended

    @cached_property
    def _other(self) -> Scene:
        """The scene of the companion, made when it begins: the run itself need not wait for that."""
        return companion_scene(self._case, self._scene)

    @cached_property
    def _companion(self) -> Companion:
        return Companion(self._other, self._tell_news, self._cores)

    @cached_property
    def _third(self) -> ThirdRun:
        return ThirdRun(self._other, self._scene, self._tell_news, self._cores)

    def start(self) -> None:
        """Let the companion begin, where that has not been done."""
        self._companion.start()

    def close(self) -> None:
        """End where it is what runs beside."""
        self._companion.close()
        self._third.close()

    @property
    def t_reached(self) -> float:  # type: ignore[override]
        """Time that the companion has reached [s]; infinite once it has ended."""
        return self._companion.t_reached

    def judged(
        self,
        samples: Rows,
        happened: np.ndarray,
        left_out: np.ndarray | float,
        tag: Tag,
        go_on: GoOn,
        waits: bool = True,
    ) -> Iterator[tuple[Rows, Tag]]:
        """Take the next block of samples, and yield those that are judged by now, with the column
        `error_estimate` [m]: none where the companion or a third run is waited for.

        happened : times of the events that the engine handed over with them [s]
        left_out : distance [m] at each sample that the run has left out of infinite sequences of impacts
        tag : what goes with the block; `go_on` as in `Companion.take`; waits : whether to wait where many
        blocks are held
        """
        taken = self._taken + np.searchsorted(happened, samples["time"], side="right")
        self._taken += len(happened)
        self._held.append(Unjudged(samples, most_events(taken), left_out, tag))
        yield from self._released(go_on, HELD if waits else inf)

    def ready(self, go_on: GoOn) -> Iterator[tuple[Rows, Tag]]:
        """Yield the blocks of those that wait which can be judged by now."""
        return self._released(go_on, inf)

    def rest(self, go_on: GoOn) -> Iterator[tuple[Rows, Tag]]:
        """Yield the blocks that wait, judged. A second after `go_on` says no, nothing is known of where the
        companion has not been, or from where a third run was asked that has not ended.
        """
        self._cores.add()
        until = time.monotonic() + GRACE
        yield from self._released(lambda: go_on() or time.monotonic() < until, 0)

    def _released(self, go_on: GoOn, most: float) -> Iterator[tuple[Rows, Tag]]:
        """Judge blocks, and wait for what that takes as long as more than `most` are held."""
        while self._held:
            block, waits = self._held[0], len(self._held) > most
            times = block.samples["time"]
            if block.theirs is None and (waits or self._companion.has(block.most)):
                block.theirs = self._companion.take(block.most, go_on)
            if block.theirs is None or (self._third.is_awaited and not waits):
                return
            ours = np.stack([block.samples[name] for name in self._names])
            third = partial(self._by_a_third_run, go_on, waits, block)
            try:
                estimates = self._estimate.update(times, ours, block.theirs, block.left_out, third)
            except NotYet:
                return
            self._held.popleft()
            yield {**block.samples, COLUMN: estimates}, block.tag

    def _by_a_third_run(
        self, go_on: GoOn, waits: bool, block: Unjudged[Tag], count: int, last: int, until: float
    ) -> np.ndarray:
        """`trust_share.Third`, to be waited for or not, where `block` is judged."""
        most = int(block.most[np.searchsorted(block.samples["time"], until)])
        told = self._third.displacements(lambda: waits and go_on(), count, last, until, most)
        if told is None and not waits:
            raise NotYet
        return np.full((len(self._names), last), inf) if told is None else told

    def attrs(self, t_reached: float) -> dict[str, Any]:
        """Attributes of the file: horizon [s], tolerance [m], method, and the largest estimate [m]; and from
        when on nothing is known [s], and why, where a run beside this one was given up or failed.

        The horizon is `t_reached` where the tolerance is never passed.
        """
        known_to, unknown = self._estimate.known_to, {}
        companion, third = self._companion.failure, self._third.failure
        if known_to is not None and (companion or third):
            why = f"its companion {companion}" if companion else f"a third run {third}"
            unknown = {"trust_known_to_s": known_to, "trust_unknown_why": why}
        return {
            **unknown,
            "trust_horizon_s": self._estimate.horizon(t_reached),
            "trust_tolerance_m": self._estimate.tolerance,
            "trust_method": described(self._other),
            "error_estimate_max": self._estimate.largest,
        }


# The error of a run at every sample, estimated from the distance to its companion.
#
#     distance = the largest |dx| of any body (of rotors and states where there is no body), at least
#                one ulp of the largest displacement so far
#     estimate = (1 + decades / 8) x distance, held for about two periods
#
# The distance swings with the motion, so the largest of the last periods counts: a value fades by the
# factor e in two periods, along straight lines from one power of two to the next. Where errors die out, as in
# a damped motion under a steady force, the estimate follows them down.
#
# Two rounding errors of one size start in different directions, and what counts is their share in the
# direction that grows; by bad luck the distance is small where the error is not. Where nothing grows this
# averages out; where errors grow it stays. So the distance is multiplied by a factor that rises with the
# decades by which it has grown beyond rounding: 1 at the start, 2.25 when 1e-16 m has become 1e-6 m; and by
# what a third run tells (`trust_share`). The companion's data and the times of its events are one unit in the
# last place from those of the run, which are at most half of one from the true ones.
#
# When the two runs have nothing to do with each other any more, the estimate says how far apart such runs
# are: it saturates at the size of the motion.


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
        self._share = ThirdRunFactor()

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


FASTEST = 1e290  # ticks per second; more would overflow
OLDEST = 2.0**53  # ticks, from which on ages are no longer told apart


def held(time: np.ndarray, values: np.ndarray, fading: float) -> np.ndarray:
    """At each time [s] the largest of the values up to then, each faded by e in 1/fading [s] of its age.

    Ages are differences of whole numbers, the same wherever a block of samples begins.
    """
    ticks = np.minimum(np.rint(time * min(fading * UNIT / log(2), FASTEST)), OLDEST)
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

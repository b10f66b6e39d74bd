"""Until when a run is right: its error at every sample, and the trust horizon."""

import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from math import inf
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from vibsim.physics.parts import Scene
from vibsim.results.columns import tables_of
from vibsim.results.cores import Cores, available_cores
from vibsim.results.trust.companion import Companion, GoOn, companion_scene, described, most_events
from vibsim.results.trust.estimate import ErrorEstimate
from vibsim.results.trust.share import NotYet
from vibsim.results.trust.third_run import ThirdRun

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
    """What takes the place of `Trust` in a run that is not judged."""

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
    """Judges a run of `case` while it is computed, by a companion on the same engine.

    case, scene : what is run. To be started, and closed at the end.
    tell_news : called, in another thread, whenever `ready` may have more
    """

    columns = (COLUMN,)

    def __init__(self, case: "Case", scene: Scene, engine: str, tell_news: Callable[[], None]):
        self._case, self._scene, self._engine, self._tell_news = case, scene, engine, tell_news
        self._estimate = ErrorEstimate(scene, case.number("run.trust_tolerance"))
        self._names = tables_of(scene).displacements
        self._held: deque[Unjudged[Tag]] = deque()
        self._taken = 0  # events of the run
        self._cores = Cores(max(available_cores() - 1, 1))  # one is for the run itself, until that has ended

    @cached_property
    def _other(self) -> Scene:
        """The scene of the companion, made when it begins: the run itself need not wait for that."""
        return companion_scene(self._case, self._scene)

    @cached_property
    def _companion(self) -> Companion:
        return Companion(self._other, self._engine, self._tell_news, self._cores)

    @cached_property
    def _third(self) -> ThirdRun:
        return ThirdRun(self._other, self._scene, self._engine, self._tell_news, self._cores)

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

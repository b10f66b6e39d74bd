"""The blocks of a run, computed in a thread of their own while those before are judged and written.

The C engine lets go of the interpreter while it computes, and so does the compression of what is written.
"""

import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from math import ceil, isinf
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

import numpy as np

from vibsim.engine.blocks import Block
from vibsim.engine.trajectory import Trajectory
from vibsim.physics.rates import longest_period

PATIENCE = 0.1  # seconds between two questions whether to wait on
LONGEST = 10.0  # seconds that an end is waited for: a block and a step of a decision take far less
MOST_AHEAD = 2  # blocks that wait; bounds the memory of a run that is faster than the disk

Told = TypeVar("Told")


class ProgressSignal:
    """In place of a block: who works beside the run has come further."""


class BlocksAhead(Generic[Told]):
    """The blocks of a trajectory, each with what `tell` says of it right behind it."""

    def __init__(self, trajectory: Trajectory, tell: Callable[[Block], Told]):
        self._trajectory, self._tell = trajectory, tell
        self._queue: SimpleQueue[tuple[Block, Told] | BaseException | ProgressSignal | None] = SimpleQueue()
        self._room = threading.Semaphore(MOST_AHEAD - 1)
        self._thread = threading.Thread(target=self._run, name="vibsim engine", daemon=True)
        self._stopped = False

    def start(self) -> None:
        """Set off, where that has not been done."""
        if self._thread.ident is None:
            self._thread.start()

    def blocks(
        self, go_on: Callable[[], bool], meanwhile: Callable[[], None] = lambda: None
    ) -> Iterator[tuple[Block, Told]]:
        """Yield blocks to the end; raises what the engine raises.

        `go_on` is asked while they are waited for; where it says no, and where `stop` was called, those that
        are computed by then are the last. `meanwhile` is called while they are waited for and there is news.
        """
        while (item := self._next(go_on)) is not None:
            if isinstance(item, ProgressSignal):
                meanwhile()
                continue
            self._room.release()
            if isinstance(item, BaseException):
                raise item
            yield item

    def tell_news(self) -> None:
        """Let `blocks` call `meanwhile`, from any thread."""
        self._queue.put(ProgressSignal())

    def stop(self) -> None:
        """Compute no more than the block that is begun, and decide nothing more."""
        self._stopped = True
        self._trajectory.stop()

    def close(self) -> None:
        """Stop, and wait for the end of the block that is begun, or for LONGEST at most."""
        self.stop()
        self._room.release()
        if self._thread.ident is not None:
            self._thread.join(LONGEST)

    def _next(self, go_on: Callable[[], bool]) -> tuple[Block, Told] | BaseException | ProgressSignal | None:
        while True:
            try:
                return self._queue.get(timeout=PATIENCE)
            except Empty:
                if not go_on():
                    self.stop()

    def _run(self) -> None:
        try:
            for block in self._trajectory.blocks():
                self._queue.put((block, self._tell(block)))
                self._room.acquire()
                if self._stopped:
                    break
            self._queue.put(None)
        except BaseException as error:  # raised again where the blocks are asked for
            self._queue.put(error)


# The processor's cores, and who may compute on them.


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Cores:
    """Lets `count` threads compute at a time, each within a `with`; who has asked first is next."""

    def __init__(self, count: int):
        self._free = count
        self._waiting: deque[object] = deque()
        self._changed = threading.Condition()

    def add(self) -> None:
        """Let one thread more compute."""
        with self._changed:
            self._free += 1
            self._changed.notify_all()

    def __enter__(self) -> None:
        asked = object()
        with self._changed:
            self._waiting.append(asked)
            self._changed.wait_for(lambda: self._free > 0 and self._waiting[0] is asked)
            self._waiting.popleft()
            self._free -= 1

    def __exit__(self, *_: object) -> None:
        self.add()


# The instants at which a run is judged, whatever its output: those of its samples, and others between them.
#
# An error that swings with the motion shows at some instants only, and one sample a minute would show none of
# it. So where samples are further apart than JUDGED to the longest period, the engine is asked for a whole
# multiple of them, at the same instants and between; the judgement takes all, the file those that were asked
# for. Output never changes a trajectory, and samples that are close enough cost nothing.


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

"""The blocks of a run, computed in a thread of their own while those before are judged and written.

The C engine lets go of the interpreter while it computes, and so does the compression of what is written.
"""

import threading
from collections.abc import Callable, Iterator
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

from vibsim.engine.trajectories.blocks import Block, Trajectory

PATIENCE = 0.1  # seconds between two questions whether to wait on
LONGEST = 10.0  # seconds that an end is waited for: a block and a step of a decision take far less
MOST_AHEAD = 2  # blocks that wait; bounds the memory of a run that is faster than the disk

Told = TypeVar("Told")


class News:
    """In place of a block: who works beside the run has come further."""


class BlocksAhead(Generic[Told]):
    """The blocks of a trajectory, each with what `tell` says of it right behind it."""

    def __init__(self, trajectory: Trajectory[float], tell: Callable[[Block], Told]):
        self._trajectory, self._tell = trajectory, tell
        self._queue: SimpleQueue[tuple[Block, Told] | BaseException | News | None] = SimpleQueue()
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
            if isinstance(item, News):
                meanwhile()
                continue
            self._room.release()
            if isinstance(item, BaseException):
                raise item
            yield item

    def tell_news(self) -> None:
        """Let `blocks` call `meanwhile`, from any thread."""
        self._queue.put(News())

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

    def _next(self, go_on: Callable[[], bool]) -> tuple[Block, Told] | BaseException | News | None:
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

"""The processor's cores, and who may compute on them."""

import os
import threading
from collections import deque


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

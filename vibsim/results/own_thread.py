"""A thread that computes ahead of those who ask for what it has, and can be ended where it is.

The C engine lets go of the interpreter while it computes, and so does the compression of what is written.
"""

import threading
from abc import ABC, abstractmethod

PATIENCE = 0.1  # seconds between two questions whether to wait on


class OwnThread(ABC):
    """Work in a thread of its own: `_run` takes `_room` for each piece and ends where `_stopped` says so."""

    def __init__(self, name: str, most_ahead: int = 0):
        self._room = threading.Semaphore(most_ahead)  # bounds the memory of what nobody has asked for yet
        self._stopped = False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Set off, where that has not been done."""
        if self._thread.ident is None:
            self._thread.start()

    def close(self) -> None:
        """Stop, and wait for the end of the piece that is begun."""
        self._stopped = True
        self._room.release()
        if self._thread.ident is not None:
            self._thread.join()

    @abstractmethod
    def _run(self) -> None:
        """What the thread does."""

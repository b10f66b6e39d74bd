"""Ctrl-C and SIGTERM, heard but not obeyed until it suits."""

import signal
import sys
from types import FrameType, TracebackType
from typing import Any

PATIENCE = 1.5  # seconds; nobody should have to wait for two


class Interruption:
    """While entered, the first SIGINT or SIGTERM is only noted; a second interrupts at once.

    `signum` is the signal, None before. Whoever reads it then has been told, and ends what it does. Where
    nobody has read it for PATIENCE the work is one that does not ask, and is interrupted.
    """

    def __init__(self) -> None:
        self._signum: int | None = None
        self._before: dict[int, Any] = {}

    @property
    def signum(self) -> int | None:
        if self._signum is not None:
            _set_alarm(0)
        return self._signum

    @property
    def exit_code(self) -> int:
        """128 + the signal, as a shell reports it; 0 without one."""
        return 0 if self._signum is None else 128 + self._signum

    def __enter__(self) -> "Interruption":
        for signum in (signal.SIGINT, signal.SIGTERM):
            self._before[signum] = signal.signal(signum, self._note)
        if hasattr(signal, "SIGALRM"):
            self._before[signal.SIGALRM] = signal.signal(signal.SIGALRM, self._lose_patience)
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        _set_alarm(0)
        for signum, handler in self._before.items():
            signal.signal(signum, handler)  # as it was

    def _note(self, signum: int, frame: FrameType | None) -> None:
        if self._signum is not None:
            raise KeyboardInterrupt
        self._signum = signum
        _set_alarm(PATIENCE)

    def _lose_patience(self, signum: int, frame: FrameType | None) -> None:
        if self._signum == signal.SIGTERM:
            sys.exit(self.exit_code)
        raise KeyboardInterrupt


def _set_alarm(seconds: float) -> None:
    """SIGALRM after so many seconds, or never for 0; nothing where the system has none."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds)

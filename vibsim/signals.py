"""Ctrl-C and SIGTERM: held back, heard but not obeyed until it suits, or raised where nothing is unfinished.

HDF5 can go round for ever in a file whose inner lists are damaged, and Python hears of no signal until
it returns. While a file is read nothing can be lost, so the command lets signals end it there and then.
While one is created or published the command holds them back: what is open is known to what closes it.
"""

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any


class Terminated(KeyboardInterrupt):
    """SIGTERM, where Ctrl-C would be a KeyboardInterrupt."""


of_the_command = False  # whether this process is the command: another program's signals are its own


@contextmanager
def ended_at_once() -> Iterator[None]:
    """SIGINT and SIGTERM end the command at once, as the system does it; usable as a decorator."""
    if not of_the_command or threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {signum: signal.getsignal(signum) for signum in (signal.SIGINT, signal.SIGTERM)}
    for signum, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(signum, signal.SIG_DFL)
    try:
        yield
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)


class held_back:
    """Signals that raise in the command raise at the end of this block; for what takes no time.

    Between the call that opens a file and the name that it is given a KeyboardInterrupt would leave it open.
    """

    _depth = 0  # blocks that are entered; signals are handled by the main thread alone
    _waiting: type[KeyboardInterrupt] | None = None

    def __enter__(self) -> None:
        if threading.current_thread() is threading.main_thread():
            held_back._depth += 1

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if threading.current_thread() is not threading.main_thread():
            return
        held_back._depth -= 1
        if held_back._depth == 0 and held_back._waiting is not None:
            waiting, held_back._waiting = held_back._waiting, None
            raise waiting


def raise_interruption(error: type[KeyboardInterrupt]) -> None:
    """Raise it here, or at the end of the block that holds signals back."""
    if held_back._depth == 0:
        raise error
    held_back._waiting = error


@contextmanager
def interrupted_with(what: Callable[[], str]) -> Iterator[None]:
    """A KeyboardInterrupt that says nothing yet says what is there of the work: `what`, asked then."""
    try:
        yield
    except KeyboardInterrupt as error:
        raise type(error)(str(error) or what()) from error


# Ctrl-C and SIGTERM: heard but not obeyed until it suits, or raised where nothing is to be finished.


PATIENCE_FOR_END = 1.5  # seconds; nobody should have to wait for two
SIGNAL_AGAIN = 0.2  # seconds until a KeyboardInterrupt is raised again that has come to nothing


class Interruption:
    """While entered, the first SIGINT or SIGTERM is only noted; a second interrupts at once.

    `signum` is the signal, None before. Whoever reads it then has been told, and ends what it does. Where
    nobody has read it for PATIENCE_FOR_END the work is one that does not ask, and is interrupted. A signal
    that the caller has ignored, as shells do for what runs in the background, goes on to be ignored.
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
            if signal.getsignal(signum) is not signal.SIG_IGN:
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
            _set_alarm(SIGNAL_AGAIN)
            raise_interruption(KeyboardInterrupt)
            return
        self._signum = signum
        _set_alarm(PATIENCE_FOR_END)

    def _lose_patience(self, signum: int, frame: FrameType | None) -> None:
        _raise_unless_under_way(Terminated if self._signum == signal.SIGTERM else KeyboardInterrupt)


def _raise_unless_under_way(error: type[KeyboardInterrupt]) -> None:
    """Raise it, unless the program is about to end by one.

    One that comes up in a callback of the garbage collector, of which pictures have thousands, is printed and
    forgotten by Python; so it is raised until it is on its way.
    """
    if not isinstance(sys.exc_info()[1], KeyboardInterrupt):
        raise_interruption(error)


def _set_alarm(seconds: float) -> None:
    """SIGALRM after so many seconds, again and again; never for 0, nor where the system has none."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, seconds, SIGNAL_AGAIN if seconds else 0.0)


def heard_from_now_on() -> None:
    """SIGINT and SIGTERM raise KeyboardInterrupt, unless the caller has them ignored."""
    _handle({signal.SIGINT: _interrupt, signal.SIGTERM: _interrupt})
    told = sys.unraisablehook

    def tell(what: Any) -> None:
        if not issubclass(what.exc_type, KeyboardInterrupt):  # it is raised again
            told(what)

    sys.unraisablehook = tell


def forget_alarm() -> None:
    """Raise nothing again: it is known that the command was interrupted."""
    _set_alarm(0)


def ended_by_signals() -> None:
    """SIGINT and SIGTERM end the process as the system does it: nothing is left to be kept."""
    forget_alarm()
    _handle({signal.SIGINT: signal.SIG_DFL, signal.SIGTERM: signal.SIG_DFL})


def _handle(handlers: dict[int, Any]) -> None:
    for signum, handler in handlers.items():
        if signal.getsignal(signum) is not signal.SIG_IGN:
            signal.signal(signum, handler)


def _interrupt(signum: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, until it is on its way."""
    error = Terminated if signum == signal.SIGTERM else KeyboardInterrupt
    if hasattr(signal, "SIGALRM"):
        signal.signal(signal.SIGALRM, lambda *_: _raise_unless_under_way(error))
        _set_alarm(SIGNAL_AGAIN)
    raise_interruption(error)

"""Ctrl-C while a file is opened or written.

HDF5 can go round for ever in a file whose inner lists are damaged, and Python hears of no signal until
it returns. While a file is read nothing can be lost, so the command lets signals end it there and then.
While one is created or published the command holds them back: what is open is known to what closes it.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType


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

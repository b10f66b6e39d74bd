"""Ctrl-C while a file is opened or written.

HDF5 can go round for ever in a file whose inner lists are damaged, and Python hears of no signal until
it returns. While a file is opened nothing can be lost, so the command lets signals end it there and then.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


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


@contextmanager
def interrupted_with(what: Callable[[], str]) -> Iterator[None]:
    """A KeyboardInterrupt that says nothing yet says what is there of the work: `what`, asked then."""
    try:
        yield
    except KeyboardInterrupt as error:
        raise type(error)(str(error) or what()) from error

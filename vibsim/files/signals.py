"""Ctrl-C while HDF5 reads the structure of a file.

The library can go round for ever in a file whose inner lists are damaged, and Python hears of no signal until
it returns. While a file is opened nothing can be lost, so the command lets signals end it there and then.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

of_the_command = False  # whether this process is the command: another program's signals are its own


@contextmanager
def ended_at_once() -> Iterator[None]:
    """SIGINT and SIGTERM end the command at once, as the system does it; usable as a decorator."""
    if not of_the_command or threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {signum: signal.signal(signum, signal.SIG_DFL) for signum in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)

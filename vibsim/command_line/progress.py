"""A progress bar over simulated time, for runs that take longer than a moment."""

import sys
import time
from typing import Any

import click

PATIENCE = 1.0  # seconds before a bar appears
STEPS = 1000


class Progress:
    """A bar on stderr: simulated time and time still to wait; only on a terminal, only after a second."""

    def __init__(self, label: str, t_end: float, wanted: bool = True):
        self._label = label
        self._t_end = t_end
        self._wanted = wanted and sys.stderr.isatty()
        self._began = time.time()
        self._bar: Any = None

    def show(self, t: float) -> None:
        """Say that the run has reached the time `t` [s]."""
        if not self._wanted:
            return
        if self._bar is None:
            if time.time() - self._began < PATIENCE:
                return
            self._bar = self._new_bar()
        done = int(STEPS * t / self._t_end) if self._t_end else STEPS
        if done < self._bar.pos:  # another run of the same case has begun
            self.close()
            self._began = time.time()
            self._bar = self._new_bar()
        self._bar.update(done - self._bar.pos, current_item=t)

    def close(self) -> None:
        """Leave the terminal line as the bar left it."""
        if self._bar is not None:
            self._bar.render_finish()

    def _new_bar(self):
        bar: Any = click.progressbar(
            length=STEPS,
            label=self._label,
            file=sys.stderr,
            item_show_func=lambda t: None if t is None else f"{t:.1f} of {self._t_end:g} s",
        )
        bar.start = self._began  # the time still to wait counts from the start of the run
        bar.render_progress()
        return bar

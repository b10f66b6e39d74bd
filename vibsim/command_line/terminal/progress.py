"""A bar of how far the work is, on stderr where that is a terminal."""

import sys
import time
from typing import Any

import click

from vibsim.cases.plain_text import plain_text
from vibsim.command_line.terminal.printing import say

PATIENCE = 1.0  # seconds before a bar appears of work that is often done sooner
FINE = 1000  # steps of a bar over what is not counted
WIDTH = 28  # characters of the name of a step, so that bars below each other are in line


class Progress:
    """A bar for each step of the work; the time still to wait counts from the step's beginning.

    patience : seconds that a step may take before its bar appears
    listed : whether there are several steps, which are said line by line where there is no terminal
    """

    def __init__(self, shown: bool, patience: float = 0.0, listed: bool = False):
        self._shown, self._patience, self._listed = shown, patience, listed
        self._step, self._done = "", 0.0
        self._began = time.time()
        self._bar: Any = None

    def show(self, step: str, done: float, total: float, item: str = "") -> None:
        """Say how far a step is: of a whole number of things, or of so many seconds of motion.

        item : what is being done, of a step whose things take unequal times: no time to wait is told
        """
        if not self._shown:
            return
        if step != self._step or done < self._done:  # the next step, or this one once more
            self._begin(step)
        self._done = done
        if not sys.stderr.isatty() or time.time() - self._began < self._patience:
            return
        if self._bar is None:
            self._bar = self._new_bar(total, item)
        reached = int(self._bar.length * done / total) if total else self._bar.length
        if reached > self._bar.pos:
            self._bar.update(reached - self._bar.pos, current_item=item or f"{done:.1f} of {total:g} s")

    def close(self) -> None:
        """Leave the terminal line as the bar left it."""
        if self._bar is not None:
            self._bar.render_finish()
            self._bar = None

    def _begin(self, step: str) -> None:
        self.close()
        if self._step:
            self._began = time.time()
        if self._listed and not sys.stderr.isatty():
            say(step, err=True)
        self._step = step

    def _new_bar(self, total: float, item: str) -> Any:
        counted = isinstance(total, int)
        label = plain_text(self._step)
        bar: Any = click.progressbar(
            length=int(total) if counted else FINE,
            label=f"{label:{WIDTH}}" if self._listed else label,
            file=sys.stderr,
            show_eta=not item,
            show_pos=counted,
            item_show_func=None if counted else lambda shown: shown,
        )
        bar.start = self._began  # on the clock of click; it counts what came before the bar
        bar.current_item = item or None
        bar.render_progress()
        return bar

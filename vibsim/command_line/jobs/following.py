"""What is followed point by point into a file, a branch or a locus: progress, interruption, what is said."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibsim.command_line.options.settings import Settings
from vibsim.command_line.terminal.interruption import Interruption
from vibsim.command_line.terminal.printing import print_json, say
from vibsim.command_line.terminal.progress import PATIENCE, Progress
from vibsim.command_line.text.going_on import completed_file, goes_on
from vibsim.files.signals import interrupted_with

Watch = Callable[..., bool]  # told the number of points; whether to go on


@dataclass(frozen=True)
class Following:
    """How one kind of thing is followed.

    open_store : opens what takes the points, which has `points` and `notes`
    complete : given the store and a Watch, follows what is missing: what there is, whether it came to its end
    facts, show : it as plain data, and printed with a text about its file
    """

    open_store: Callable[[], Any]
    complete: Callable[[Any, Watch], tuple[Any, bool]]
    facts: Callable[[Any], dict[str, Any]]
    show: Callable[[Any, str], None]

    def run(self, path: Path, most: int, settings: Settings) -> int:
        """Follow it into a file, or complete that; returns the exit code."""
        began, store = time.perf_counter(), None
        with Interruption() as interruption, interrupted_with(lambda: _kept(path, store)):
            store = self.open_store()
            for note in store.notes:
                say(f"Warning: {note}", err=True)
            had, progress = len(store.points), Progress(not settings.quiet, PATIENCE)

            def watch(count: int, *_: object) -> bool:
                progress.show("points", count, most)
                return interruption.signum is None

            try:
                followed, finished = self.complete(store, watch)
            finally:
                progress.close()
        if settings.json:
            print_json({"file": str(path), **self.facts(followed)})
        elif not settings.quiet:
            self.show(followed, completed_file(path, len(followed), had, time.perf_counter() - began))
        if not finished:
            say(f"interrupted: {_kept(path, store)}", err=True)
            return interruption.exit_code
        return 0


def _kept(path: Path, store: Any) -> str:
    if store is None or not store.points:
        return "stopped before the first point; nothing is kept"
    return goes_on(path)

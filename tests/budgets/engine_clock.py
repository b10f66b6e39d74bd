"""Time spent inside C, apart from the copying of its blocks."""

import time
from types import SimpleNamespace
from unittest.mock import patch

from vibsim.engine import _engine, c_engine


class EngineClock:
    """Within `with EngineClock() as clock:` every run adds to clock.seconds."""

    def __enter__(self):
        self.seconds = 0.0
        engine = SimpleNamespace(Run=lambda *numbers: _TimedRun(_engine.Run(*numbers), self))
        self._patch = patch.object(c_engine, "_engine", engine)
        self._patch.start()
        return self

    def __exit__(self, *_):
        self._patch.stop()


class _TimedRun:
    """A run in C whose calls add to a clock."""

    def __init__(self, run, clock):
        self._run, self._clock = run, clock

    def __getattr__(self, name):
        function = getattr(self._run, name)

        def call(*arguments):
            began = time.perf_counter()
            answer = function(*arguments)
            self._clock.seconds += time.perf_counter() - began
            return answer

        return call


def run_through(trajectory):
    """Run a trajectory to its end, dropping its blocks; returns its totals."""
    for _ in trajectory.blocks():
        pass
    return trajectory.totals

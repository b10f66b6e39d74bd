"""Time spent inside C, apart from the copying of its blocks."""

import time
from unittest.mock import patch

from vibsim.engine import _engine


class EngineClock:
    """Within `with EngineClock() as clock:` every run adds to clock.seconds."""

    def __enter__(self):
        self.seconds, make = 0.0, _engine.Run
        self._patch = patch.object(_engine, "Run", lambda *numbers: _TimedRun(make(*numbers), self))
        self._patch.start()
        return self

    def __exit__(self, error, *_):
        self._patch.stop()
        assert error or self.seconds > 0, "no call of the engine was timed"


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

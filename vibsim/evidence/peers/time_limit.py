"""A limit on the wall time of a run, and a way to interrupt it: looked at after every step or few."""

import time
from collections.abc import Callable
from math import inf


class OutOfTime(Exception):
    """The limit has passed, or nobody waits for the result any more."""


class TimeLimit:
    """From its making on, `check` raises OutOfTime after `seconds`, or once `going_on` says False."""

    def __init__(self, seconds: float = inf, going_on: Callable[[], bool] = lambda: True):
        self._end = time.perf_counter() + seconds
        self._going_on = going_on

    def check(self) -> None:
        """Raise OutOfTime where the run is to end here."""
        if time.perf_counter() > self._end or not self._going_on():
            raise OutOfTime

"""Blocks of a run that are computed ahead: how far, what ends them, errors where they are asked for."""

import threading
import time
from types import SimpleNamespace

import pytest

from vibsim.engine.blocks_ahead import MOST_AHEAD, BlocksAhead


class Counting:
    """A run of so many blocks, which counts those that it has computed."""

    def __init__(self, count, error=None):
        self.count, self.error, self.computed, self.stopped = count, error, 0, False

    def stop(self):
        self.stopped = True

    def blocks(self):
        for number in range(self.count):
            self.computed += 1
            yield SimpleNamespace(number=number)
        if self.error:
            raise self.error


def numbers(ahead, go_on=lambda: True):
    return [(block.number, told) for block, told in ahead.blocks(go_on)]


def ahead_of(run):
    ahead = BlocksAhead(run, lambda block: -block.number)
    ahead.start()
    return ahead


def at_rest(run):
    """How many blocks a run has computed when it waits."""
    before = -1
    while run.computed != before:
        before = run.computed
        time.sleep(0.05)
    return run.computed


def test_blocks_come_in_order_with_what_is_told_of_each():
    ahead = ahead_of(Counting(20))
    assert numbers(ahead) == [(i, -i) for i in range(20)]
    ahead.close()


def test_a_run_waits_for_those_who_take_its_blocks():
    ahead = ahead_of(run := Counting(100))
    assert at_rest(run) == MOST_AHEAD
    taken = ahead.blocks(lambda: True)
    next(taken), next(taken), next(taken)
    assert at_rest(run) <= MOST_AHEAD + 3
    ahead.close()
    assert run.computed < 10


def test_what_is_computed_when_a_run_is_stopped_is_there():
    ahead = ahead_of(run := Counting(100))
    taken = ahead.blocks(lambda: True)
    first = next(taken)
    ahead.stop()
    rest = list(taken)
    assert [block.number for block, _ in (first, *rest)] == list(range(run.computed))
    assert run.computed < 10


def test_an_error_comes_behind_the_blocks_before_it():
    ahead, taken = ahead_of(Counting(3, ValueError("no motion"))), []
    with pytest.raises(ValueError, match="no motion"):
        for block, _ in ahead.blocks(lambda: True):
            taken.append(block.number)
    assert taken == [0, 1, 2]


def test_who_waits_is_asked_whether_to_go_on():
    release = threading.Event()

    class Slow(Counting):
        def blocks(self):
            for block in super().blocks():
                yield block
                release.wait(10)

    asked = []

    def go_on():
        asked.append(True)
        release.set()
        return False

    ahead = ahead_of(run := Slow(50))
    assert len(numbers(ahead, go_on)) == run.computed <= 2 and asked
    ahead.close()


def test_closing_ends_the_thread_also_of_a_run_that_was_never_begun():
    before = threading.active_count()
    BlocksAhead(Counting(3), lambda block: None).close()
    ahead_of(Counting(10**9)).close()
    assert threading.active_count() == before


def test_news_is_told_while_a_block_is_waited_for():
    told, released = [], threading.Event()

    class Slow(Counting):
        def blocks(self):
            released.wait(10)
            yield from super().blocks()

    ahead = ahead_of(Slow(2))
    ahead.tell_news()

    def meanwhile():
        told.append("news")
        released.set()

    assert [block.number for block, _ in ahead.blocks(lambda: True, meanwhile)] == [0, 1]
    assert told == ["news"]
    ahead.close()

"""Threads take turns on the cores that they may use, in the order in which they ask."""

import threading
import time

import pytest

from vibsim.engine.blocks_ahead import Cores


@pytest.mark.parametrize("count", [1, 2])
def test_no_more_compute_than_there_are_cores(count):
    cores, lock, inside, most = Cores(count), threading.Lock(), [], []

    def work():
        for _ in range(20):
            with cores:
                with lock:
                    inside.append(1)
                    most.append(len(inside))
                time.sleep(0.0005)
                with lock:
                    inside.pop()

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most) == count and len(most) == 80


def test_who_asks_again_waits_behind_those_who_have_asked():
    cores, order, asked = Cores(1), [], threading.Event()

    def other():
        asked.set()
        with cores:
            order.append("other")

    thread = threading.Thread(target=other)
    with cores:
        thread.start()
        asked.wait()
        while not cores._waiting:
            time.sleep(0.001)
    with cores:
        order.append("again")
    thread.join()
    assert order == ["other", "again"]


def test_a_core_that_becomes_free_is_used():
    cores, done = Cores(1), threading.Event()

    def other():
        with cores:
            done.set()

    thread = threading.Thread(target=other)
    with cores:
        thread.start()
        assert not done.wait(0.02)
        cores.add()
        assert done.wait(10)
    thread.join()


def test_a_failure_gives_the_core_back():
    cores = Cores(1)
    with pytest.raises(KeyError), cores:
        raise KeyError
    with cores:
        pass

import math

import numpy as np
import pytest

from tests.evidence.benchmark.made import planted
from tests.scenes import paper, scene
from vibsim.evidence.benchmark.bench_result import DONE, BenchRow, EventCount, faithful_error
from vibsim.evidence.benchmark.running import score, shortest_period
from vibsim.evidence.peers.solvers import CONTACTS, EVERY_KIND, Attempt

TIMES = [0.0, 1.0, 2.0, 3.0]


def attempt(x1, events=(), kinds=EVERY_KIND):
    states = np.zeros((len(x1), 4))
    states[:, 0] = x1
    return Attempt(states, float(len(x1) - 1), 1, 1, list(events), kinds)


def judged(x1, truth=(0, 0, 0, 0), events=(), found=(), kinds=EVERY_KIND):
    return score(attempt(x1, found, kinds), planted(TIMES, truth, events), scene().as_parts())


def test_the_error_is_that_of_the_displacements():
    np.testing.assert_allclose(judged([0, 2e-4, -5e-4, 3.0], (0, 1e-4, 0, 1.0)).error, [0, 1e-4, 5e-4, 2.0])


@pytest.mark.parametrize(
    ("x1", "until"),
    [
        ([0, 1e-4, 9e-4, 1e-3], 3.0),
        ([0, 1e-4, 2e-3, 0], 1.0),  # coming back does not count
        ([1.0, 0, 0, 0], 0.0),
        ([0, math.nan, 0, 0], 0.0),
        ([0, 0, 0], 2.0),  # ended early
    ],
)
def test_faithful_until(x1, until):
    found = judged(x1)
    assert found.faithful_time == until
    assert np.isnan(found.error[len(x1) :]).all()


@pytest.mark.parametrize(("largest", "allowed"), [(0.5, 1e-3), (4e-3, 2e-4), (0.0, 1e-3)])
def test_faithful_is_within_a_millimetre_or_a_twentieth_of_the_motion(largest, allowed):
    truth = planted(TIMES, [0, largest, -largest / 2, 0])
    assert faithful_error(truth, scene().as_parts()) == pytest.approx(allowed)


def test_events_count_until_the_run_is_lost():
    events = [(0.5, 1), (0.9, 2), (1.5, 1), (2.5, 2)]
    found = judged([0, 0, 1.0, 1.0], events=events, found=[(0.5, 1), (0.7, 1), (1.5, 1)])
    assert found.events["contact_begin"] == EventCount(1, 0, 1)
    assert found.events["contact_end"] == EventCount(0, 1, 0)


def test_only_what_a_method_reports_is_counted():
    assert set(judged([0, 0], kinds=CONTACTS).events) == set(CONTACTS)


def test_shortest_period():
    hertz = 1 / shortest_period(paper("I-A").as_parts())
    assert hertz == pytest.approx(34.397, abs=1e-3)  # k1 + k2 on the free pair
    assert shortest_period(scene(k1=0.0, k2=None, G=None).as_parts()) == math.inf


def test_error_until_is_the_largest_so_far():
    row = BenchRow("taylor", "", DONE, error=np.array([0, 3e-4, 1e-4, math.nan]))
    time = np.array(TIMES)
    assert [row.error_until(time, t) for t in (0.0, 1.0, 2.5)] == [0, 3e-4, 3e-4]
    assert math.isnan(row.error_until(time, 3.0))


def test_counts_of_all_kinds_add_up():
    row = BenchRow("taylor", "", DONE, events={"a": EventCount(1, 2, 3), "b": EventCount(4, 5, 6)})
    assert row.counted() == EventCount(5, 7, 9)
    assert BenchRow("taylor", "", DONE).counted() is None

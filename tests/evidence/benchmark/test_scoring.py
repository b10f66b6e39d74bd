"""Truths of a benchmark, and what is measured and scored against them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.evidence.benchmark.made import plan, planted, truth
from tests.scenes import fixed_block, paper, scene
from vibsim.engine.truth import open_truth
from vibsim.evidence.benchmark import running
from vibsim.evidence.benchmark.bench_result import DONE, FAILED, SLOWER, BenchRow, EventCount, faithful_error
from vibsim.evidence.benchmark.plan import OwnEngine, SolverFamily, family_of
from vibsim.evidence.benchmark.running import (
    MOST_RUNS,
    RIGHT,
    compute_truth,
    count_events,
    measure,
    score,
    shortest_period,
)
from vibsim.evidence.peers.solvers import CONTACTS, EVERY_KIND, Attempt, TimeLimit
from vibsim.physics.parts import EVENT_KINDS

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


# Planted events: found, missed, made up, shifted.


TRUE = [1.0, 2.0, 2.1, 5.0]
EVER = 1e9
BEGIN, END = EVENT_KINDS["contact_begin"], EVENT_KINDS["contact_end"]


def table(times, kinds=None):
    return {"t": np.array(times, dtype="f8"), "kind": np.array(kinds or [BEGIN] * len(times), dtype="i1")}


def counted(found, true=TRUE, until=EVER, widest=0.2):
    return count_events(table(true), [(t, BEGIN) for t in found], until, widest)["contact_begin"]


LIMITED, UNLIMITED, TWO = {"until": 3.0}, {"widest": 9.0}, {"true": [1.0, 1.0, 2.0]}


@pytest.mark.parametrize(
    ("found", "settings", "count"),
    [
        ([1.0, 2.0, 2.1, 5.0], {}, EventCount(4, 0, 0)),
        ([1.1, 2.04, 2.06, 4.9], {}, EventCount(4, 0, 0)),  # shifted within the windows
        ([1.0, 2.1, 5.0], {}, EventCount(3, 1, 0)),  # one missed
        ([1.0, 2.0, 2.1, 3.5, 5.0], {}, EventCount(4, 0, 1)),  # one made up
        ([1.0, 1.1, 2.0, 2.1, 5.0], {}, EventCount(4, 0, 1)),  # one twice
        ([1.3, 2.0, 2.1, 5.0], {}, EventCount(3, 1, 1)),  # too far: missed, and made up
        ([1.0, 2.03, 2.04, 5.0], {}, EventCount(3, 1, 1)),  # both nearer to 2.0 than to 2.1
        ([], {}, EventCount(0, 4, 0)),
        ([1.0, 2.1, 3.5, 4.0], LIMITED, EventCount(2, 1, 0)),  # only those up to the limit
        ([1.0, 2.1, 2.9, 4.0], LIMITED, EventCount(2, 1, 1)),
        ([5.1], {"until": 5.05}, EventCount(1, 3, 0)),  # found beyond it, and true before it
        ([1.4, 2.04, 2.06, 6.4], UNLIMITED, EventCount(4, 0, 0)),  # half way to the next of the kind
        ([1.6], UNLIMITED, EventCount(0, 4, 1)),
        ([1.01, 1.02, 2.0], TWO, EventCount(3, 0, 0)),  # those of two parts at one instant are two
        ([1.01, 2.0], TWO, EventCount(2, 1, 0)),
    ],
)
def test_planted_events(found, settings, count):
    assert counted(found, **settings) == count


def test_kinds_are_not_mistaken_for_each_other():
    counts = count_events(table([1.0, 1.01], [BEGIN, END]), [(1.0, BEGIN), (1.012, BEGIN)], EVER, 0.01)
    assert counts["contact_begin"] == EventCount(1, 0, 1)
    assert counts["contact_end"] == EventCount(0, 1, 0)


@given(
    true=st.lists(st.integers(0, 200), unique=True),
    found=st.lists(st.integers(0, 200)),
    until=st.integers(0, 200),
)
def test_every_event_is_counted_once(true, found, until):
    true, found = sorted(true), sorted(found)
    count = counted(found, true, widest=0.75)
    assert count.found + count.missed == len(true)
    assert count.found + count.spurious == len(found)
    up_to = counted(found, true, float(until), 0.75)
    assert up_to.found + up_to.missed == sum(t <= until for t in true)


@pytest.mark.parametrize("name", ["I-A", "II-B"])
def test_every_double_is_the_nearest_to_a_run_of_many_more_digits(name):
    found = truth(name, "3 s")
    blocks = list(open_truth(plan(name, "3 s").case.exact_scene, 60).blocks())
    for table in ("samples", "events"):
        for column, values in getattr(found, table).items():
            whole = np.concatenate([getattr(block, table)[column] for block in blocks])
            np.testing.assert_array_equal(values, whole)
    assert found.attrs["truth_digits_right"] >= RIGHT
    assert len(found.events["t"]) > 5


def test_digits_are_added_until_enough_are_right(monkeypatch):
    monkeypatch.setattr("vibsim.evidence.benchmark.running.error_growth", lambda scene: -20.0)
    monkeypatch.setattr("vibsim.evidence.benchmark.running.FEWEST", 20)
    found = compute_truth(plan("I-A", "3 s"))
    assert found.attrs["truth_digits"] > 20 and found.attrs["truth_digits_right"] >= RIGHT


def test_it_can_be_interrupted():
    assert compute_truth(plan(), lambda t: False) is None


class Failing:
    def __init__(self, scene):
        pass

    def run(self, times, limit):
        raise ArithmeticError("the step is too small\nand more")


FAILS = SolverFamily(
    "failing", "failing", "failing", "tests.evidence.benchmark.test_scoring:Failing", {}, [("as it is", {})]
)


def row(method, setting, limit=600.0, going_on=lambda: True, name="II-B"):
    scene = plan(name).case.scene()
    return measure(family_of(method), setting, scene, truth(name), limit, going_on)


def test_a_peer_is_timed_counted_and_judged():
    found = row("dop853", "rtol 1e-9")
    assert (found.status, found.problem, found.t_reached, found.faithful_time) == (DONE, "", 2.0, 2.0)
    assert found.wall_time > 0 and found.cpu_time > 0 and 1 <= found.runs <= MOST_RUNS
    assert found.evaluations > 5 * found.steps > 0
    assert 0 < found.error[-1] < 1e-9 and len(found.error) == 401
    true = np.isin(truth().events["kind"], [EVENT_KINDS[name] for name in EVERY_KIND])
    count = found.counted()
    assert (count.found, count.missed, count.spurious) == (np.count_nonzero(true), 0, 0)


def test_the_least_of_several_runs_counts(monkeypatch):
    """Runs that other processes disturb move no number: neither the first nor most of them."""
    clocks = iter([(1.0, 1.0), (0.2, 0.1), (0.02, 0.01), (0.15, 0.14), (0.2, 0.19)])  # setup, then runs [s]
    monkeypatch.setattr(running, "ENOUGH", 0.5)
    monkeypatch.setattr(running, "_timed", lambda call: (next(clocks), call()))
    found = row("dop853", "rtol 1e-9")
    assert (found.runs, found.wall_time, found.cpu_time) == (4, 0.02, 0.01)
    assert found.time_per_second == 0.01 / 2.0


def test_what_is_slow_is_stopped_and_judged_so_far():
    looks = iter(range(100))
    found = row("rk4", "step 0.5 ms", going_on=lambda: next(looks) < 60)
    assert found.status == SLOWER and 0 < found.t_reached < 2.0
    assert np.isfinite(found.error[0]) and math.isnan(found.error[-1])
    assert math.isnan(found.error_until(truth().samples["time"], 2.0))


def test_what_fails_says_so():
    found = measure(FAILS, "as it is", plan().case.scene(), truth(), 1.0, lambda: True)
    assert (found.status, found.problem) == (FAILED, "the step is too small")
    assert found.runs == 0 and np.isnan(found.error).all() and found.counted() is None


def test_vibsim_is_measured_like_its_peers():
    found = row("closed-form", "as by default", name="I-A")
    assert found.status == DONE and found.error[-1] < 1e-15 and found.evaluations == -1
    assert found.counted().missed == found.counted().spurious == 0


def test_states_are_those_of_the_bodies():
    scene = fixed_block(x1=1e-3, t_end=1.0).as_parts()
    attempt = OwnEngine(scene, "auto").run(np.array([0.0]), TimeLimit())
    assert attempt.states.shape == (201, 2) and abs(attempt.states[:, 1]).max() > 0.01

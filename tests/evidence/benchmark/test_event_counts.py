"""Planted events: found, missed, made up, shifted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.evidence.benchmark.bench_result import EventCount
from vibsim.evidence.benchmark.running import count_events
from vibsim.physics.parts import EVENT_KINDS

TRUE = [1.0, 2.0, 2.1, 5.0]
EVER = 1e9
BEGIN, END = EVENT_KINDS["contact_begin"], EVENT_KINDS["contact_end"]


def table(times, kinds=None):
    return {"t": np.array(times, dtype="f8"), "kind": np.array(kinds or [BEGIN] * len(times), dtype="i1")}


def counted(found, true=TRUE, until=EVER, widest=0.2):
    return count_events(table(true), [(t, BEGIN) for t in found], until, widest)["contact_begin"]


@pytest.mark.parametrize(
    ("found", "count"),
    [
        ([1.0, 2.0, 2.1, 5.0], EventCount(4, 0, 0)),
        ([1.1, 2.04, 2.06, 4.9], EventCount(4, 0, 0)),  # shifted within the windows
        ([1.0, 2.1, 5.0], EventCount(3, 1, 0)),  # one missed
        ([1.0, 2.0, 2.1, 3.5, 5.0], EventCount(4, 0, 1)),  # one made up
        ([1.0, 1.1, 2.0, 2.1, 5.0], EventCount(4, 0, 1)),  # one twice
        ([1.3, 2.0, 2.1, 5.0], EventCount(3, 1, 1)),  # too far: missed, and made up
        ([1.0, 2.03, 2.04, 5.0], EventCount(3, 1, 1)),  # both nearer to 2.0 than to 2.1
        ([], EventCount(0, 4, 0)),
    ],
)
def test_planted_events(found, count):
    assert counted(found) == count


def test_only_events_up_to_the_limit_count():
    assert counted([1.0, 2.1, 3.5, 4.0], until=3.0) == EventCount(2, 1, 0)
    assert counted([1.0, 2.1, 2.9, 4.0], until=3.0) == EventCount(2, 1, 1)


def test_a_true_event_beside_the_limit_may_be_found_beyond_it():
    assert counted([5.1], until=5.05) == EventCount(1, 3, 0)


def test_windows_end_half_way_to_the_next_of_the_kind():
    assert counted([1.4, 2.04, 2.06, 6.4], widest=9.0) == EventCount(4, 0, 0)
    assert counted([1.6], widest=9.0) == EventCount(0, 4, 1)


def test_events_of_two_parts_at_one_instant_are_two():
    assert counted([1.01, 1.02, 2.0], true=[1.0, 1.0, 2.0]) == EventCount(3, 0, 0)
    assert counted([1.01, 2.0], true=[1.0, 1.0, 2.0]) == EventCount(2, 1, 0)


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

"""Planted events: found, missed, made up, shifted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.benchmark.event_matching import EventCount, count_events, half_widths, match_times
from vibsim.physics.modes import EVENT_KINDS

TRUE = np.array([1.0, 2.0, 2.1, 5.0])
EVER = 100.0


def matched(found, until=EVER, widest=0.2):
    return match_times(TRUE, np.array(found, dtype="f8"), until, widest)


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
    assert matched(found) == count


def test_only_events_up_to_the_limit_count():
    assert matched([1.0, 2.1, 3.5, 4.0], until=3.0) == EventCount(2, 1, 0)
    assert matched([1.0, 2.1, 2.9, 4.0], until=3.0) == EventCount(2, 1, 1)


def test_a_true_event_beside_the_limit_may_be_found_beyond_it():
    assert matched([5.1], until=5.05) == EventCount(1, 3, 0)


def test_windows_end_half_way_to_the_neighbours():
    np.testing.assert_allclose(half_widths(TRUE, 0.2), [0.2, 0.05, 0.05, 0.2])
    np.testing.assert_allclose(half_widths(TRUE, 9.0), [0.5, 0.05, 0.05, 1.45])
    assert half_widths(np.empty(0), 1.0).shape == (0,)


def test_kinds_are_not_mistaken_for_each_other():
    begin, end = EVENT_KINDS["contact_begin"], EVENT_KINDS["contact_end"]
    true = {"t": np.array([1.0, 1.01]), "kind": np.array([begin, end], dtype="i1")}
    counts = count_events(true, [(1.0, begin), (1.012, begin)], EVER, 0.01)
    assert counts["contact_begin"] == EventCount(1, 0, 1)
    assert counts["contact_end"] == EventCount(0, 1, 0)


@given(
    true=st.lists(st.integers(0, 200), unique=True),
    found=st.lists(st.integers(0, 200)),
    until=st.integers(0, 200),
)
def test_every_event_is_counted_once(true, found, until):
    true, found = np.sort(np.array(true, dtype="f8")), np.sort(np.array(found, dtype="f8"))
    count = match_times(true, found, EVER + 200, 0.75)
    assert count.found + count.missed == len(true)
    assert count.found + count.spurious == len(found)
    up_to = match_times(true, found, float(until), 0.75)
    assert up_to.found + up_to.missed == np.count_nonzero(true <= until)

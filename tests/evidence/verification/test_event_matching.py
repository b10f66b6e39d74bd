"""Missed and spurious events are told from those that are only late."""

from decimal import Decimal
from math import inf

from vibsim.evidence.verification.checks import match_events, outside, reach

WITHIN = 0.1


def events(text):
    """ "a1 b2.5" -> [("a", 1), ("b", 2.5)]."""
    return [(word[0], Decimal(word[1:])) for word in text.split()]


def found(truth, run):
    truth, run = events(truth), events(run)
    matching = match_events(truth, [WITHIN] * len(truth), run)
    return matching.pairs, matching.missed, matching.spurious


def test_all_there():
    assert found("a1 b2 a3", "a1.05 b1.95 a3") == ([(0, 0), (1, 1), (2, 2)], [], [])


def test_one_missed():
    assert found("a1 a2 a3", "a1 a3") == ([(0, 0), (2, 1)], [1], [])


def test_one_spurious():
    assert found("a1 a3", "a1 a2 a3") == ([(0, 0), (1, 2)], [], [1])


def test_one_too_late_is_missed_and_spurious():
    assert found("a1 a2", "a1 a2.2") == ([(0, 0)], [1], [1])


def test_another_kind_at_the_same_time_is_not_it():
    assert found("a1", "b1") == ([], [0], [0])


def test_two_at_one_instant_have_no_order():
    assert found("a1 b1", "b1.01 a1.02") == ([(0, 1), (1, 0)], [], [])


def test_a_miss_does_not_shift_those_behind_it():
    pairs, missed, spurious = found("a1 a2 a3 a4 a5", "a2 a3 a4 a5 a6")
    assert (len(pairs), missed, spurious) == (4, [0], [4])


def test_reach_is_half_way_to_the_next_of_a_kind():
    assert reach(events("a1 b2 a5 a6 b9")) == [2.0, 3.5, 0.5, 0.5, 3.5]
    assert reach(events("a1 b2")) == [inf, inf]


def test_what_is_undecided_is_left_out():
    windows = [(Decimal("1.5"), Decimal("2.5"))]
    assert outside(events("a1 a2 b2.5 a3"), windows) == events("a1 a3")

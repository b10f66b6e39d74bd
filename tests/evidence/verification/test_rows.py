"""A row passes where its error is within its bound, and nothing else passes."""

from math import inf, nan

import pytest

from vibsim.evidence.verification import CheckPoint, CheckRow
from vibsim.evidence.verification.checks import compared, counted_row, number_row, worst_row


def row(error, bound):
    return CheckRow("V0", "x", "1", "1", error, bound, "m", "no reason")


@pytest.mark.parametrize(("error", "bound"), [(0.0, 0.0), (1.0, 1.0), (1e-300, 1e-299), (3.0, inf)])
def test_within(error, bound):
    assert row(error, bound).passed


@pytest.mark.parametrize(
    ("error", "bound"), [(1.0, 0.999), (1e-320, 0.0), (nan, 1.0), (inf, 1.0), (1.0, nan)]
)
def test_beyond(error, bound):
    assert not row(error, bound).passed


def test_a_number_says_what_was_expected_and_obtained():
    found = number_row("V0", compared("time", 2.0, 2.5, 1.0, "s"), "half")
    assert (found.name, found.expected, found.obtained, found.error) == ("V0: time", "2 s", "2.5 s", 0.5)
    assert found.passed


def test_a_count_must_be_right():
    assert counted_row("V0", "impacts", 7, 7, "exact").passed
    assert not counted_row("V0", "impacts", 7, 8, "exact").passed


@pytest.mark.parametrize(
    ("points", "worst"),
    [
        ([(1.0, 10.0), (0.1, 0.2), (5.0, 100.0)], 1),  # half of its bound, where others use a tenth
        ([(1.0, 10.0), (0.0, 0.0)], 0),  # no error is no part of no bound
        ([(1.0, 10.0), (1e-9, 0.0)], 1),
        ([(9.0, 10.0), (nan, 10.0), (1.0, 10.0)], 1),
    ],
)
def test_the_worst_point_stands_for_all(points, worst):
    made = [CheckPoint(f"x{i}", 0.0, 0.0, *pair) for i, pair in enumerate(points)]
    assert worst_row("V0", made, "no reason").what == f"x{worst}"
    assert worst_row("V0", made, "no reason").points == tuple(made)


def test_nothing_compared_is_an_error():
    with pytest.raises(ValueError, match="max"):
        worst_row("V0", [], "no reason")

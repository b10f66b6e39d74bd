"""What a misspelt word most likely stands for, and what it does not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.cases.reading.sources import shipped_case_names
from vibsim.cases.spelling import nearest, slips
from vibsim.cases.values.units import UNITS
from vibsim.command_line.main import COMMANDS

WORDS = st.text("abc-", max_size=6)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("rnu", "run"),
        ("INFO", "info"),
        ("analyze", "analyse"),
        ("comapre", "compare"),
        ("sweeep", "sweep"),
        ("anal", "analyse"),
        ("benchmark", "bench"),
        ("nosuch", None),
        ("completion", None),
        ("help", None),
        ("c", None),
        ("", None),
    ],
)
def test_commands(typed, meant):
    assert nearest(typed, COMMANDS) == meant


@pytest.mark.parametrize(
    ("typed", "meant"), [("IIB", "II-B"), ("ii-b", "II-B"), ("II_C", "II-C"), ("X", None)]
)
def test_cases(typed, meant):
    assert nearest(typed, shipped_case_names()) == meant


@pytest.mark.parametrize(
    ("typed", "meant"), [("herz", "Hz"), ("mm^2", "mm"), ("rad/sec", "rad/s"), ("qq", None)]
)
def test_units(typed, meant):
    assert nearest(typed, filter(None, UNITS)) == meant


@pytest.mark.parametrize(
    ("a", "b", "distance"),
    [("", "abc", 3), ("kitten", "sitting", 3), ("ab", "ba", 1), ("ca", "abc", 3), ("run", "run", 0)],
)
def test_published_distances(a, b, distance):
    assert slips(a, b) == distance


@given(WORDS, WORDS, st.sampled_from("abc-"))
def test_the_distance_is_symmetric_and_a_letter_costs_one(a, b, letter):
    assert slips(a, b) == slips(b, a)
    assert slips(a, a + letter) == 1
    assert abs(len(a) - len(b)) <= slips(a, b) <= max(len(a), len(b))

"""Ranges: counted in exact decimals."""

from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibsim.cases import RangeError, load_case, parse_range

HOW = "write FROM:TO:STEP, FROM:TO/COUNT, 'log FROM:TO/COUNT' or A,B,C, with a unit at the end"
BY_RATIO = "a range by ratio is 'log FROM:TO/COUNT', such as 'log 1:1000/31 N/m'"


def texts(text, **options):
    return [value.text for value in parse_range(text, **options)]


def test_the_sweep_of_the_paper_has_81_exact_values():
    values = parse_range("3:7:0.05", bare_unit="Hz")
    assert len(values) == 81
    assert [value.value for value in values] == [3 + Fraction(i, 20) for i in range(81)]
    assert [value.text for value in values][:3] == ["3 Hz", "3.05 Hz", "3.1 Hz"]
    assert values[-1].text == "7 Hz"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1:2:0.5", ["1", "1.5", "2"]),
        ("0:0.3:0.1", ["0", "0.1", "0.2", "0.3"]),  # 0.3 / 0.1 < 3 in doubles
        ("1:2:0.4", ["1", "1.4", "1.8"]),
        ("2:1:0.5", ["2", "1.5", "1"]),
        ("2:1:-0.5", ["2", "1.5", "1"]),
        ("-1:1:1", ["-1", "0", "1"]),
        ("1:1:1", ["1"]),
        ("1:2:5", ["1"]),
        ("1e-8:3e-8:1e-8", ["1e-8", "2e-8", "3e-8"]),
        ("3:7/5", ["3", "4", "5", "6", "7"]),
        ("7:3/3", ["7", "5", "3"]),
        ("0:1/4", ["0", "1/3", "2/3", "1"]),
        ("1,2,3", ["1", "2", "3"]),
        ("3, 1, 3", ["3", "1", "3"]),
        ("5", ["5"]),
        ("1/3", ["1/3"]),
        ("3:3.2:0.1 Hz", ["3 Hz", "3.1 Hz", "3.2 Hz"]),
        ("3Hz:3.2Hz:0.1Hz", ["3 Hz", "3.1 Hz", "3.2 Hz"]),
        ("1:2:0.5mm", ["1 mm", "1.5 mm", "2 mm"]),
        ("20:21/2 rad/s", ["20 rad/s", "21 rad/s"]),
        ("1 mm, 2 mm", ["1 mm", "2 mm"]),
        ("1, 2 mm", ["1 mm", "2 mm"]),
        ("1 mm, 2 cm", ["1 mm", "2 cm"]),
        ("log 1:1000/4 N/m", ["1 N/m", "10 N/m", "100 N/m", "1000 N/m"]),
        ("log 1000:1/4", ["1000", "100", "10", "1"]),
        ("log 1:2/3", ["1", "1.4142135623731", "2"]),  # 1.41421356237310 to 15 digits
        (" log  0.1mm:10/5 ", ["0.1 mm", "0.316227766016838 mm", "1 mm", "3.16227766016838 mm", "10 mm"]),
        ("1,2 N*s/m", ["1 N s/m", "2 N s/m"]),
    ],
)
def test_values(text, expected):
    assert texts(text) == expected


def test_a_bare_unit_is_for_ranges_without_a_unit():
    assert texts("1:2:1", bare_unit="Hz") == ["1 Hz", "2 Hz"]
    assert texts("1,2", bare_unit="Hz") == ["1 Hz", "2 Hz"]
    assert texts("60:120:60 rpm", bare_unit="Hz") == ["60 rpm", "120 rpm"]
    assert texts("1, 2 rpm", bare_unit="Hz") == ["1 rpm", "2 rpm"]


def test_one_unit_may_stand_anywhere_in_a_range():
    assert texts("0:2mm/5") == texts("0mm:2/5") == ["0 mm", "0.5 mm", "1 mm", "1.5 mm", "2 mm"]
    assert texts("0:2 mm / 5") == texts("0:2/5 mm") == texts("0:2 mm:0.5")
    assert texts("3 Hz:4:1") == ["3 Hz", "4 Hz"]
    assert texts("0:1 N/m/2") == texts("0:1/2 N/m") == ["0 N/m", "1 N/m"]


@pytest.mark.parametrize(
    ("text", "message"),
    [("", "the range is empty"), ("a:b:c", f"a:b:c is no range; {HOW}"),
     ("1:2:3:4", f"1:2:3:4 is no range; {HOW}"),
     ("1:2", "1:2 has no step; write it as FROM:TO:STEP or FROM:TO/COUNT"),
     ("1, 2/0", "division by zero in 1, 2/0"), ("1/2:2:1", f"1/2:2:1 is no range; {HOW}"),
     ("1:2:0", "1:2:0: the step must not be 0"),
     ("1:2:-0.1", "1:2:-0.1: the step leads away from 2; leave its sign out"),
     ("1:2/1", "1:2/1: at least 2 values are needed, got 1"),
     ("1:2/0", "1:2/0: at least 2 values are needed, got 0"), ("1,,2", "an empty item in the list 1,,2"),
     ("1,2,", "an empty item in the list 1,2,"),
     ("1:1e9:1", "1:1e9:1 has 1e+09 values; at most 1,000,000 are allowed"),
     ("0:1/2000000", "0:1/2000000 has 2e+06 values; at most 1,000,000 are allowed"),
     ("0:1:1e-999999999", "does not fit double precision (2.3e-308 to 2.2e307), got 1e-999999999"),
     ("1:2:0.1 herz", "unknown unit herz in the range 1:2:0.1 herz (did you mean Hz?)"),
     ("1 mm:2 cm:1 mm", "1 mm:2 cm:1 mm: write one unit, at the end, such as 3:7:0.05 Hz"),
     ("1 mm, 2", "1 mm, 2: write one unit for all values, or one behind each"),
     ("1 mm, 2, 3 cm", "1 mm, 2, 3 cm: write one unit for all values, or one behind each"),
     ("log 1:2", f"log 1:2: {BY_RATIO}"), ("log 1:2:0.1", f"log 1:2:0.1: {BY_RATIO}"),
     ("log 1,2", f"log 1,2: {BY_RATIO}"), ("log", f"log: {BY_RATIO}"),
     ("log1:2/3", f"log1:2/3 is no range; {HOW}"),
     ("log 0:1/3", "log 0:1/3: both ends of a range by ratio must be above 0"),
     ("log 1:-1/3", "log 1:-1/3: both ends of a range by ratio must be above 0"),
     ("log 1:2/1", "log 1:2/1: at least 2 values are needed, got 1"),
     ("log 1:2/2000000", "log 1:2/2000000 has 2e+06 values; at most 1,000,000 are allowed"),
     ("log 1 mm:2 cm/3", "log 1 mm:2 cm/3: write one unit, at the end, such as 3:7:0.05 Hz"),
     ("nan", f"nan is no range; {HOW}")],
)  # fmt: skip
def test_what_is_wrong(text, message):
    with pytest.raises(RangeError) as caught:
        parse_range(text)
    assert str(caught.value) == message


@given(
    st.decimals(min_value=-1000, max_value=1000, places=3),
    st.decimals(min_value=-1000, max_value=1000, places=3),
    st.decimals(min_value="0.5", max_value=100, places=3),
)
def test_steps_are_exact_and_stay_inside(a, b, h):
    values = [value.value for value in parse_range(f"{a}:{b}:{h}")]
    low, high = min(a, b), max(a, b)
    assert values[0] == Fraction(a)
    assert all(Fraction(low) <= value <= Fraction(high) for value in values)
    assert {abs(y - x) for x, y in pairwise(values)} <= {Fraction(h)}
    assert abs(Fraction(b) - values[-1]) < Fraction(h)


@given(st.integers(-1000, 1000), st.integers(-1000, 1000), st.integers(2, 200))
def test_spaced_values_include_both_ends(a, b, n):
    values = [value.value for value in parse_range(f"{a}:{b}/{n}")]
    assert (len(values), values[0], values[-1]) == (n, a, b)


@given(st.integers(1, 10**6), st.integers(1, 10**6), st.integers(2, 60))
def test_values_by_ratio_are_powers_of_one_number(a, b, n):
    """The i-th to the power n - 1 is a^(n-1-i) b^i, within n - 1 times the half digit of its rounding."""
    values = [value.value for value in parse_range(f"log {a}:{b}/{n}")]
    assert (len(values), values[0], values[-1]) == (n, a, b)
    for i, value in enumerate(values):
        exact = Fraction(a) ** (n - 1 - i) * Fraction(b) ** i
        assert abs(value ** (n - 1) / exact - 1) <= (n - 1) * Fraction(501, 10**17)


def test_texts_of_a_range_go_into_a_case():
    case = load_case("II-B")
    for value in parse_range("3:4/4 Hz"):
        assert case.with_values({"Omega0": value.text}).quantity("Omega0").value == value.value
